"""What the program made, as objects of the scene: all of it plays and renders without the add-on."""

import bpy
import numpy

from . import materials
from .mesh_files import UsdaMeshes, read_glb
from .program import Unusable

kColors = "Color"  # attribute of meshes
kVelocity = "velocity"  # attribute by which Cycles blurs meshes, way per second
kMade = "slicemorph"  # custom property of what a morph made: its name


def add_result(job, scene):
    """A generator: each step is short. Replaces what a morph of the same name made before."""
    remove_earlier(job.name)
    yield True
    add = {"VOLUME": add_volume, "MESH_CACHE": add_mesh_cache, "SHAPE_KEYS": add_shape_keys}[job.result]
    yield from add(job, scene)


def remove_earlier(name):
    """Removes the objects, and of their data what nothing else uses."""
    for objects in (bpy.data.objects, bpy.data.collections, bpy.data.node_groups):
        for one in [one for one in objects if one.get(kMade) == name]:
            objects.remove(one)
    for data in (bpy.data.volumes, bpy.data.meshes, bpy.data.materials):
        for one in [one for one in data if one.get(kMade) == name and not one.users]:
            data.remove(one)


def made(thing, job):
    thing[kMade] = job.name
    return thing


def new_object(data, job, scene):
    """An object of the scene with this data, at the place of the morph's space."""
    thing = made(bpy.data.objects.new(job.name, made(data, job)), job)
    thing.matrix_world = job.space
    scene.collection.objects.link(thing)
    return thing


def frame_file(job, number):
    return str(job.output).replace("####", f"{number:04d}")


# ---- volumes

def add_volume(job, scene):
    volume = bpy.data.volumes.new(job.name)
    volume.filepath = frame_file(job, job.start)
    if not volume.grids.load():
        raise Unusable(f"{volume.filepath}: Blender cannot read it: {volume.grids.error_message}")
    grids = {grid.name: grid for grid in volume.grids}
    if "vel" in grids:
        volume.velocity_grid = "vel"
        volume.velocity_unit = "SECOND"
    if "density" in grids:
        volume.materials.append(made(materials.smoke(job.name, grids), job))
    elif "surface" in grids:
        # Voxels are cubes, in the space of the morph.
        voxel = grids["surface"].matrix_object.to_scale()[0]
        volume.materials.append(made(materials.solid(job.name, grids, voxel), job))
    # Only now: which file of a sequence is loaded is known first when it is shown.
    volume.is_sequence = True
    volume.frame_start, volume.frame_duration, volume.frame_offset = job.start, job.frames, job.start - 1
    volume.sequence_mode = "EXTEND"
    new_object(volume, job, scene)
    yield True


# ---- meshes

