"""Runs inside Blender: opens a VDB sequence as an artist does, prints what Blender reads, renders one frame.

check_blender.sh starts it. Anything that Blender cannot use is an error with exit code 1. Coordinates are world
units, turned from the files' "y up" to Blender's "z up" by the objects' rotation, not in the data.
"""

import argparse
import math
import pathlib
import re
import struct
import sys
import tempfile

import bpy
import numpy
import pyopenvdb
from mathutils import Matrix, Vector

kSize = (640, 360)
kOpticalDepth = 10.0  # straight through the densest part: opaque inside, translucent at the rim
kVisible = 0.01  # of the highest density; thinner smoke does not count as extent
kLit = 0.2  # brightness that the backdrop stays below
kFramed = 2000  # points that the camera is fitted to, per frame
kIncandescent = 700.0  # temperatures that reach this are kelvin; below it they are some 0-to-1 field
kHottest = 2000.0  # kelvin; shown where such a field is highest
kLookAlong = Vector((-0.55, -0.3, -1.0))  # y up; the default view of `slicemorph render`
kWarm, kCool = (1.0, 0.93, 0.85), (0.72, 0.83, 1.0)  # light
kVectorGrids = ("vel", "velocity", "color", "Cd")


class Unusable(Exception):
    """What is wrong with the files, in one line."""


def parse_arguments():
    parser = argparse.ArgumentParser(prog="check_blender")
    parser.add_argument("first", type=pathlib.Path, metavar="NAME.0001.vdb")
    parser.add_argument("picture", type=pathlib.Path, metavar="OUT.png")
    parser.add_argument("frame", type=int, nargs="?", metavar="FRAME")
    parser.add_argument("--surface", default="surface", metavar="GRID", help="name of the level set")
    parser.add_argument("--up", choices=("y", "z"), default="y", help="the files' way up (%(default)s)")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])


# ---- the sequence

def find_frames(first):
    """{number: file} from `first` on; without a number in the name, that one file as frame 1."""
    if not first.is_file():
        raise Unusable(f"{first} is not there")
    number = re.search(r"(\d+)(\D*)$", first.stem)
    if not number:
        return {1: first}
    head, tail = first.stem[:number.start(1)], number[2] + first.suffix
    # Blender pads with zeros to as many digits as the first file has.
    pattern = re.compile(re.escape(head) + rf"(\d{{{len(number[1])},}})" + re.escape(tail))
    frames = {}
    for file in first.parent.iterdir():
        match = pattern.fullmatch(file.name)
        if match and int(match[1]) >= int(number[1]):
            frames[int(match[1])] = file
    missing = sorted(set(range(min(frames), max(frames) + 1)) - set(frames))
    if missing:
        raise Unusable(f"{first}: the sequence goes to {max(frames)}, but frame {missing[0]} is not there")
    return frames


def check_whole(file):
    """Refuses a file that was cut short: OpenVDB reads arbitrary sizes of it, and Blender aborts much later.

    The layout is that of openvdb/io/Archive.cc and File.cc; other files are left to Blender.
    """
    size = file.stat().st_size
    with open(file, "rb") as data:
        def read(form):
            return struct.unpack("<" + form, data.read(struct.calcsize("<" + form)))[0]

        def skip_string():
            data.seek(read("I"), 1)

        try:
            if data.read(8) != b" BDV\0\0\0\0" or read("I") < 222:
                return
            data.seek(8, 1)  # library version
            if not read("?"):  # no offsets: the file was written as a stream
                return
            data.seek(36, 1)  # UUID
            for _ in range(read("I")):  # metadata: name, type, value
                skip_string(), skip_string(), skip_string()
            for _ in range(read("I")):  # grids: name, type, parent; where transform, voxels and end are
                skip_string(), skip_string(), skip_string()
                data.seek(16, 1)
                end = read("q")
                if end > size:
                    raise Unusable(f"{file}: cut off: {size} bytes, but a grid in it ends at {end}")
                data.seek(end)
        except struct.error:
            raise Unusable(f"{file}: cut off: {size} bytes, which end within the list of its grids") from None


