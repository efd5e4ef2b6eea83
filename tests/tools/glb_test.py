#!/usr/bin/env python3
"""GLB outputs, read by a small parser in this file and, if installed, by the Khronos validator and Blender.

usage: glb_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

The validator is npm's gltf-validator: the folder of the package in GLTF_VALIDATOR, or installed globally.
"""
import json
import os
import shutil
import struct
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, named_cases, run_cases

PROGRAM, REPOSITORY, ONLY = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3:]
ASSETS = os.path.join(REPOSITORY, "assets")
COMPONENTS = {"SCALAR": 1, "VEC3": 3}
TYPES = {5125: np.uint32, 5126: np.float32}


class Glb:
    """A file's JSON and arrays, with the rules of the container checked."""

    def __init__(self, path):
        data = open(path, "rb").read()
        magic, version, length = struct.unpack("<4sII", data[:12])
        assert (magic, version, length) == (b"glTF", 2, len(data)), (magic, version, length, len(data))
        size, kind = struct.unpack("<I4s", data[12:20])
        assert kind == b"JSON" and size % 4 == 0
        self.json = json.loads(data[20:20 + size])
        binary, kind = struct.unpack("<I4s", data[20 + size:28 + size])
        assert kind == b"BIN\0" and 28 + size + binary == len(data)
        self.binary = data[28 + size:]
        self.nodes = [n for n in self.json["nodes"] if "mesh" in n]

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        columns = COMPONENTS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        values = np.frombuffer(self.binary, TYPES[accessor["componentType"]], accessor["count"] * columns, start)
        return values.reshape(-1, columns) if columns > 1 else values

    def channel(self, node, path):
        """Times and values of what moves a node; None where nothing does."""
        index = self.json["nodes"].index(node)
        for animation in self.json.get("animations", []):
            for c in animation["channels"]:
                if c["target"] == {"node": index, "path": path}:
                    sampler = animation["samplers"][c["sampler"]]
                    return self.array(sampler["input"]), self.array(sampler["output"]), sampler["interpolation"]
        return None

    def shown(self, node, seconds):
        channel = self.channel(node, "scale")
        if channel is None:
            return node.get("scale", [1, 1, 1]) != [0, 0, 0]
        times, scales, interpolation = channel
        assert interpolation == "STEP"
        return bool(scales[max(np.searchsorted(times, seconds + 1e-6) - 1, 0)].all())

    def mesh(self, node, seconds):
        """Points, normals and triangles of a node at a time."""
        primitive = self.json["meshes"][node["mesh"]]["primitives"][0]
        points = self.array(primitive["attributes"]["POSITION"]).astype(float)
        normals = self.array(primitive["attributes"]["NORMAL"]).astype(float)
        targets = primitive.get("targets", [])
        if targets:
            times, weights, interpolation = self.channel(node, "weights")
            assert interpolation == "LINEAR"
            weights = weights.reshape(len(times), len(targets))
            for i, target in enumerate(targets):
                w = np.interp(seconds, times, weights[:, i])
                points = points + w * self.array(target["POSITION"])
                normals = normals + w * self.array(target["NORMAL"])
        return points, normals, self.array(primitive["indices"]).reshape(-1, 3)

    def at(self, seconds):
        """The one mesh that is visible at a time."""
        nodes = [n for n in self.nodes if self.shown(n, seconds)]
        assert len(nodes) == 1, "%d meshes are shown at %g s" % (len(nodes), seconds)
        return self.mesh(nodes[0], seconds)


def run(*words, code=0):
    result = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=300)
    assert result.returncode == code, "%s\nexit %d\n%s" % (" ".join(map(str, words)), result.returncode, result.stderr)
    return result.stdout + result.stderr


