"""Meshes to and from files, as arrays. Knows nothing of Blender."""

import json
import struct

import numpy

from .program import Unusable

kComponents = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
kPlyTypes = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "<i2", "int16": "<i2",
             "ushort": "<u2", "uint16": "<u2", "int": "<i4", "int32": "<i4", "uint": "<u4", "uint32": "<u4",
             "float": "<f4", "float32": "<f4", "double": "<f8", "float64": "<f8"}


def write_ply(path, points, triangles, colors=None):
    """`points`: N x 3; `triangles`: M x 3 indices; `colors`: N x 3, of the points."""
    vertices = numpy.empty(len(points), [("place", "<f8", 3)] + ([] if colors is None else [("color", "<f4", 3)]))
    vertices["place"] = points
    if colors is not None:
        vertices["color"] = colors
    faces = numpy.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
              "property double x\nproperty double y\nproperty double z\n"
              + ("" if colors is None else "property float red\nproperty float green\nproperty float blue\n") +
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(vertices.tobytes())
        file.write(faces.tobytes())


def read_ply(path):
    """Points (N x 3), triangles (M x 3) and colours (N x 3, 0 to 1, or None) of a binary PLY as slicemorph writes it:
    all faces are triangles, colours are bytes."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.find(b"end_header\n") + len(b"end_header\n")
    counts, fields = {}, {}
    for words in map(str.split, data[:end].decode("ascii", "replace").splitlines()):
        if words[0] == "element":
            element = words[1]
            counts[element], fields[element] = int(words[2]), []
        elif words[:2] == ["property", "list"]:
            fields[element] += [("count", kPlyTypes[words[2]]), ("corners", kPlyTypes[words[3]], 3)]
        elif words[0] == "property":
            fields[element].append((words[2], kPlyTypes[words[1]]))
    if b"format binary_little_endian" not in data[:end] or list(counts) != ["vertex", "face"]:
        raise Unusable(f"{path}: not a PLY as slicemorph writes it")
    vertices = numpy.frombuffer(data, fields["vertex"], counts["vertex"], end)
    faces = numpy.frombuffer(data, fields["face"], counts["face"], end + vertices.nbytes)
    if (faces["count"] != 3).any():
        raise Unusable(f"{path}: not all of its faces are triangles")
    points = numpy.stack([vertices[axis] for axis in "xyz"], 1).astype(numpy.float32)
    colored = "red" in vertices.dtype.names
    colors = numpy.stack([vertices[channel] for channel in ("red", "green", "blue")], 1) / 255 if colored else None
    return points, faces["corners"], colors


class MovingMesh:
    """One mesh of an animated .glb. `points`: N x 3; `triangles`: M x 3; `targets`: a list of K arrays N x 3;
    `times` (seconds) and `weights` (times x K): how the targets follow each other; it is shown from `first` on and
    before `end` (seconds; infinite: always)."""

    def __init__(self, points, triangles, targets):
        self.points, self.triangles, self.targets = points, triangles, targets
        self.times, self.weights = numpy.zeros(1), numpy.zeros((1, len(targets)))
        self.first, self.end = -numpy.inf, numpy.inf


def read_glb(path):
    """The meshes of a .glb that slicemorph wrote, in the coordinates of its inputs, without the node above them.

    glTF 2.0: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
    """
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"glTF":
        raise Unusable(f"{path}: not a .glb")
    length = struct.unpack_from("<I", data, 12)[0]
    scene, start = json.loads(data[20:20 + length]), 28 + length

    def array(index):
        accessor = scene["accessors"][index]
        view = scene["bufferViews"][accessor["bufferView"]]
        width = 3 if accessor["type"] == "VEC3" else 1
        values = numpy.frombuffer(data, kComponents[accessor["componentType"]], accessor["count"] * width,
                                  start + view.get("byteOffset", 0) + accessor.get("byteOffset", 0))
        return values.reshape(-1, 3) if width == 3 else values

    meshes = {}
    for index, node in enumerate(scene["nodes"]):
        if "mesh" in node:
            shape = scene["meshes"][node["mesh"]]["primitives"][0]
            points = array(shape["attributes"]["POSITION"])
            meshes[index] = MovingMesh(points, array(shape["indices"]).reshape(-1, 3),
                                       [points + array(target["POSITION"]) for target in shape.get("targets", [])])
    for animation in scene.get("animations", []):
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            mesh, times, values = meshes[channel["target"]["node"]], array(sampler["input"]), array(sampler["output"])
            if channel["target"]["path"] == "weights":
                mesh.times, mesh.weights = times, values.reshape(len(times), -1)
            else:  # its size: 0 where it is not shown
                shown = values.max(1) > 0
                if not shown[0]:
                    mesh.first = times[shown][0]
                if not shown[-1]:
                    mesh.end = times[-1]
    return list(meshes.values())
