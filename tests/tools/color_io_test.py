#!/usr/bin/env python3
"""Colours of meshes and VDBs, read and written, against files made here and brute-force distances.

usage: color_io_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)
"""
import json
import os
import struct
import subprocess
import sys
import zlib

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import named_cases, run_cases

PROGRAM, REPOSITORY, ONLY = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3:]
RESOLUTION = 24

# The unit cube, outwards; colours of its corners and of its faces, in bytes.
POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
CORNER_COLORS = [(255 * x, 255 * y, 51 * (1 + z)) for x, y, z in POINTS]
FACE_COLORS = [(255, 0, 0), (0, 51, 255), (255, 0, 0), (0, 51, 255), (255, 0, 0), (0, 51, 255)]
PLY_TYPES = {"uchar": ("B", 255), "ushort": ("H", 65535), "uint": ("I", 4294967295), "float": ("f", 1), "double": ("d", 1)}


def run(*words, code=0):
    result = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=300)
    assert result.returncode == code, "%s\nexit %d\n%s" % (" ".join(map(str, words)), result.returncode, result.stderr)
    return result.stdout + result.stderr


def scaled(color, kind):
    """A colour given in bytes as numbers of a type."""
    letter, most = PLY_TYPES[kind]
    return [c / 255 * most if letter in "fd" else c * most // 255 for c in color]


def ply(path, layout="ascii", kind="uchar", points=None, faces=None, odd=False, names=("red", "green", "blue"),
        vertices=POINTS, polygons=FACES):
    """A PLY file with byte colours of points, faces or both; `odd`: with
    unknown elements and lists in between."""
    order = ">" if layout == "binary_big_endian" else "<"
    head, body = ["ply", "format %s 1.0" % layout, "comment made by hand"], []

    def put(letters, *values):
        if layout == "ascii":
            body.append(" ".join(repr(v) for v in values) + "\n")
        else:
            body.append(struct.pack(order + letters, *values))

    colors = ["property %s %s" % (kind, n) for n in names]
    letter = PLY_TYPES[kind][0]
    if odd:
        head += ["element marker 2", "property list ushort double places", "property char flag"]
        put("H2db", 2, 0.5, 1.5, -3)
        put("Hb", 0, 7)
    head += ["element vertex %d" % len(vertices)] + ["property float " + c for c in "xyz"] + (colors if points else [])
    if odd:
        head += ["property short rank", "property list uchar uint ring"]
    for i, p in enumerate(vertices):
        values, letters = list(map(float, p)), "fff"
        if points:
            values, letters = values + scaled(points[i], kind), letters + 3 * letter
        if odd:
            values, letters = values + [-i, 3, 1, 2, 3], letters + "hBIII"
        put(letters, *values)
    head += ["element face %d" % len(polygons)]
    if odd:
        head += ["property double area"]
    head += ["property list uchar int vertex_indices"] + (colors if faces else [])
    for i, f in enumerate(polygons):
        values, letters = ([0.25] if odd else []) + [len(f), *f], ("d" if odd else "") + "B%di" % len(f)
        if faces:
            values, letters = values + scaled(faces[i], kind), letters + 3 * letter
        put(letters, *values)
    with open(path, "wb") as out:
        out.write(("\n".join(head) + "\nend_header\n").encode())
        out.write("".join(body).encode() if layout == "ascii" else b"".join(body))


def obj(path, points=None, materials=None, library="m.mtl"):
    """The cube; `materials`: one name per face, None for faces before any is named."""
    with open(path, "w") as out:
        if materials:
            out.write("mtllib %s\n" % library)
        for i, p in enumerate(POINTS):
            out.write("v %g %g %g" % p + (" %.9g %.9g %.9g" % tuple(c / 255 for c in points[i]) if points else "") + "\n")
        for i, f in enumerate(FACES):
            if materials and materials[i]:
                out.write("usemtl %s\n" % materials[i])
            out.write("f %s\n" % " ".join(str(k + 1) for k in f))


def glb(path, parts):
    """Cubes side by side: each part has `colors` (of bytes), their type and width, and a base colour."""
    views, accessors, meshes, nodes, materials, data = [], [], [], [], [], b""

    def add(values, component, kind, **more):
        nonlocal data
        data += b"\0" * (-len(data) % 4)
        stride = more.pop("stride", None)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(values), **({"byteStride": stride} if stride else {})})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind, **more})
        data += values
        return len(accessors) - 1

    triangles = [t for f in FACES for t in ((f[0], f[1], f[2]), (f[0], f[2], f[3]))]
    for n, part in enumerate(parts):
        at = add(b"".join(struct.pack("<3f", *p) for p in POINTS), 5126, "VEC3", count=8, min=[0, 0, 0], max=[1, 1, 1])
        primitive = {"attributes": {"POSITION": at}, "indices": add(
            b"".join(struct.pack("<3H", *t) for t in triangles), 5123, "SCALAR", count=36)}
        if "colors" in part:
            letter, width = part.get("type", "f"), part.get("width", 3)
            component, most = {"f": (5126, 1), "B": (5121, 255), "H": (5123, 65535)}[letter]
            rows = [[c / 255 if letter == "f" else c * most // 255 for c in color] + [most] for color in part["colors"]]
            rows = [struct.pack("<%d%s" % (width, letter), *row[:width]) for row in rows]
            size = -(-len(rows[0]) // 4) * 4
            more = {} if letter == "f" else {"normalized": True}
            if size != len(rows[0]):
                more["stride"] = size
            primitive["attributes"]["COLOR_0"] = add(b"".join(r.ljust(size, b"\0") for r in rows), component,
                                                     "VEC%d" % width, count=len(rows), **more)
        if "base" in part:
            primitive["material"] = len(materials)
            materials.append({"pbrMetallicRoughness": {"baseColorFactor": part["base"]}})
        meshes.append({"primitives": [primitive]})
        nodes.append({"mesh": n, "translation": [3 * n, 0, 0]})
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
            "meshes": meshes, "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(data)}]}
    if materials:
        gltf["materials"] = materials
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    with open(path, "wb") as out:
        out.write(b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text +
                  struct.pack("<I4s", len(data), b"BIN\0") + data)


def active(grid):
    """Coordinates and values of the active voxels, in the order of the coordinates."""
    rows = []
    for v in grid.citerOnValues():
        assert v.count == 1, "an active tile"
        rows.append((v.min, v.value))
    rows.sort(key=lambda row: row[0])
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows], np.float32)


def read_colors(path):
    """World positions and colours of the grid Cd, which has the surface's voxels; the voxel size."""
    surface, colors = vdb.read(path, "surface"), vdb.read(path, "Cd")
    assert surface.transform.voxelSize() == colors.transform.voxelSize()
    positions, values = active(colors)
    assert np.array_equal(positions, active(surface)[0]), "Cd is not on the surface's voxels"
    voxel = surface.transform.voxelSize()[0]
    return positions * voxel + np.array(surface.transform.indexToWorld((0, 0, 0))), values, voxel


def grids_of(path):
    return sorted(g.name for g in vdb.readAllGridMetadata(path))


def convert(path, *words):
    """Voxelises a file; returns what read_colors does."""
    out = path + ".vdb"
    run("convert", path, "-o", out, "--resolution", RESOLUTION, *words)
    return read_colors(out)


def nearest(points, a, b, c):
    """Points of a triangle nearest to given points, as weights of its corners.

    Ericson, Real-Time Collision Detection, 5.1.5.
    """
    ab, ac, ap, bp, cp = b - a, c - a, points - a, points - b, points - c
    d1, d2, d3, d4, d5, d6 = ap @ ab, ap @ ac, bp @ ab, bp @ ac, cp @ ab, cp @ ac
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    with np.errstate(all="ignore"):
        inside = np.stack([va, vb, vc], 1) / (va + vb + vc)[:, None]
        t, s, u = d1 / (d1 - d3), d2 / (d2 - d6), (d4 - d3) / ((d4 - d3) + (d5 - d6))
    zero = np.zeros(len(points))
    rules = [((d1 <= 0) & (d2 <= 0), [zero + 1, zero, zero]), ((d3 >= 0) & (d4 <= d3), [zero, zero + 1, zero]),
             ((vc <= 0) & (d1 >= 0) & (d3 <= 0), [1 - t, t, zero]), ((d6 >= 0) & (d5 <= d6), [zero, zero, zero + 1]),
             ((vb <= 0) & (d2 >= 0) & (d6 <= 0), [1 - s, zero, s]),
             ((va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0), [zero, 1 - u, u])]
    result, done = inside, np.zeros(len(points), bool)
    for where, weights in rules:
        result = np.where((where & ~done)[:, None], np.stack(weights, 1), result)
        done |= where
    return result


def check_nearest(positions, colors, voxel, corner_colors, vertices=POINTS, polygons=FACES):
    """Each voxel has the colour of a nearest surface point, of which
    there may be several. Polygons are fans."""
    vertices = np.array(vertices, float)
    triangles = [(f, 0, k, k + 1) for f in range(len(polygons)) for k in range(1, len(polygons[f]) - 1)]
    distance, found = [], []
    for f, *corners in triangles:
        a, b, c = (vertices[polygons[f][k]] for k in corners)
        weights = nearest(positions, a, b, c)
        distance.append(np.linalg.norm(weights @ np.array([a, b, c]) - positions, axis=1))
        found.append(weights @ np.array([corner_colors(f, k) for k in corners], float))
    distance, found = np.array(distance), np.array(found)
    as_near = distance <= distance.min(0) + 1e-4 * voxel  # of single precision
    off = np.where(as_near, np.abs(found - colors).max(2), np.inf).min(0)
    assert off.max() < 1e-4, (int(off.argmax()), positions[off.argmax()], colors[off.argmax()], off.max())


def of_points(f, k):
    return np.array(CORNER_COLORS[FACES[f][k]]) / 255


def of_faces(f, k):
    return np.array(FACE_COLORS[f]) / 255


def case_ply_points(folder):
    """All three formats and all types give the same colours, those of the nearest surface points."""
    first = None
    for layout in ("ascii", "binary_little_endian", "binary_big_endian"):
        for kind in PLY_TYPES:
            path = folder + "/%s_%s.ply" % (layout, kind)
            ply(path, layout, kind, points=CORNER_COLORS, odd=kind in ("uchar", "double"),
                names=("diffuse_red", "diffuse_green", "diffuse_blue") if kind == "ushort" else ("red", "green", "blue"))
            positions, colors, voxel = convert(path)
            if first is None:
                check_nearest(positions, colors, voxel, of_points)
                first = colors
            assert np.abs(colors - first).max() < 1e-6, (layout, kind)


def case_ply_faces(folder):
    for layout in ("ascii", "binary_little_endian", "binary_big_endian"):
        for kind in ("uchar", "ushort", "float"):
            path = folder + "/%s_%s.ply" % (layout, kind)
            ply(path, layout, kind, faces=FACE_COLORS, odd=kind != "ushort")
            positions, colors, voxel = convert(path)
            check_nearest(positions, colors, voxel, of_faces)
            # Exactly the two colours, without blending.
            wanted = {tuple(np.float32(c) / np.float32(255) for c in color) for color in FACE_COLORS}
            assert {tuple(c) for c in colors} == wanted
    # Faces of two corners have no surface but are counted; colours of points win over those of faces.
    ply(folder + "/line.ply", faces=[(9, 9, 9)] + FACE_COLORS, polygons=[(0, 1)] + FACES)
    positions, colors, voxel = convert(folder + "/line.ply")
    check_nearest(positions, colors, voxel, of_faces)
    ply(folder + "/both.ply", points=CORNER_COLORS, faces=FACE_COLORS)
    check_nearest(*convert(folder + "/both.ply"), of_points)


def case_ply_strips(folder):
    """A tetrahedron of two strips, stored before its points, and a coloured face; strips are white."""
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    text = ("ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\nelement vertex 4\n"
            "property float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n8 1 0 2 3 -1 1 2 3\n"
            + "".join("%d %d %d\n" % p for p in points) + "3 0 1 3 255 0 51\n")
    open(folder + "/s.ply", "w").write(text)
    reported = json.loads(run("info", folder + "/s.ply", "--json"))["mesh"]
    assert reported["closed"] and abs(reported["signedVolume"] - 1 / 6) < 1e-6 and reported["notes"] == [], reported
    positions, colors, voxel = convert(folder + "/s.ply")
    check_nearest(positions, colors, voxel, lambda f, k: np.array([1, 0, 0.2]) if f == 3 else np.ones(3), points,
                  [(1, 0, 2), (0, 3, 2), (1, 2, 3), (0, 1, 3)])


def case_obj(folder):
    obj(folder + "/v.obj", points=CORNER_COLORS)
    check_nearest(*convert(folder + "/v.obj"), of_points)
    names = ["red", "sky blue"] * 3
    kd = "newmtl red\nKa 0 1 0\nKd 1 0 0\nnewmtl sky blue\nKs 1 1 1\nKd 0 0.2 1\r\n"
    open(folder + "/m.mtl", "w").write(kd)
    obj(folder + "/m.obj", materials=names)
    check_nearest(*convert(folder + "/m.obj"), of_faces)
    # A name with a space, two libraries on a line.
    open(folder + "/a b.mtl", "w").write(kd)
    obj(folder + "/space.obj", materials=names, library="a b.mtl")
    check_nearest(*convert(folder + "/space.obj"), of_faces)
    open(folder + "/1.mtl", "w").write(kd.split("newmtl sky")[0])
    open(folder + "/2.mtl", "w").write("newmtl sky" + kd.split("newmtl sky")[1])
    obj(folder + "/two.obj", materials=names, library="1.mtl 2.mtl")
    check_nearest(*convert(folder + "/two.obj"), of_faces)
    # Faces whose material has no Kd are white.
    open(folder + "/some.mtl", "w").write("newmtl none\nNs 3\nnewmtl grey\nKd 0.6\n")
    obj(folder + "/some.obj", materials=["gone", "none", "grey", "none", "grey", "gone"], library="some.mtl")
    check_nearest(*convert(folder + "/some.obj"), lambda f, k: np.full(3, 0.6 if f in (2, 4) else 1.0))
    # Without a library there are no colours, nor with one that no face uses.
    obj(folder + "/gone.obj", materials=names, library="no.mtl")
    obj(folder + "/unused.obj", materials=[None] * 6)
    for name in ("gone", "unused"):
        run("convert", folder + "/%s.obj" % name, "-o", folder + "/out.vdb", "--resolution", RESOLUTION)
        assert grids_of(folder + "/out.vdb") == ["surface"]


def case_glb(folder):
    parts = [{"colors": CORNER_COLORS, "type": t, "width": w} for t in "fBH" for w in (3, 4)]
    for part in parts:
        glb(folder + "/a.glb", [part])
        check_nearest(*convert(folder + "/a.glb"), of_points)
    base = np.array([0.5, 1, 0.25])
    glb(folder + "/base.glb", [{"colors": CORNER_COLORS, "base": [*base, 1]}])
    check_nearest(*convert(folder + "/base.glb"), lambda f, k: of_points(f, k) * base)
    glb(folder + "/alone.glb", [{"base": [*base, 1]}])
    assert np.array_equal(np.unique(convert(folder + "/alone.glb")[1], axis=0), [base.astype(np.float32)])
    for name, part in (("plain", {}), ("white", {"base": [1, 1, 1, 1]})):
        glb(folder + "/%s.glb" % name, [part])
        run("convert", folder + "/%s.glb" % name, "-o", folder + "/plain.vdb", "--resolution", RESOLUTION)
        assert grids_of(folder + "/plain.vdb") == ["surface"]
    # Of two parts the one without a colour is white.
    glb(folder + "/two.glb", [{"base": [*base, 1]}, {}])
    positions, colors, _ = convert(folder + "/two.glb")
    assert np.array_equal(colors, np.where((positions[:, 0] < 2)[:, None], base, 1).astype(np.float32))


def case_one_color(folder):
    """One colour is kept exactly in every voxel, also at filled holes, and in all outputs."""
    color = np.array([51, 102, 153])
    exact = (color / 255).astype(np.float32)
    # A ball of rings without its poles: two holes of 12 edges.
    rings, steps = 12, 12
    ball = [(np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)) for a in np.pi * np.arange(1, rings + 1) / (rings + 1)
            for b in 2 * np.pi * np.arange(steps) / steps]
    at = lambda i, j: i * steps + j % steps
    quads = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(rings - 1) for j in range(steps)]
    for name, given in (("points", {"points": [color] * len(ball)}), ("faces", {"faces": [color] * len(quads)})):
        path = folder + "/%s.ply" % name
        ply(path, vertices=ball, polygons=quads, **{k: [tuple(map(int, c)) for c in v] for k, v in given.items()})
        assert "filled 2 holes" in run("info", path)
        assert np.array_equal(np.unique(convert(path)[1], axis=0), [exact])
    # Resampled, and on points.
    run("convert", folder + "/points.ply.vdb", "-o", folder + "/fine.vdb", "--voxel-size", 0.031)
    assert np.array_equal(np.unique(read_colors(folder + "/fine.vdb")[1], axis=0), [exact])
    for source in ("points.ply.vdb", "fine.vdb"):
        run("convert", folder + "/" + source, "-o", folder + "/out.ply")
        assert np.array_equal(np.unique(read_ply(folder + "/out.ply")[1], axis=0), [color]), source
        run("convert", folder + "/" + source, "-o", folder + "/out.obj")
        assert np.array_equal(np.unique(read_obj(folder + "/out.obj")[1], axis=0), [exact]), source
        run("convert", folder + "/" + source, "-o", folder + "/out.glb")
        assert np.array_equal(np.unique(read_glb(folder + "/out.glb")[1], axis=0), [exact]), source