def new_mesh(name, points, triangles, colors=None, velocities=None):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.loops.add(3 * len(triangles))
    mesh.polygons.add(len(triangles))
    mesh.vertices.foreach_set("co", numpy.ravel(points).astype(numpy.float32))
    mesh.loops.foreach_set("vertex_index", numpy.ravel(triangles).astype(numpy.int32))
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(triangles), 3, dtype=numpy.int32))
    if len(triangles) and not mesh.polygons[0].bl_rna.properties["loop_total"].is_readonly:  # until Blender 3.6
        mesh.polygons.foreach_set("loop_total", numpy.full(len(triangles), 3, numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(len(triangles), bool))
    mesh.update(calc_edges=True)
    if colors is not None:
        layer = mesh.color_attributes.new(kColors, "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", numpy.pad(colors, ((0, 0), (0, 1)), constant_values=1).astype(numpy.float32).ravel())
    if velocities is not None:
        layer = mesh.attributes.new(kVelocity, "FLOAT_VECTOR", "POINT")
        layer.data.foreach_set("vector", velocities.astype(numpy.float32).ravel())
    return mesh


def add_mesh_cache(job, scene):
    """A mesh a frame, in a collection outside the scene, and an object whose nodes show the frame's."""
    frames, paint = made(bpy.data.collections.new(f"{job.name} frames"), job), None
    meshes = UsdaMeshes(job.output)
    yield True
    for number in range(job.start, job.start + job.frames):
        name = f"{job.name}.{number:08d}f"  # nodes take them in the order of their names
        mesh = made(new_mesh(name, *meshes.frame(number)), job)
        if len(mesh.color_attributes):
            paint = paint or made(materials.painted(job.name, kColors), job)
            mesh.materials.append(paint)
        frames.objects.link(made(bpy.data.objects.new(name, mesh), job))
        yield True
    thing = new_object(bpy.data.meshes.new(job.name), job, scene)
    thing.modifiers.new("Frames", "NODES").node_group = frame_switch(job, frames)


def frame_switch(job, frames):
    """A group of nodes: of a collection's objects the one whose turn it is."""
    tree = made(bpy.data.node_groups.new(f"{job.name} frames", "GeometryNodeTree"), job)
    if hasattr(tree, "interface"):  # from Blender 4.0 on
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    place, time, since, upto, objects, pick, real, out = (tree.nodes.new(kind) for kind in (
        "GeometryNodePoints", "GeometryNodeInputSceneTime", "ShaderNodeMath", "ShaderNodeClamp",
        "GeometryNodeCollectionInfo", "GeometryNodeInstanceOnPoints", "GeometryNodeRealizeInstances", "NodeGroupOutput"))
    since.operation = "SUBTRACT"
    since.inputs[1].default_value = job.start
    upto.inputs["Max"].default_value = job.frames - 1
    objects.inputs["Collection"].default_value = frames
    objects.inputs["Separate Children"].default_value = True
    pick.inputs["Pick Instance"].default_value = True
    for source, target in ((time.outputs["Frame"], since.inputs[0]), (since.outputs[0], upto.inputs["Value"]),
                           (upto.outputs[0], pick.inputs["Instance Index"]), (place.outputs[0], pick.inputs["Points"]),
                           (objects.outputs[0], pick.inputs["Instance"]), (pick.outputs[0], real.inputs[0]),
                           (real.outputs[0], out.inputs[0])):
        tree.links.new(source, target)
    for column, node in enumerate(tree.nodes):
        node.location = (200 * column, 0)
    return tree


# ---- shape keys

def add_shape_keys(job, scene):
    for moving in read_glb(job.output):
        thing = new_object(new_mesh(job.name, moving.points, moving.triangles), job, scene)
        yield True
        thing.shape_key_add(name="Basis", from_mix=False)
        for number, points in enumerate(moving.targets):
            key = thing.shape_key_add(name=f"Frame {job.start + shape_frame(job, moving, number)}", from_mix=False)
            key.data.foreach_set("co", points.astype(numpy.float32).ravel())
            yield True
        frames = job.start + numpy.rint(moving.times * job.fps).astype(int)
        for number in range(len(moving.targets)):
            key_weights(thing.data.shape_keys.key_blocks[number + 1], frames, moving.weights[:, number])
        show_between(thing, job, moving)
        for data in (thing.data.shape_keys, thing):
            make_steady(data.animation_data)
        yield True


def shape_frame(job, moving, number):
    """The frame, from 0, at which the target is the whole shape."""
    return int(round(moving.times[int(moving.weights[:, number].argmax())] * job.fps))


def key_weights(key, frames, weights):
    """Keys a shape's value where it, or its value a frame before or after, is not 0."""
    shown = numpy.pad(weights > 0, 1)
    near = shown[:-2] | shown[1:-1] | shown[2:]
    for frame, weight in zip(frames[near], weights[near]):
        key.value = weight
        key.keyframe_insert("value", frame=int(frame))


def show_between(thing, job, moving):
    """Keys when the object is shown, where another takes its place before or after."""
    first, end = (job.start + numpy.rint(time * job.fps) for time in (moving.first, moving.end))
    keys = [(first - 1, True), (first, False), (end - 1, False), (end, True)]
    for frame, hidden in keys:
        if numpy.isfinite(frame):
            for path in ("hide_viewport", "hide_render"):
                setattr(thing, path, hidden)
                thing.keyframe_insert(path, frame=int(frame))


def curves_of(action):
    """The action's curves, in Blender's old and new (5.0) way to keep them."""
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags
            for curve in bag.fcurves]


def make_steady(animation):
    """Values go straight from key to key, so that motion blur sees the speed."""
    if animation and animation.action:
        for curve in curves_of(animation.action):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR" if curve.data_path.endswith("value") else "CONSTANT"
