"""What the program gets: the objects' files, the marks on them, and the job file.

All is said in one space: the world, or that of the first volume's file, whose coordinates then stay as they are.
"""

import json
import pathlib
import re
import shlex

import bpy
import numpy
from mathutils import Matrix, Vector

from .mesh_files import write_ply
from .program import Unusable
from .settings import can_be_morphed
from .vdb_files import move_vdb

kSame = 1e-5  # entries of matrices that differ by less are the same
kUpright = 0.99  # cosine of the angle by which an axis may differ from the scene's up
kOurs = ("output", "frames", "start", "fps", "range", "at", "weights", "keys", "velocity", "velocity-unit", "config",
         "print-config", "plan", "resume", "quiet", "glb-up", "glb-unit",
         "usd")


def chosen_things(scene, context):
    """The objects of the panel's list; where it is empty the selected ones, by name, the active last."""
    listed = [row.thing for row in scene.slicemorph.inputs if row.thing]
    things = listed or selected_things(context)
    if len(things) < 2:
        raise Unusable("two or more meshes or volumes are needed: put them on the list, or select them")
    if len(set(things)) < len(things):
        raise Unusable("an object is on the list twice: make it a copy")
    unknown = [thing.name for thing in things if not is_evaluated(thing, context.view_layer)]
    if unknown:
        raise Unusable(f"{unknown[0]} is hidden in the viewport, so Blender does not know what its modifiers make: show it")
    return things


def is_evaluated(thing, layer):
    """Whether Blender keeps up its modifiers and its place; hidden by the eye alone it does."""
    if thing.name not in layer.objects or thing.hide_viewport:
        return False
    return thing.visible_get(view_layer=layer) or thing.hide_get(view_layer=layer)


def selected_things(context):
    chosen = sorted((o for o in context.selected_objects if can_be_morphed(None, o)), key=lambda o: o.name)
    return sorted(chosen, key=lambda o: o == context.view_layer.objects.active)


def morph_space(things):
    """Matrix from the space of the morph to the world."""
    return next((thing.matrix_world.copy() for thing in things if thing.type == "VOLUME"), Matrix())


def same(a, b):
    return all(abs(x - y) < kSame for p, q in zip(a, b) for x, y in zip(p, q))


def upright_axis(space):
    """The axis of the space that the scene's up is along, or `none`."""
    up = (space.to_3x3().inverted() @ Vector((0, 0, 1))).normalized()
    return next((name for name, share in zip("xyz", up) if abs(share) > kUpright), "none")


# ---- objects as files

def evaluated_mesh(thing, matrix, graph):
    """Points (N x 3), moved by `matrix` from the object's space, triangles, and colours of the points, or None, of what
    its modifiers make."""
    evaluated = thing.evaluated_get(graph)
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        points = numpy.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", points)
        triangles = numpy.empty(3 * len(mesh.loop_triangles), numpy.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        colors = point_colors(mesh)
    finally:
        evaluated.to_mesh_clear()
    if not len(triangles):
        raise Unusable(f"{thing.name} has no faces")
    matrix = numpy.array(matrix)
    triangles = triangles.reshape(-1, 3)
    if numpy.linalg.det(matrix[:3, :3]) < 0:  # mirrored: its faces look inwards
        triangles = triangles[:, ::-1]
    return points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3], triangles, colors


def point_colors(mesh):
    """The active colours as linear light (N x 3), of a point the mean of its corners'; None where there are none."""
    layer = mesh.color_attributes.active_color
    if not layer or not len(layer.data):
        return None
    colors = numpy.empty(4 * len(layer.data), numpy.float32)
    layer.data.foreach_get("color", colors)
    colors = colors.reshape(-1, 4)[:, :3]
    if layer.domain == "POINT":
        return colors
    corners = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    counts = numpy.maximum(numpy.bincount(corners, minlength=len(mesh.vertices)), 1)
    return numpy.stack([numpy.bincount(corners, channel, len(mesh.vertices)) / counts for channel in colors.T], 1)


def volume_files(thing):
    """The files of a volume, and their name as the program takes it."""
    volume = thing.data
    path = pathlib.Path(bpy.path.abspath(volume.filepath, library=volume.library))
    if not path.is_file():
        raise Unusable(f"{thing.name}: {path} is not there; a volume must come from a file")
    digits = re.search(r"(\d+)(\D*)$", path.stem)
    if not volume.is_sequence or not digits:
        return [path], path
    head, tail = path.stem[:digits.start(1)], digits[2] + path.suffix
    files = sorted(path.parent.glob(f"{head}*{tail}"))
    alike = re.compile(re.escape(head) + r"\d{%d}" % len(digits[1]) + re.escape(tail))
    return [file for file in files if alike.fullmatch(file.name)], path.parent / f"{head}{'#' * len(digits[1])}{tail}"


def write_input(thing, number, space, graph, folder):
    """The file of an object, in the space of the morph."""
    into = space.inverted() @ thing.matrix_world
    if thing.type != "VOLUME":
        name = re.sub(r"\W", "_", thing.name)
        path = pathlib.Path(folder, f"{number}_{name}.ply")
        write_ply(path, *evaluated_mesh(thing, into, graph))
        return path
    files, name = volume_files(thing)
    if same(thing.matrix_world, space):
        return name
    moved = pathlib.Path(folder, str(number))
    moved.mkdir()
    for file in files:
        move_vdb(file, moved / file.name, into)
    return moved / name.name


# ---- marks

def plain_name(name):
    """Without the number that Blender gives to what would have one name."""
    return re.sub(r"\.\d{3,}$", "", name)


def find_marks(scene, things, space):
    """{name: a place on each object, in the space of the morph}, and notes on marks that are left out."""
    into, marks = space.inverted(), [{} for _ in things]
    for empty in sorted((o for o in scene.objects if o.type == "EMPTY" and o.parent in things), key=lambda o: o.name):
        places, name = marks[things.index(empty.parent)], plain_name(empty.name)
        if name in places:
            raise Unusable(f"{empty.parent.name} has two empties named {name}: name them differently")
        places[name] = list(into @ empty.matrix_world.translation)
    names = sorted(set().union(*marks))
    whole = [name for name in names if all(name in places for places in marks)]
    notes = [f"empty {name} is left out: it is not on all objects" for name in names if name not in whole]
    return {name: [places[name] for places in marks] for name in whole}, notes


# ---- the job

def extra_options(text):
    try:
        words = shlex.split(text)
    except ValueError as problem:
        raise Unusable(f"more options: {problem}") from None
    for word in words:
        if word == "-o" or word.startswith("--") and word[2:].split("=")[0] in kOurs:
            raise Unusable(f"more options: {word} is set by the add-on")
    return words


def job_text(paths, marks, values):
    """A job file; `values`: options by their names."""
    lines = ["inputs = " + json.dumps([str(path) for path in paths], ensure_ascii=False)]
    lines += [f"{name} = {json.dumps(value, ensure_ascii=False)}" for name, value in values.items()]
    for name, places in marks.items():
        lines += ["", "[[feature]]", f"name = {json.dumps(name, ensure_ascii=False)}", f"point = {json.dumps(places)}"]
    return "\n".join(lines) + "\n"