def add_volume(frames, rotation):
    volume = bpy.data.volumes.new("sequence")
    volume.filepath = str(frames[min(frames)].resolve())
    if len(frames) > 1:
        # Scene frame = number in the file's name.
        volume.is_sequence = True
        volume.frame_start = min(frames)
        volume.frame_duration = len(frames)
        volume.frame_offset = min(frames) - 1
    thing = bpy.data.objects.new("sequence", volume)
    thing.matrix_world = rotation
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = min(frames), max(frames)
    return thing


def load_frame(volume, frame, file):
    """Loads every grid of the frame, voxels too; {name: grid}."""
    print(f"frame {frame}: reading {file}", flush=True)
    check_whole(file)
    bpy.context.scene.frame_set(frame)
    grids = volume.grids
    if not grids.load():
        raise Unusable(f"{file}: Blender cannot load it: {grids.error_message}")
    if pathlib.Path(grids.frame_filepath).resolve() != file.resolve():
        raise Unusable(f"{file}: Blender took {grids.frame_filepath or 'no file'} for frame {frame}")
    if not len(grids):
        raise Unusable(f"{file}: no grids")
    for grid in grids:
        if not grid.load() or grids.error_message:
            raise Unusable(f"{file}: grid {grid.name}: Blender cannot load it: {grids.error_message}")
    by_name = {grid.name: grid for grid in grids}
    if len(by_name) < len(grids):
        raise Unusable(f"{file}: several grids have the same name, Blender takes the first: "
                       + ", ".join(grid.name for grid in grids))
    return by_name


def check_types(grids, shown, file):
    for name in (shown, "temperature", "flame", *kVectorGrids):
        wanted = "VECTOR_FLOAT" if name in kVectorGrids else "FLOAT"
        if name in grids and grids[name].data_type != wanted:
            raise Unusable(f"{file}: grid {name} is {grids[name].data_type}, not {wanted}")


def print_grids(grids):
    for name, grid in grids.items():
        rows = " ".join("[" + " ".join(f"{x:.6g}" for x in row) + "]" for row in grid.matrix_object)
        print(f"  {name}: {grid.data_type}, matrix {rows}")


def load_sequence(volume, frames, surface):
    """Loads every frame; returns the name of the grid to show, and the grids that all frames have."""
    common = None
    for frame, file in frames.items():
        grids = load_frame(volume, frame, file)
        shown = next((name for name in ("density", surface) if name in grids), None)
        if shown is None or (common is not None and shown not in common):
            raise Unusable(f"{file}: neither density nor {surface} is among its grids: {', '.join(grids)}"
                           if shown is None else f"{file}: has {shown}, which the frames before have not")
        check_types(grids, shown, file)
        if common is None or set(grids) != common:
            print_grids(grids)
        common = set(grids) if common is None else common & set(grids)
    return shown, common


# ---- what is to be seen

def box_corners(grid, low, high):
    """The index box's eight corners in world space."""
    return [Vector(grid.transform.indexToWorld((x, y, z)))
            for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]


