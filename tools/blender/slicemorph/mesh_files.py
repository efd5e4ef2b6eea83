"""Meshes to and from files, as arrays. Knows nothing of Blender."""

import json
import struct

import numpy

from .program import Unusable

kComponents = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


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


class UsdaMeshes:
    """The time samples of the mesh in a .usda that slicemorph wrote, each read when it is asked for."""

    def __init__(self, path):
        self.path, self.places = path, {}  # {attribute: {number: where in the file its value is}}
        self.origin, at, samples = numpy.zeros(3), 0, None
        with open(path, "rb") as file:
            for line in file:
                words = line[:200].split()
                if words[-2:] == [b"=", b"{"] and words[1].endswith(b".timeSamples"):
                    samples = self.places.setdefault(words[1][:-len(b".timeSamples")].decode(), {})
                elif words and words[0] == b"}":
                    samples = None
                elif samples is not None:
                    samples[int(words[0][:-1])] = at, at + len(line)
                elif words[1:2] == [b"xformOp:translate"]:
                    self.origin = self._numbers(line.split(b"=")[1]).ravel()
                at += len(line)
        if "points" not in self.places:
            raise Unusable(f"{path}: not a mesh as slicemorph writes it")

    def frame(self, number):
        """Points (N x 3), triangles (M x 3), and of the points colours (N x 3, linear light) and velocities (N x 3, a
        second), or None."""
        with open(self.path, "rb") as file:
            points, triangles, colors, velocities = (self._value(file, name, number) for name in (
                "points", "faceVertexIndices", "primvars:displayColor", "velocities"))
        return points + self.origin, triangles.astype(numpy.int32), colors, velocities

    def _value(self, file, name, number):
        place = self.places.get(name, {}).get(number)
        if not place:
            return None
        file.seek(place[0])
        value = file.read(place[1] - place[0]).split(b":", 1)[1]
        return None if value.strip().startswith(b"None") else self._numbers(value)

    @staticmethod
    def _numbers(text):
        text = text.translate(None, b"()[]\n").strip(b", ")
        return numpy.fromstring(text, sep=",").reshape(-1, 3) if text else numpy.zeros((0, 3))


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