def read_ply(path):
    """Points and colours of a PLY as slicemorph writes it."""
    head, body = open(path, "rb").read().split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines
    count = int(lines[2].split()[2])
    names = [l.split()[2] for l in lines[3:] if l.startswith("property") and "list" not in l]
    assert [l.split()[1] for l in lines if l.startswith("property") and "list" not in l] == ["float"] * 3 + ["uchar"] * (len(names) - 3)
    row = np.dtype([(n, "<f4" if n in "xyz" else "u1") for n in names])
    rows = np.frombuffer(body, row, count)
    faces = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<u4", 3)]), -1, count * row.itemsize)
    assert len(faces) == int(next(l for l in lines if l.startswith("element face")).split()[2]) and faces["v"].max() == count - 1
    colors = np.stack([rows[n] for n in names[3:]], 1) if len(names) > 3 else None
    return np.stack([rows[n] for n in "xyz"], 1), colors


def read_obj(path):
    rows = np.array([[float(x) for x in l.split()[1:]] for l in open(path) if l.startswith("v ")], np.float32)
    return rows[:, :3], rows[:, 3:]


def read_glb(path):
    data = open(path, "rb").read()
    size = struct.unpack("<I", data[12:16])[0]
    gltf, binary = json.loads(data[20:20 + size]), data[28 + size:]
    primitive = gltf["meshes"][0]["primitives"][0]

    def array(name):
        accessor = gltf["accessors"][primitive["attributes"][name]]
        assert (accessor["type"], accessor["componentType"]) == ("VEC3", 5126)
        view = gltf["bufferViews"][accessor["bufferView"]]
        return np.frombuffer(binary, "<f4", 3 * accessor["count"], view["byteOffset"]).reshape(-1, 3)

    base = gltf["materials"][primitive["material"]]["pbrMetallicRoughness"].get("baseColorFactor", [1, 1, 1, 1])
    if "COLOR_0" not in primitive["attributes"]:
        return array("POSITION"), None, base
    return array("POSITION"), array("COLOR_0"), base