def some(points):
    """An even selection of N x 3 points, enough to fit the camera to all."""
    return points[::max(1, len(points) // kFramed)]


def bounds(points):
    return numpy.min(points, 0), numpy.max(points, 0)


class Fog:
    """Extent (of the visible part, world units) and thickness of a scalar grid; no corners if it is empty."""

    def __init__(self, file, name):
        grid = pyopenvdb.read(str(file), name)
        self.corners, self.points, self.highest, self.column = [], [], 0.0, 0.0
        low, high = grid.evalActiveVoxelBoundingBox()
        if low[0] > high[0]:
            return
        values = numpy.zeros([b - a + 1 for a, b in zip(low, high)], numpy.float32)
        grid.copyToArray(values, ijk=low)
        if not numpy.isfinite(values).all():
            raise Unusable(f"{file}: grid {name} has values that are not finite")
        self.highest = float(values.max())
        seen = numpy.argwhere(values > kVisible * self.highest)
        if self.highest <= 0 or not len(seen):
            return
        ends = (seen.min(0) + low - 0.5, seen.max(0) + low + 0.5)
        self.corners = box_corners(grid, *ends)
        self.points = [Vector(grid.transform.indexToWorld(tuple(map(float, low + voxel)))) for voxel in some(seen)]
        # The integral of the values along the thickest lines, mean of the three directions.
        edges = [self.corners[k] - self.corners[0] for k in (4, 2, 1)]
        steps = [edge.length / count for edge, count in zip(edges, ends[1] - ends[0])]
        positive = numpy.maximum(values, 0)
        lines = [positive.sum(axis).ravel() * steps[axis] for axis in range(3)]
        self.column = float(numpy.mean([numpy.percentile(line[line > 0], 99) for line in lines]))


def check_velocity_reach(file, name, fog, seconds):
    """Reports where Cycles cannot blur: velocity must be active where smoke
    arrives, too, since it is read there."""
    grid = pyopenvdb.read(str(file), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    if low[0] > high[0]:
        print(f"note: {file}: {name} is zero everywhere: no motion blur")
        return
    values = numpy.zeros([b - a + 1 for a, b in zip(low, high)] + [3], numpy.float32)
    grid.copyToArray(values, ijk=low)
    path = numpy.abs(values).max((0, 1, 2)) * seconds / 2
    covered = bounds(box_corners(grid, numpy.subtract(low, 0.5), numpy.add(high, 0.5)))
    seen = bounds(fog.corners)
    margin = numpy.minimum(seen[0] - covered[0], covered[1] - seen[1])
    if (margin < path).any():
        print(f"note: {file}: {name} ends {numpy.round(margin, 3)} outside the smoke, which moves up to "
              f"{numpy.round(path, 3)} while the shutter is open: its rim is not blurred there")


def mesh_from_level_set(volume_object, name):
    """The object with Blender's Volume to Mesh modifier."""
    thing = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    bpy.context.scene.collection.objects.link(thing)
    modifier = thing.modifiers.new("Volume to Mesh", "VOLUME_TO_MESH")
    modifier.object = volume_object
    modifier.grid_name = name
    modifier.threshold = 0.0
    modifier.use_smooth_shade = True
    volume_object.hide_render = True
    return thing


def measure_mesh(thing, frame, file):
    """World-space points to fit the camera to; raises Unusable for an empty or inside-out mesh."""
    bpy.context.scene.frame_set(frame)
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        raise Unusable(f"{file}: Volume to Mesh finds no surface in {thing.name}")
    points = numpy.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    triangles = numpy.empty(3 * len(mesh.loop_triangles), int)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    a, b, c = points[triangles.reshape(-1, 3)].transpose(1, 0, 2)
    volume = float((a * numpy.cross(b, c)).sum() / 6)
    size = " x ".join(f"{x:.4g}" for x in points.max(0) - points.min(0))
    print(f"frame {frame}: Volume to Mesh: {len(points)} vertices, {size}, volume {volume:.4g}")
    if volume <= 0:
        raise Unusable(f"{file}: the mesh is inside out: the grid's class is not `level set`, or its sign is wrong")
    evaluated.to_mesh_clear()
    return [evaluated.matrix_world @ Vector(point) for point in some(points)]


# ---- materials

def new_material(name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree.nodes, material.node_tree.links


def smoke_material(thickest, extent, names, heat):
    """Principled Volume; `heat`: (grid's name, its highest value) or None; `extent`: world units."""
    material, nodes, links = new_material("smoke")
    output = nodes.new("ShaderNodeOutputMaterial")
    shader = nodes.new("ShaderNodeVolumePrincipled")
    links.new(shader.outputs["Volume"], output.inputs["Volume"])
    inputs = shader.inputs
    inputs["Density Attribute"].default_value = "density"
    inputs["Density"].default_value = kOpticalDepth / thickest
    inputs["Anisotropy"].default_value = 0.25
    color = next((name for name in ("color", "Cd") if name in names), "")
    inputs["Color Attribute"].default_value = color
    inputs["Color"].default_value = (1, 1, 1, 1) if color else (0.86, 0.87, 0.89, 1)
    inputs["Temperature Attribute"].default_value = ""
    if heat:
        if not color:
            inputs["Color"].default_value = (0.55, 0.55, 0.56, 1)  # soot, for the glow to stand out
        name, highest = heat
        hottest = highest if highest >= kIncandescent else kHottest
        inputs["Temperature Attribute"].default_value = name
        inputs["Temperature"].default_value = hottest / highest
        # The Stefan-Boltzmann law in Cycles' units; the radiance through the hottest part becomes about 50.
        inputs["Blackbody Intensity"].default_value = 50 * math.pi * 1e6 / (5.670373e-8 * hottest**4 * extent)
    return material


def clay_material():
    material, nodes, links = new_material("clay")
    output = nodes.new("ShaderNodeOutputMaterial")
    shader = nodes.new("ShaderNodeBsdfPrincipled")
    links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    shader.inputs["Base Color"].default_value = (0.62, 0.57, 0.5, 1)
    shader.inputs["Roughness"].default_value = 0.45
    return material


# ---- camera and light

def add_camera(points, rotation, margin):
    """A camera that sees all the points (world space) along kLookAlong, `margin` times the distance away."""
    forward = (rotation.to_3x3() @ kLookAlong).normalized()
    right = forward.cross((0, 0, 1)).normalized()
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    axes = Matrix((right, right.cross(forward), -forward)).transposed().to_4x4()
    camera.matrix_world = axes
    camera.data.lens = 60
    scene = bpy.context.scene
    scene.collection.objects.link(camera)
    scene.camera = camera
    depsgraph = bpy.context.evaluated_depsgraph_get()
    place, _ = camera.camera_fit_coords(depsgraph, [x for point in points for x in point])
    middle = sum(points, Vector()) / len(points)
    distance = (place - middle).length
    camera.matrix_world = Matrix.Translation(place - margin * distance * forward) @ axes
    camera.data.clip_start = 0.01 * distance
    camera.data.clip_end = 10 * distance
    return camera


def add_light(name, camera, middle, radius, direction, size, power, color):
    """An area light; `direction` (right, up, towards the camera) and `size` in units of `radius`."""
    light = bpy.data.lights.new(name, "AREA")
    light.shape = "DISK"
    light.size = size * radius
    light.energy = power * radius**2
    light.color = color
    thing = bpy.data.objects.new(name, light)
    offset = camera.matrix_world.to_3x3() @ Vector(direction)
    thing.matrix_world = (Matrix.Translation(middle + radius * offset)
                          @ offset.to_track_quat("Z", "Y").to_matrix().to_4x4())
    bpy.context.scene.collection.objects.link(thing)


def add_backdrop(dim):
    """`dim` light from all directions; the camera sees a dark grey that is a little lighter in the middle."""
    world = bpy.data.worlds.new("backdrop")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputWorld")
    path = nodes.new("ShaderNodeLightPath")
    place = nodes.new("ShaderNodeTexCoord")
    centred = nodes.new("ShaderNodeMapping")
    centred.vector_type = "POINT"
    centred.inputs["Location"].default_value = (-0.5 * 1.3, -0.5 * 1.3, 0)
    centred.inputs["Scale"].default_value = (1.3, 1.3, 0)
    glow = nodes.new("ShaderNodeTexGradient")
    glow.gradient_type = "QUADRATIC_SPHERE"
    ramp = nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color = (0.011, 0.0115, 0.0125, 1)
    ramp.color_ramp.elements[1].color = (0.055, 0.0575, 0.062, 1)
    choose = nodes.new("ShaderNodeMixRGB")
    choose.inputs["Color1"].default_value = dim
    emit = nodes.new("ShaderNodeBackground")
    links.new(place.outputs["Window"], centred.inputs["Vector"])
    links.new(centred.outputs["Vector"], glow.inputs["Vector"])
    links.new(glow.outputs["Fac"], ramp.inputs["Fac"])
    links.new(path.outputs["Is Camera Ray"], choose.inputs["Fac"])
    links.new(ramp.outputs["Color"], choose.inputs["Color2"])
    links.new(choose.outputs["Color"], emit.inputs["Color"])
    links.new(emit.outputs["Background"], output.inputs["Surface"])


def add_scene(points, smoke):
    camera = add_camera(points, Matrix.Rotation(math.pi / 2, 4, "X"), 0.3 if smoke else 0.16)
    low, high = map(Vector, bounds(points))
    middle, radius = (low + high) / 2, (high - low).length / 2
    if smoke:  # lit from behind its shoulder: from the front it looks flat
        add_light("key", camera, middle, radius, (-1.6, 2.0, -0.2), 0.8, 180, kWarm)
        add_light("rim", camera, middle, radius, (1.9, -0.4, -1.9), 1.4, 35, kCool)
        add_backdrop((0.02, 0.022, 0.026, 1))
    else:
        add_light("key", camera, middle, radius, (-1.7, 1.9, 1.4), 1.4, 90, kWarm)
        add_light("rim", camera, middle, radius, (2.0, 0.8, -1.6), 1.4, 90, kCool)
        add_backdrop((0.06, 0.065, 0.075, 1))


# ---- the picture

def set_up_cycles(samples):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.use_adaptive_sampling = True
    cycles.adaptive_threshold = 0.02
    cycles.time_limit = 40
    cycles.max_bounces = 6
    cycles.volume_bounces = 3
    cycles.sample_clamp_indirect = 4
    cycles.use_denoising = False  # Debian builds Cycles without Open Image Denoise; see denoise()
    cycles.volume_step_rate = 2
    scene.render.use_persistent_data = True  # rendered twice
    scene.render.resolution_x, scene.render.resolution_y = kSize
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.view_settings.view_transform = "Filmic"
    scene.view_settings.look = "High Contrast"


def use_velocity(volume, names, file, fog):
    """Motion blur by the velocity grid: world units per second, at the file's frames per second."""
    scene = bpy.context.scene
    name = next((name for name in ("vel", "velocity") if name in names), None)
    if name is None:
        return
    volume.velocity_grid = name
    volume.velocity_unit = "SECOND"
    scene.render.fps = max(1, round(pyopenvdb.readMetadata(str(file)).get("fps", 24)))
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 0.5
    print(f"motion blur: grid {name}, {scene.render.fps} frames per second, shutter {scene.render.motion_blur_shutter}")
    check_velocity_reach(file, name, fog, scene.render.motion_blur_shutter / scene.render.fps)


def render_once(file, seed):
    """Pixels, height x width x RGB, as in the file."""
    scene = bpy.context.scene
    scene.cycles.seed = seed
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(file))
    pixels = numpy.empty(4 * image.size[0] * image.size[1], numpy.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(kSize[1], kSize[0], 4)[:, :, :3]


def box(values, radius):
    """Mean over squares of 2 radius + 1 pixels."""
    for axis in (0, 1):
        values = sum(numpy.roll(values, k, axis) for k in range(-radius, radius + 1)) / (2 * radius + 1)
    return values


def denoise(a, b, reach=6, patch=2, strength=0.6):
    """Mean of two renderings that differ only in noise, each filtered with weights found in the other.

    Non-local means: Rousselle, Knaus, Zwicker, "Adaptive Rendering with Non-Local Means Filtering", 2012.
    """
    variance = box((a - b)**2 / 2, patch)
    totals = [[numpy.zeros_like(a), numpy.zeros_like(a[:, :, :1])] for _ in range(2)]
    for shift in ((y, x) for y in range(-reach, reach + 1) for x in range(-reach, reach + 1)):
        there = numpy.roll(variance, shift, (0, 1))
        for (guide, noisy), sums in zip(((a, b), (b, a)), totals):
            difference = (guide - numpy.roll(guide, shift, (0, 1)))**2 - (variance + numpy.minimum(variance, there))
            distance = (difference / (1e-5 + strength**2 * (variance + there))).mean(2, keepdims=True)
            weight = numpy.exp(-numpy.maximum(box(distance, patch), 0))
            sums[0] += weight * numpy.roll(noisy, shift, (0, 1))
            sums[1] += weight
    return sum(total / weights for total, weights in totals) / 2


def save(pixels, picture):
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("picture", width, height, alpha=False)
    image.pixels.foreach_set(numpy.concatenate((pixels, numpy.ones((height, width, 1), numpy.float32)), 2).ravel())
    image.filepath_raw = str(picture.resolve())
    image.file_format = "PNG"
    image.save()


def render(frame, picture):
    bpy.context.scene.frame_set(frame)
    with tempfile.TemporaryDirectory() as folder:
        pixels = denoise(*(render_once(pathlib.Path(folder, f"{seed}.png"), seed) for seed in (1, 2)))
    share = float((pixels.mean(2) > kLit).mean())
    if share < 0.005:
        raise Unusable(f"frame {frame}: Blender renders it, but there is nothing to be seen in the picture")
    save(pixels, picture)
    print(f"picture: {picture}, {100 * share:.1f} % of it lit")


# ---- the whole

def show_smoke(thing, frames, frame, names):
    fogs = {number: Fog(file, "density") for number, file in frames.items()}
    if not fogs[frame].corners:
        raise Unusable(f"{frames[frame]}: density is zero everywhere")
    points = [thing.matrix_world @ point for fog in fogs.values() for point in fog.points]
    heat = None
    name = next((name for name in ("flame", "temperature") if name in names), None)
    if name:
        highest = max(Fog(file, name).highest for file in frames.values())
        heat = (name, highest) if highest > 0 else None
    extent = max((a - b).length for a in fogs[frame].corners for b in fogs[frame].corners) / math.sqrt(3)
    column = max(fog.column for fog in fogs.values())
    print(f"density: up to {max(fog.highest for fog in fogs.values()):.4g}, optical depth {column:.4g}, "
          f"scaled to {kOpticalDepth:g}; glow: {heat[0] if heat else 'none'}")
    thing.data.materials.append(smoke_material(column, extent, names, heat))
    use_velocity(thing.data, names, frames[frame], fogs[frame])
    return points


def show_surface(thing, frames, name):
    surface = mesh_from_level_set(thing, name)
    surface.data.materials.append(clay_material())
    return [point for number, file in frames.items() for point in measure_mesh(surface, number, file)]


def run():
    arguments = parse_arguments()
    if arguments.picture.suffix != ".png":
        raise Unusable(f"{arguments.picture}: the picture must be a .png")
    frames = dict(sorted(find_frames(arguments.first).items()))
    frame = sorted(frames)[len(frames) // 2] if arguments.frame is None else arguments.frame
    if frame not in frames:
        raise Unusable(f"frame {frame} is not in the sequence, {min(frames)} to {max(frames)}")

    bpy.ops.wm.read_factory_settings(use_empty=True)
    rotation = Matrix.Rotation(math.pi / 2, 4, "X") if arguments.up == "y" else Matrix()
    thing = add_volume(frames, rotation)
    shown, names = load_sequence(thing.data, frames, arguments.surface)
    smoke = shown == "density"
    points = show_smoke(thing, frames, frame, names) if smoke else show_surface(thing, frames, shown)
    add_scene(points, smoke)
    set_up_cycles(samples=28 if smoke else 48)
    print(f"frame {frame}: rendering", flush=True)
    render(frame, arguments.picture)


try:
    run()
except Unusable as error:
    sys.exit(f"check_blender: {error}")