def volume_of(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def sphere(path, centre, radius, steps=48):
    """A closed mesh along latitudes and longitudes."""
    points = [(0, 0, 1)]
    for i in range(1, steps):
        for j in range(2 * steps):
            a, b = np.pi * i / steps, np.pi * j / steps
            points.append((np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)))
    points.append((0, 0, -1))
    ring = lambda i, j: 1 + (i - 1) * 2 * steps + j % (2 * steps)
    faces = [(0, ring(1, j), ring(1, j + 1)) for j in range(2 * steps)]
    for i in range(1, steps - 1):
        for j in range(2 * steps):
            faces += [(ring(i, j), ring(i + 1, j), ring(i + 1, j + 1)), (ring(i, j), ring(i + 1, j + 1), ring(i, j + 1))]
    faces += [(len(points) - 1, ring(steps - 1, j + 1), ring(steps - 1, j)) for j in range(2 * steps)]
    with open(path, "w") as out:
        for p in points:
            out.write("v %r %r %r\n" % tuple(float(x) for x in np.array(p) * radius + centre))
        for f in faces:
            out.write("f %d %d %d\n" % tuple(i + 1 for i in f))


def distances(path, points):
    """Trilinear samples of a frame's level set at world points, in voxels (background beyond the band)."""
    grid = vdb.read(path, "surface")
    voxel = grid.transform.voxelSize()[0]
    low, high = grid.evalActiveVoxelBoundingBox()
    values = np.full([h - l + 1 for l, h in zip(low, high)], grid.background, np.float32)
    grid.copyToArray(values, ijk=low)
    index = np.array([grid.transform.worldToIndex(tuple(p)) for p in points]) - low
    base = np.clip(np.floor(index).astype(int), 0, np.array(values.shape) - 2)
    rest, sum = index - base, 0
    for c in range(8):
        corner = np.array([c & 1, c >> 1 & 1, c >> 2])
        sum = sum + np.where(corner, rest, 1 - rest).prod(axis=1) * values[tuple((base + corner).T)]
    return np.abs(sum) / voxel