def case_writers(folder):
    """Points of the output have the colours of the cube's surface at their positions."""
    # The colour of a corner is its position, so colours equal positions all over the surface.
    ply(folder + "/in.ply", points=[tuple(255 * x for x in p) for p in POINTS])
    voxel = 1 / RESOLUTION
    for name, read in (("out.ply", read_ply), ("out.obj", read_obj), ("out.glb", read_glb)):
        run("convert", folder + "/in.ply", "-o", folder + "/" + name, "--resolution", RESOLUTION)
        points, colors = read(folder + "/" + name)[:2]
        off = np.abs(colors / (255 if name == "out.ply" else 1) - points)
        # Voxels beside an edge have the colour of the edge: one voxel, and rounding to bytes.
        assert len(points) > 1000 and off.max() < voxel + 0.5 / 255, (name, off.max() / voxel)
        inner = ((points > 4 * voxel) & (points < 1 - 4 * voxel)).sum(1) == 2
        assert inner.sum() > 100 and off[inner].max() < 1e-4 + 0.5 / 255, (name, off[inner].max())
    assert read_glb(folder + "/out.glb")[2] == [1, 1, 1, 1]
    run("convert", folder + "/in.ply", "-o", folder + "/out.stl", "--resolution", RESOLUTION)
    assert json.loads(run("info", folder + "/out.stl", "--json"))["mesh"]["colors"] == ""
    # Without colours nothing is added.
    ply(folder + "/none.ply")
    for name in ("none.vdb", "p.ply", "p.obj", "p.glb"):
        run("convert", folder + "/none.ply", "-o", folder + "/" + name, "--resolution", RESOLUTION)
    assert grids_of(folder + "/none.vdb") == ["surface"]
    assert read_ply(folder + "/p.ply")[1] is None and read_obj(folder + "/p.obj")[1].size == 0
    assert read_glb(folder + "/p.glb")[1:] == (None, [0.62, 0.47, 0.36, 1])


