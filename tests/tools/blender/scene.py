"""What the cases of addon_cases.py share: they run inside Blender."""
import math
import sys

import bpy
import numpy as np
from mathutils import Matrix

CASE, ZIP, FOLDER, REPOSITORY = sys.argv[sys.argv.index("--") + 1:]
FRAMES, START, RESOLUTION = 8, 5, 40
RESULTS = ("VOLUME", "MESH_CACHE", "SHAPE_KEYS")


def begin():
    """An empty scene with the add-on and quick settings; returns these."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_install(filepath=ZIP)
    bpy.ops.preferences.addon_enable(module="slicemorph")
    scene = bpy.context.scene
    scene.frame_start = START
    asked = scene.slicemorph
    asked.frames, asked.resolution, asked.folder = FRAMES, RESOLUTION, FOLDER + "/out"
    return asked


def bundled(name, matrix):
    bpy.ops.import_mesh.ply(filepath="%s/assets/%s.ply" % (REPOSITORY, name))
    bpy.context.object.matrix_world = matrix
    return bpy.context.object


def upright(x=0.0, y=0.0, z=0.0, scale=1.0):
    """The bundled shapes stand along y."""
    return Matrix.Translation((x, y, z)) @ Matrix.Rotation(math.pi / 2, 4, "X") @ Matrix.Scale(scale, 4)


def listed(asked, *things):
    asked.inputs.clear()
    for thing in things:
        asked.inputs.add().thing = thing


def morph(asked, result):
    """The objects of the result."""
    asked.result, asked.name = result, result.lower()
    before = set(bpy.context.scene.objects)
    assert bpy.ops.slicemorph.morph(wait=True) == {"FINISHED"}
    return [thing for thing in bpy.context.scene.objects if thing not in before]


def points_of(thing):
    """World positions of what a modifier stack makes."""
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    points = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", points)
    evaluated.to_mesh_clear()
    matrix = np.array(evaluated.matrix_world)
    return points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


def bounds_of(points):
    return np.array([points.min(0), points.max(0)])


def surface_of(thing):
    """A mesh of a volume's level set, by Blender's own modifier."""
    mesh = bpy.data.objects.new("looker", bpy.data.meshes.new("looker"))
    bpy.context.scene.collection.objects.link(mesh)
    modifier = mesh.modifiers.new("mesh", "VOLUME_TO_MESH")
    modifier.object, modifier.grid_name, modifier.threshold = thing, "surface", 0
    return mesh


def bounds_over_time(things):
    """[frame] low and high corner of what is shown, in the world; in each frame one object is."""
    lookers = {thing: surface_of(thing) if thing.type == "VOLUME" else thing for thing in things}
    over_time = []
    for frame in range(START, START + FRAMES):
        bpy.context.scene.frame_set(frame)
        shown = [thing for thing in things if not thing.hide_render]
        assert len(shown) == 1 and shown[0].hide_viewport == shown[0].hide_render, (frame, shown)
        over_time.append(bounds_of(points_of(lookers[shown[0]])))
    return np.array(over_time)


def blur_length(width, shutter, pixels=200):
    """Length, in the world, of what a moving edge along x is smeared to, from a picture that is `width` wide.

    Along a smeared edge the coverage a rises evenly over the length L: the integral of a (1 - a) is L / 6, twice.
    """
    scene = bpy.context.scene
    render = scene.render
    render.use_motion_blur, render.motion_blur_shutter = shutter > 0, shutter or 0.5
    render.filepath = "%s/blur_%g.png" % (FOLDER, shutter)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    coverage = np.array(image.pixels).reshape(pixels // 10, pixels, 4)[:, :, 3].mean(0)
    return 3 * (coverage * (1 - coverage)).sum() * width / pixels


def look_along_y(width, pixels=200):
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.data.type, camera.data.ortho_scale = "ORTHO", width
    camera.matrix_world = Matrix.Translation((0, -10, 0)) @ Matrix.Rotation(math.pi / 2, 4, "X")
    scene.camera = camera
    render = scene.render
    render.engine, render.film_transparent = "CYCLES", True
    render.resolution_x, render.resolution_y, render.image_settings.color_mode = pixels, pixels // 10, "RGBA"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 32, False, False


def check_blur(asked, result):
    """Balls of radius 1 go from x = -3 to 3, 0.75 a frame, at 25 frames per second: blur is the way while the shutter is open."""
    asked.frames = 9
    bpy.context.scene.render.fps = 25
    look_along_y(4)
    made = morph(asked, result)
    for thing in bpy.context.scene.objects:
        thing.hide_render = thing.hide_render or thing not in made
    bpy.context.scene.frame_set(START + 4)
    sharp = blur_length(4, 0)
    for shutter in (0.5, 1):
        length, way = blur_length(4, shutter), 0.75 * shutter
        print("  %s: sharp %.3f, shutter %g: blur %.3f, way %.3f" % (result, sharp, shutter, length, way))
        assert abs(length / way - 1) < 0.1 and sharp < 0.1 * way


def mark(parent, name, place):
    empty = bpy.data.objects.new(name, None)
    empty.parent = parent
    empty.location = place
    bpy.context.scene.collection.objects.link(empty)