def check_normals(points, normals, triangles, whole=True):
    """Normals have unit length and agree with the faces around each point, but for folds and sharp edges."""
    length = np.linalg.norm(normals, axis=1)
    assert np.abs(length - 1).max() < 1e-3 if whole else True, np.abs(length - 1).max()
    a, b, c = (points[triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    agree = np.einsum("ij,ij->i", face, normals[triangles[:, 0]]) > 0
    area = np.linalg.norm(face, axis=1)
    assert area[agree].sum() > 0.98 * area.sum(), area[agree].sum() / area.sum()


def case_sphere(folder):
    """A sphere that moves and grows: one mesh whose points lie on the closed-form sphere at all times."""
    sphere(folder + "/a.obj", (0, 0, 0), 1.0)
    sphere(folder + "/b.obj", (4, 1, 0), 2.0)
    out = folder + "/m.glb"
    text = run("morph", folder + "/a.obj", folder + "/b.obj", "-o", out, "--frames", 5, "--resolution", 48, "--fps", 10)
    assert "one mesh" in text and text.count(out) == 2, text
    glb = Glb(out)
    assert len(glb.nodes) == 1 and len(glb.json["meshes"][0]["primitives"][0]["targets"]) == 4
    assert glb.json["meshes"][0]["extras"]["targetNames"][-1] == "frame.0005"
    for i in range(5):
        t = i / 4
        points, normals, triangles = glb.at(i / 10)
        radius, centre, voxel = 1 + t, np.array([4 * t, t, 0]), 2 * (1 + t) / 48
        off = np.abs(np.linalg.norm(points - centre, axis=1) - radius)
        # Half a voxel, and where the polygon lies inside the sphere.
        assert off.max() < 0.5 * voxel + radius * (1 - np.cos(np.pi / 96)) * 2, (t, off.max() / voxel)
        outwards = np.einsum("ij,ij->i", normals, (points - centre) / radius)
        assert outwards.min() > np.cos(np.radians(10)), (t, outwards.min())
        check_normals(points, normals, triangles)
        exact = 4 / 3 * np.pi * radius ** 3
        assert abs(volume_of(points, triangles) / exact - 1) < 0.01, (t, volume_of(points, triangles) / exact)
    # Half way between two frames the points are half way, still on a sphere.
    points = glb.at(0.05)[0]
    off = np.abs(np.linalg.norm(points - (0.5, 0.125, 0), axis=1) - 1.125)
    assert off.max() < 0.5 * 2.25 / 48 + 0.002, off.max()


def check_volume(points, triangles, frame):
    """Volume of a tenth of a voxel all over the surface, the accuracy of
    moving meshes, and single precision."""
    off = abs(volume_of(points, triangles) - frame["volume"])
    assert off < 0.101 * frame["voxelSize"] * frame["area"], (frame["frame"], off / frame["voxelSize"] / frame["area"])


def case_on_frames(folder):
    """Every frame's points are on the level set that the same morph writes as VDB; volumes agree."""
    run("plan", ASSETS + "/blade.ply", ASSETS + "/creature.ply", "--resolution", 48, "-o", folder + "/x.plan")
    words = ["morph", "--plan", folder + "/x.plan", "--frames", 4]
    print(run(*words, "-o", folder + "/m.glb", "--report", folder + "/m.json").splitlines()[-2])
    run(*words, "-o", folder + "/m.####.vdb", "--velocity", "none")
    frames = json.load(open(folder + "/m.json"))["frames"]
    glb = Glb(folder + "/m.glb")
    for i, frame in enumerate(frames):
        points, normals, triangles = glb.at(i / 24)
        off = distances(folder + "/m.%04d.vdb" % (i + 1), points[::3])
        assert off.max() < 0.5, (i, off.max())
        check_volume(points, triangles, frame)
        check_normals(points, normals, triangles)


def case_hole(folder):
    """Where a hole opens no mesh fits all frames: each frame shows one, with the right volume."""
    words = ["morph", ASSETS + "/creature.ply", ASSETS + "/ring.ply", "--frames", 6, "--resolution", 48]
    text = run(*words, "-o", folder + "/m.glb", "--report", folder + "/m.json")
    frames = json.load(open(folder + "/m.json"))["frames"]
    assert frames[0]["genus"] != frames[-1]["genus"]
    glb = Glb(folder + "/m.glb")
    assert len(glb.nodes) > 1 and "each shown in its own frames" in text
    for i, frame in enumerate(frames):
        points, normals, triangles = glb.at(i / 24)
        check_volume(points, triangles, frame)
        glb.at((i + 0.5) / 24)
    # A reader without animation sees the first frame.
    assert [n.get("scale", [1, 1, 1]) == [1, 1, 1] for n in glb.nodes] == [True] + [False] * (len(glb.nodes) - 1)


def case_same_bytes(folder):
    run("plan", ASSETS + "/blade.ply", ASSETS + "/creature.ply", "--resolution", 32, "-o", folder + "/x.plan")
    words = ["morph", "--plan", folder + "/x.plan", "--frames", 2]
    for threads in (1, 2, 4):
        run(*words, "-o", folder + "/%d.glb" % threads, "--threads", threads)
    files = [open(folder + "/%d.glb" % threads, "rb").read() for threads in (1, 2, 4)]
    assert files[0] == files[1] == files[2]


def case_still(folder):
    """One mesh per file, from morph and convert, read back by our own reader."""
    run("convert", ASSETS + "/amphora.ply", "-o", folder + "/a.glb", "--resolution", 64)
    run("convert", ASSETS + "/amphora.ply", "-o", folder + "/a.ply", "--resolution", 64)
    assert json.loads(run("compare", folder + "/a.glb", folder + "/a.ply", "--json", "--resolution", 64))["dice"] > 0.9999
    glb = Glb(folder + "/a.glb")
    assert "animations" not in glb.json and "scale" not in glb.nodes[0]
    check_normals(*glb.at(0))
    run("morph", ASSETS + "/blade.ply", ASSETS + "/ring.ply", "-o", folder + "/f.##.glb", "--frames", 2, "--method", "sdf", "--resolution", 32)
    run("morph", ASSETS + "/blade.ply", ASSETS + "/ring.ply", "-o", folder + "/half.glb", "--at", 0.5, "--method", "sdf", "--resolution", 32)
    for name in ("f.01", "f.02", "half"):
        assert len(Glb(folder + "/%s.glb" % name).nodes) == 1


def case_space(folder):
    """Z up and millimetres: points are unchanged, the node above them turns and scales."""
    words = ["morph", ASSETS + "/blade.ply", ASSETS + "/ring.ply", "--at", 0.5, "--method", "sdf", "--resolution", 32]
    run(*words, "-o", folder + "/a.glb")
    run(*words, "-o", folder + "/b.glb", "--glb-up", "z", "--glb-unit", "mm")
    a, b = Glb(folder + "/a.glb"), Glb(folder + "/b.glb")
    assert np.array_equal(a.at(0)[0], b.at(0)[0])
    root = b.json["nodes"][b.json["scenes"][0]["nodes"][0]]
    assert root["scale"] == [0.001] * 3
    x, y, z, w = root["rotation"]
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])  # of (0, 0, 1)
    assert np.allclose(up, (0, 1, 0)), up