def case_range(folder):
    """Values beyond 0 to 1 are kept in VDB and OBJ, and clamped in bytes and glTF."""
    path = folder + "/bright.ply"
    ply(path, kind="float", points=[(510, -51, 127.5)] * 8)
    assert np.array_equal(np.unique(convert(path)[1], axis=0), np.array([[2, -0.2, 0.5]], np.float32))
    for name, read, wanted in (("o.ply", read_ply, [255, 0, 128]), ("o.obj", read_obj, [2, -0.2, 0.5]),
                               ("o.glb", read_glb, [1, 0, 0.5])):
        run("convert", path, "-o", folder + "/" + name, "--resolution", RESOLUTION)
        assert np.allclose(np.unique(read(folder + "/" + name)[1], axis=0), [wanted], atol=1e-7), name


def ball_grids(folder, name, **colors):
    """A level set of a ball with grids of colours, each from a function of the world position."""
    voxel = 0.1
    surface = vdb.createLevelSetSphere(1.0, voxelSize=voxel)
    surface.name = "surface"
    grids = [surface]
    for title, (function, scale, reach) in colors.items():
        grid = vdb.Vec3SGrid()
        grid.name = title
        grid.transform = vdb.createLinearTransform(voxel * scale)
        accessor = grid.getAccessor()
        cells = int(np.ceil(1.5 / (voxel * scale)))
        for ijk in np.ndindex(*[2 * cells + 1] * 3):
            ijk = np.array(ijk) - cells
            position = ijk * voxel * scale
            if abs(np.linalg.norm(position) - 1) < reach:
                accessor.setValueOn(tuple(int(i) for i in ijk), tuple(float(x) for x in function(position)))
        grids.append(grid)
    vdb.write(folder + "/" + name, grids)
    return folder + "/" + name


