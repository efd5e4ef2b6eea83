"""What the panel asks for: kept in the scene, so in the file; and the add-on's preferences."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty

kMeshTypes = ("MESH", "CURVE", "SURFACE", "FONT", "META")


def can_be_morphed(_, thing):
    return thing.type == "VOLUME" or thing.type in kMeshTypes


class SLICEMORPH_PG_input(bpy.types.PropertyGroup):
    thing: PointerProperty(type=bpy.types.Object, name="Object", poll=can_be_morphed)


class SLICEMORPH_PG_settings(bpy.types.PropertyGroup):
    inputs: CollectionProperty(type=SLICEMORPH_PG_input)
    active: IntProperty(name="Active input")
    frames: IntProperty(
        name="Frames", default=24, min=1, max=100000,
        description="Frames of the morph, from the scene's start frame on; the first and the last are the inputs")
    method: EnumProperty(
        name="Method", default="slices",
        items=[("slices", "Slices", "Matched slices: slicemorph's own"),
               ("sdf", "Distances", "Blends distances point by point"),
               ("levelset", "Level set", "Moves the surface to the nearest; of two inputs"),
               ("dissolve", "Dissolve", "Blends values where they are")])
    resolution: IntProperty(
        name="Resolution", default=0, min=0, max=4096,
        description="Voxels along the longest side of each object, 8 or more; 0: 256, and volumes keep their own")
    fit: EnumProperty(
        name="Fit", default="none",
        items=[("none", "None", "Sizes and places as they are"),
               ("size", "Size", "All get the first one's size"),
               ("box", "Box", "All get the first one's size and place")])
    align: BoolProperty(
        name="Turn to match", default=True,
        description="Objects are turned onto each other where that matches far better; off: directions as they are")
    result: EnumProperty(
        name="Result", default="VOLUME",
        items=[("VOLUME", "Volume sequence", "A VDB file a frame, with velocities for motion blur"),
               ("MESH_CACHE", "Mesh cache", "A mesh a frame, each with its own topology"),
               ("SHAPE_KEYS", "Shape keys",
                "One mesh with a shape key a frame; several, each shown in its own frames, where one does not do")])
    marks: BoolProperty(
        name="Empties are marks", default=True,
        description="Empties that are children of the inputs and have one name (but for .001) on all of them are "
                    "places that belong together")
    folder: StringProperty(name="Folder", default="//slicemorph", subtype="DIR_PATH",
                           description="Where the files of the result go")
    name: StringProperty(name="Name", default="morph", description="Of the result: of files and objects")
    more: StringProperty(name="More options",
                         description="Further options of `slicemorph morph`, as on its command line")


class SLICEMORPH_AP_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", subtype="FILE_PATH",
                            description="The program slicemorph; empty: beside the add-on, else as on the PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


def preferences():
    """The add-on's preferences; None where it runs without being enabled in them, as from a script."""
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


def add_properties():
    bpy.types.Scene.slicemorph = PointerProperty(type=SLICEMORPH_PG_settings)


def remove_properties():
    del bpy.types.Scene.slicemorph


kClasses = (SLICEMORPH_PG_input, SLICEMORPH_PG_settings, SLICEMORPH_AP_preferences)
