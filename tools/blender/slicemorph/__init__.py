"""Morphs objects and volumes of a scene into each other, by the program slicemorph.

Blender 4.2 and later read blender_manifest.toml, earlier ones bl_info.
"""

bl_info = {
    "name": "Slicemorph",
    "author": "slicemorph maintainers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Slicemorph",
    "description": "Morphs meshes and volumes into each other",
    "category": "Animation",
}

import bpy

from . import jobs, operators, panel, settings

kClasses = settings.kClasses + operators.kClasses + panel.kClasses


def register():
    for one in kClasses:
        bpy.utils.register_class(one)
    settings.add_properties()


def unregister():
    jobs.abandon()
    settings.remove_properties()
    for one in reversed(kClasses):
        bpy.utils.unregister_class(one)