def case_vdb(folder):
    """A colour grid with another transform; one that covers less than the band; the order of names."""
    linear = lambda p: (p + 2) / 4
    path = ball_grids(folder, "linear.vdb", Cd=(linear, 0.7, 0.6), color=(lambda p: [1, 0, 0], 1, 0.6))
    run("convert", path, "-o", folder + "/out.vdb")
    positions, colors, voxel = read_colors(folder + "/out.vdb")
    assert np.abs(colors - linear(positions)).max() < 1e-5  # trilinear is exact for it
    # With one coloured layer, voxels further out take the colour of the nearest coloured voxel.
    thin = ball_grids(folder, "thin.vdb", Cd=(linear, 1, 0.05))
    run("convert", thin, "-o", folder + "/out.vdb")
    positions, colors, voxel = read_colors(folder + "/out.vdb")
    own, given = active(vdb.read(thin, "Cd"))
    own = own * voxel
    here = {tuple(np.round(p / voxel).astype(int)): c for p, c in zip(own, given)}
    for position, color in list(zip(positions, colors))[::7]:
        distance = np.linalg.norm(own - position, axis=1)
        as_near = distance < distance.min() + 1e-6
        assert np.abs(given[as_near] - color).max(1).min() < 1e-6, (position, color)
    # Cd before color before others; grids of other names are no colours; empty ones are ignored.
    red, blue = (lambda p: [1, 0, 0], 1, 0.5), (lambda p: [0, 0, 1], 1, 0.5)
    for title, wanted, grids in (("a", [0, 0, 1], {"albedo": red, "color": blue}), ("b", [1, 0, 0], {"rgb": red}),
                                 ("c", None, {"v": red}), ("d", None, {"Cd": (red[0], 1, -1)})):
        path = ball_grids(folder, title + ".vdb", **grids)
        run("convert", path, "-o", folder + "/out.vdb")
        if wanted is None:
            assert grids_of(folder + "/out.vdb") == ["surface"], title
        else:
            assert np.array_equal(np.unique(read_colors(folder + "/out.vdb")[1], axis=0), [wanted]), title