def case_errors(folder):
    a, b = ASSETS + "/blade.ply", ASSETS + "/ring.ply"
    assert "does not exist" in run("morph", a, b, "-o", folder + "/no/m.glb", code=1)
    assert "--glb-up" in run("morph", a, b, "-o", folder + "/m.glb", "--glb-up", "w", code=2)
    assert "--glb-unit" in run("morph", a, b, "-o", folder + "/m.glb", "--glb-unit", "inch", code=2)
    assert "makes no surface" in run("morph", a, b, "-o", folder + "/m.glb", "--method", "dissolve", code=2)
    assert "holds all frames" in run("morph", a, b, "-o", folder + "/m.ply", code=2)
    assert os.listdir(folder) == []


def painted(path, color):
    """The unit cube as a PLY whose points have a colour."""
    with open(path, "w") as out:
        out.write("ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                  "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 6\n"
                  "property list uchar int vertex_indices\nend_header\n")
        out.write("".join("%d %d %d %s\n" % (i & 1, i >> 1 & 1, i >> 2, color) for i in range(8)))
        out.write("4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n")


def make_samples(folder):
    """A static mesh, morph targets, several meshes, with colours and without."""
    small = ["--resolution", 40]
    run("convert", ASSETS + "/amphora.ply", "-o", folder + "/still.glb", *small)
    run("morph", ASSETS + "/blade.ply", ASSETS + "/blade.ply", "-o", folder + "/same.glb", "--frames", 4, *small)
    run("morph", ASSETS + "/blade.ply", ASSETS + "/creature.ply", "-o", folder + "/targets.glb", "--frames", 4, *small)
    run("morph", ASSETS + "/creature.ply", ASSETS + "/ring.ply", "-o", folder + "/hole.glb", "--frames", 5, *small,
        "--glb-up", "z", "--glb-unit", "mm")
    run("morph", ASSETS + "/creature.ply", ASSETS + "/ring.ply", "-o", folder + "/sdf.glb", "--frames", 3, "--method", "sdf", *small)
    for name, color in (("red", "255 0 51"), ("blue", "0 51 255")):
        painted(folder + "/%s.ply" % name, color)
    run("convert", folder + "/red.ply", "-o", folder + "/painted.glb", *small)
    run("morph", folder + "/red.ply", folder + "/blue.ply", "-o", folder + "/colors.glb", "--frames", 3, *small)
    return ["still", "same", "targets", "hole", "sdf", "painted", "colors"]