def case_same_bytes(folder):
    ply(folder + "/a.ply", faces=FACE_COLORS)
    for threads in (1, 2, 4):
        run("convert", folder + "/a.ply", "-o", folder + "/%d.vdb" % threads, "--resolution", 64, "--threads", threads)
        run("convert", folder + "/%d.vdb" % threads, "-o", folder + "/%d.ply" % threads, "--threads", threads)
    for end in (".vdb", ".ply"):
        files = [open(folder + "/%d%s" % (threads, end), "rb").read() for threads in (1, 2, 4)]
        assert files[0] == files[1] == files[2], end


def case_info(folder):
    reported = lambda path: json.loads(run("info", path, "--json"))["mesh"]["colors"]
    ply(folder + "/p.ply", points=CORNER_COLORS)
    ply(folder + "/f.ply", faces=FACE_COLORS)
    ply(folder + "/n.ply")
    assert [reported(folder + "/%s.ply" % n) for n in "pfn"] == ["points", "faces", ""]
    assert "of its faces" in run("info", folder + "/f.ply") and "colours" not in run("info", folder + "/n.ply")
    obj(folder + "/m.obj", materials=["red"] * 6)
    open(folder + "/m.mtl", "w").write("newmtl red\nKd 1 0 0\nmap_Kd skin.png\n")
    assert reported(folder + "/m.obj") == "materials" and \
        "6 faces with a texture have no texture coordinates" in run("info", folder + "/m.obj")


def picture(path, size=64):
    """A PNG whose red changes along u, green along v; bytes are whole at the pixels' centres."""
    row = lambda y: b"\0" + b"".join(bytes((30 + 3 * x, 40 + 2 * y, 90)) for x in range(size))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    data = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", size, size, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"".join(map(row, range(size))))) + chunk(b"IEND", b""))
    open(path, "wb").write(data)


def in_picture(u, v, size=64):
    """The colour of the picture, in linear light, at coordinates from its upper left."""
    x, y = (np.clip(np.asarray(c) * size - 0.5, 0, size - 1) for c in (u, v))
    s = np.stack([30 + 3 * x, 40 + 2 * y, np.full_like(x, 90)], 1) / 255
    return np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)


def textured_cube(path):
    """The cube from 0 to 1 as OBJ; the picture lies on it as seen along z, and is drawn out on the sides."""
    with open(path, "w") as out:
        out.write("mtllib skin.mtl\n" + "".join("v %g %g %g\nvt %g %g\n" % (*p, 0.1 + 0.8 * p[0], 0.1 + 0.8 * p[1]) for p in POINTS))
        out.write("usemtl skin\n" + "".join("f %s\n" % " ".join("%d/%d" % (k + 1, k + 1) for k in f) for f in FACES))
    open(os.path.dirname(path) + "/skin.mtl", "w").write("newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n")


def textured_ball(path, rings=24, steps=48):
    """A ball of radius 0.6 as glTF in text with its data and picture beside it; the picture lies on it the same way."""
    angles = [(np.pi * i / rings, 2 * np.pi * j / steps) for i in range(rings + 1) for j in range(steps)]
    points = np.array([(np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)) for a, b in angles]) * 0.6 + 0.5
    uvs = np.stack([0.1 + 0.8 * points[:, 0], 1 - (0.1 + 0.8 * points[:, 1])], 1)
    at = lambda i, j: i * steps + j % steps
    corners = [k for i in range(rings) for j in range(steps)
               for k in (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    data = [np.asarray(points, "<f4").tobytes(), np.asarray(uvs, "<f4").tobytes(), np.asarray(corners, "<u2").tobytes()]
    open(os.path.dirname(path) + "/ball.bin", "wb").write(b"".join(data))
    views = [{"buffer": 0, "byteOffset": sum(map(len, data[:i])), "byteLength": len(d)} for i, d in enumerate(data)]
    json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
               "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
               "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
               "textures": [{"source": 0}], "images": [{"uri": "skin.png"}],
               "buffers": [{"byteLength": sum(map(len, data)), "uri": "ball.bin"}], "bufferViews": views,
               "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
                             {"bufferView": 1, "componentType": 5126, "count": len(points), "type": "VEC2"},
                             {"bufferView": 2, "componentType": 5123, "count": len(corners), "type": "SCALAR"}]}, open(path, "w"))