def case_validator(folder):
    """The Khronos validator finds no errors and nothing to warn of."""
    if not shutil.which("node"):
        raise Skip("node is not installed")
    package = os.environ.get("GLTF_VALIDATOR")
    if not package and shutil.which("npm"):
        root = subprocess.run(["npm", "root", "-g"], capture_output=True, text=True).stdout.strip()
        package = os.path.join(root, "gltf-validator")
    if not package or not os.path.isdir(package):
        raise Skip("npm's gltf-validator is not installed (npm install -g gltf-validator, or its folder in GLTF_VALIDATOR)")
    script = ("require(process.argv[1]).validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[2])))"
              ".then(r => console.log(JSON.stringify(r)))")
    for name in make_samples(folder):
        result = subprocess.run(["node", "-e", script, package, folder + "/%s.glb" % name], capture_output=True, text=True)
        issues = json.loads(result.stdout)["issues"]
        print("  %s.glb: %d errors, %d warnings, %d infos" % (name, issues["numErrors"], issues["numWarnings"], issues["numInfos"]))
        assert issues["numErrors"] == 0 and issues["numWarnings"] == 0, issues["messages"][:5]


BLENDER = """
import sys
sys.path.append('/usr/lib/python3/dist-packages')  # not there where another Python has started Blender
import bpy, json, numpy
numpy.bool = bool  # gone since numpy 1.24; the importer of Blender 3.4 asks for it
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = 24
bpy.ops.import_scene.gltf(filepath=sys.argv[-1])
meshes = [o for o in bpy.data.objects if o.type == 'MESH']
rows = []
for frame in range(0, 6):
    bpy.context.scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    shown = []
    for o in meshes:
        e = o.evaluated_get(graph)
        if min(abs(s) for s in e.matrix_world.to_scale()) > 1e-9:
            m = e.to_mesh()
            m.calc_loop_triangles()
            volume = 0
            for t in m.loop_triangles:
                a, b, c = (e.matrix_world @ m.vertices[i].co for i in t.vertices)
                volume += a.dot(b.cross(c)) / 6
            shown.append([o.name, volume])
    rows.append(shown)
print('RESULT' + json.dumps({'meshes': len(meshes), 'rows': rows,
    'keys': [len(o.data.shape_keys.key_blocks) if o.data.shape_keys else 0 for o in meshes]}))
"""


def case_blender(folder):
    """Blender imports each sample and shows, frame by frame, the mesh of the file with its volume."""
    if not shutil.which("blender"):
        raise Skip("blender is not installed")
    open(folder + "/look.py", "w").write(BLENDER)
    for name in make_samples(folder):
        path = folder + "/%s.glb" % name
        result = subprocess.run(["blender", "-b", "--factory-startup", "--python", folder + "/look.py", "--", path],
                                capture_output=True, text=True, timeout=300)
        lines = [l for l in result.stdout.splitlines() if l.startswith("RESULT")]
        assert lines, result.stdout[-2000:] + result.stderr[-2000:]
        seen, glb = json.loads(lines[0][6:]), Glb(path)
        print("  %s.glb: %d meshes, shape keys %s" % (name, seen["meshes"], seen["keys"]))
        assert seen["meshes"] == len(glb.nodes)
        targets = [len(m["primitives"][0].get("targets", [])) for m in glb.json["meshes"]]
        assert sorted(seen["keys"]) == sorted(t + 1 if t else 0 for t in targets)
        scale = next((n["scale"][0] for n in glb.json["nodes"] if n.get("children")), 1)
        for frame, shown in enumerate(seen["rows"]):
            points, _, triangles = glb.at(frame / 24)
            assert len(shown) == 1, (name, frame, shown)
            wanted = volume_of(points * scale, triangles)
            assert abs(shown[0][1] / wanted - 1) < 1e-3, (name, frame, shown, wanted)


sys.exit(run_cases(sorted(named_cases(globals())), ONLY))