def case_textures(folder):
    """A textured cube to a textured ball: colours at the ends are the picture's, within 2/255 at every point; Cd
    too."""
    picture(folder + "/skin.png")
    textured_cube(folder + "/cube.obj")
    textured_ball(folder + "/ball.gltf")
    assert "1 texture, decoded from sRGB to linear light" in run("info", folder + "/ball.gltf")
    words = ["morph", folder + "/cube.obj", folder + "/ball.gltf", "--frames", 3, "--resolution", 64]
    run(*words, "-o", folder + "/m.####.vdb")
    for name in (1, 2, 3):
        frame = folder + "/m.%04d" % name
        run("convert", frame + ".vdb", "-o", frame + ".ply")
        points, colors = read_ply(frame + ".ply")
        assert len(points) > 1000
        if name != 2:
            off = np.abs(colors / 255 - in_picture(0.1 + 0.8 * points[:, 0], 1 - (0.1 + 0.8 * points[:, 1]))).max()
            assert off < 2 / 255, (name, off * 255)
        positions, values, voxel = read_colors(frame + ".vdb")
        assert np.isfinite(values).all() and values.min() >= 0 and values.max() <= 1


def case_errors(folder):
    def refused(name, *parts):
        text = run("convert", folder + "/" + name, "-o", folder + "/out.vdb", "--resolution", RESOLUTION, code=1)
        assert not os.path.exists(folder + "/out.vdb")
        for part in (folder + "/" + name, *parts):
            assert part in text, (name, part, text)

    for layout in ("ascii", "binary_little_endian", "binary_big_endian"):
        ply(folder + "/whole.ply", layout, faces=FACE_COLORS)
        whole = open(folder + "/whole.ply", "rb").read()
        for less in (4, 9, 25):
            open(folder + "/cut.ply", "wb").write(whole[:-less])
            refused("cut.ply", "is truncated", "6 elements 'face'")
        ply(folder + "/nan.ply", layout, "float", points=CORNER_COLORS[:5] + [(float("nan"), 0, 0)] + CORNER_COLORS[6:])
        refused("nan.ply", "the colour of point 6 is not finite (nan, 0, 0)")
        ply(folder + "/inf.ply", layout, "double", faces=FACE_COLORS[:2] + [(0, 0, float("inf"))] + FACE_COLORS[3:])
        refused("inf.ply", "the colour of face 3 is not finite (0, 0, inf)")
    ply(folder + "/word.ply", points=CORNER_COLORS)
    text = open(folder + "/word.ply").read().replace("255 255 51", "255 many 51", 1)
    open(folder + "/word.ply", "w").write(text)
    refused("word.ply", "'many' stands for a number")
    obj(folder + "/some.obj", points=CORNER_COLORS)
    lines = open(folder + "/some.obj").read().splitlines(True)
    lines[2] = "v 0 1 0\n"
    open(folder + "/some.obj", "w").writelines(lines)
    refused("some.obj", "gives colours to 7 of its 8 vertices")
    lines[2] = "v 0 1 0 1 inf 1\n"
    open(folder + "/inf.obj", "w").writelines(lines)
    refused("inf.obj", "line 3: vertex 3 is not finite (inf)")
    lines[2] = "v 0 1 0 1 1 1 1\n"
    open(folder + "/seven.obj", "w").writelines(lines)
    refused("seven.obj", "line 3: vertex 3 has 7 numbers")
    obj(folder + "/m.obj", materials=["red"] * 6)
    open(folder + "/m.mtl", "w").write("newmtl red\nKd 1 nan 0\n")
    text = run("convert", folder + "/m.obj", "-o", folder + "/out.vdb", code=1)
    assert folder + "/m.mtl: line 2: the colour is not finite" in text, text
    glb(folder + "/few.glb", [{"colors": CORNER_COLORS[:7]}])
    refused("few.glb", "a mesh of 8 points has 7 colours")
    glb(folder + "/nan.glb", [{"colors": CORNER_COLORS[:7] + [(float("nan"), 0, 0)]}])
    refused("nan.glb", "the colour of point 8 is not finite (nan, 0, 0)")


sys.exit(run_cases(sorted(named_cases(globals())), ONLY))
