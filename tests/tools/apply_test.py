#!/usr/bin/env python3
"""`slicemorph apply`: points, meshes, curves, landmarks and images carried along a morph whose map is known, and the map.

usage: apply_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

The objects are one shape twice, moved by SHIFT and 1.5 times as large: every point goes to its own image. Files are read
by nibabel and pyopenvdb, or byte by byte. Tolerance: half a voxel of the objects, 0.03, where nothing else is said.
"""
import gzip
import json
import os
import struct
import subprocess
import sys
import tempfile
import zlib

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import named_cases, run_cases

if len(sys.argv) < 2:
    sys.exit(__doc__)
SHARED = tempfile.TemporaryDirectory(prefix="slicemorph-apply-")
PROGRAM, ONLY = os.path.abspath(sys.argv[1]), sys.argv[2:]
SHIFT, FACTOR, NEAR = np.array([3.0, 1.0, -2.0]), 1.5, 0.03
SMALL = ["--resolution", "40", "--slices", "32"]
POINTS = np.array([[0.9, 0.1, 0], [-0.5, 0.4, 0.2], [0, -0.6, 0.1], [0.25, 0.25, 0.25]])


def run(*words, code=0, cwd=None):
    result = subprocess.run([PROGRAM, *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=300)
    assert result.returncode == code, "exit %d: %s" % (result.returncode, result.stderr)
    return result


def mesh(path, scale, shift):
    """An egg-like ellipsoid without symmetry, so that no turn maps it onto itself."""
    rings, around, lines = 24, 48, []
    for i in range(rings + 1):
        for j in range(around):
            a, b = np.pi * i / rings, 2 * np.pi * j / around
            p = np.array([np.cos(a), 0.7 * np.sin(a) * np.cos(b), 0.45 * np.sin(a) * np.sin(b)])
            p[1] += 0.25 * p[0] ** 2
            p[2] += 0.2 * p[0] * (1 + p[0])
            lines.append("v %g %g %g" % tuple(scale * p + shift))
    at = lambda i, j: i * around + j % around + 1
    for i in range(rings):
        for j in range(around):
            quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
            if i == 0:
                quad = [at(0, 0), quad[1], quad[2]]
            elif i == rings - 1:
                quad = [quad[0], at(rings, 0), quad[3]]
            lines.append("f " + " ".join(map(str, quad)))
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


def pair(d):
    mesh(d + "/a.obj", 1, np.zeros(3))
    mesh(d + "/b.obj", FACTOR, SHIFT)
    return [d + "/a.obj", d + "/b.obj"]


def image_of(points, t=1.0):
    """By the known map, at a time: sizes and positions change linearly."""
    return points * (1 + t * (FACTOR - 1)) + t * SHIFT


def plan():
    """The plan of the two objects, made once."""
    path = SHARED.name + "/pair.plan"
    if not os.path.exists(path):
        run("plan", *pair(SHARED.name), "-o", path, *SMALL)
    return path


def apply(d, what, out, *more):
    return run("apply", *pair(d), what, "-o", out, "--plan", plan(), *more)


def glb_of(nodes, data, views, accessors, primitives, **more):
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
            "meshes": [{"primitives": primitives}], "bufferViews": views, "accessors": accessors,
            "buffers": [{"byteLength": len(data)}], **more}
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    return (b"glTF" + struct.pack("<III", 2, 28 + len(text) + len(data), len(text)) + b"JSON" + text +
            struct.pack("<I", len(data)) + b"BIN\0" + data)


def parts_of_glb(path):
    data = open(path, "rb").read()
    size = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:20 + size]), data[28 + size:]


def case_glb(d):
    """Points below a node that turns, scales and moves them, interleaved with texture coordinates: these, the
    faces, the material and its picture stay; what is not plain is refused by name."""
    turn = np.array([[0, -2, 0], [2, 0, 0], [0, 0, 2.0]])  # a quarter about z, twice as large
    node = {"mesh": 0, "rotation": [0, 0, 0.5 ** 0.5, 0.5 ** 0.5], "scale": [2, 2, 2], "translation": [0.1, 0, 0]}
    local = (POINTS - (0.1, 0, 0)) @ np.linalg.inv(turn).T
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0.25, 0.75]])
    picture, faces = b"no picture, but kept", struct.pack("<12H", 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2)
    rows = np.hstack([local, uvs]).astype("<f4").tobytes()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 80, "byteStride": 20},
             {"buffer": 0, "byteOffset": 80, "byteLength": 24}, {"buffer": 0, "byteOffset": 104, "byteLength": len(picture)}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-9] * 3, "max": [9] * 3},
                 {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 4, "type": "VEC2"},
                 {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
    more = {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
            "images": [{"bufferView": 2, "mimeType": "image/png"}]}
    whole = glb_of([node], rows + faces + picture, views, accessors, [primitive], **more)
    open(d + "/p.glb", "wb").write(whole)
    apply(d, d + "/p.glb", d + "/q.glb")
    (before, old), (after, new) = parts_of_glb(d + "/p.glb"), parts_of_glb(d + "/q.glb")
    assert old[80:] == new[80:]
    got = np.frombuffer(new, "<f4", 20).reshape(4, 5)
    assert np.array_equal(got[:, 3:], uvs)
    world = got[:, :3].astype(float) @ turn.T + (0.1, 0, 0)
    assert np.abs(world - image_of(POINTS)).max() < NEAR, world - image_of(POINTS)
    assert np.array_equal(after["accessors"][0]["min"], got[:, :3].min(0).tolist())
    assert np.array_equal(after["accessors"][0]["max"], got[:, :3].max(0).tolist())
    after["accessors"][0].update(min=[-9] * 3, max=[9] * 3)
    assert before == after

    def refused(why, nodes=[node], change={}, **also):
        open(d + "/r.glb", "wb").write(glb_of(nodes, rows + faces + picture, views, accessors, [{**primitive, **change}], **more, **also))
        assert why in run("apply", *pair(d), d + "/r.glb", "-o", d + "/x.glb", *SMALL, code=2).stderr
    refused("a mesh is shown several times", [{"children": [1, 2]}, node, node])
    refused("a skin moves them", [{**node, "skin": 0}], skins=[{"joints": [0]}])
    refused("morph targets move them", change={"targets": [{"POSITION": 0}]})


def case_obj(d):
    """Only the numbers behind `v` change; lines, comments, texture, weights and order stay."""
    text = "# curve\r\nmtllib x.mtl\r\n" + "".join("v %.6f  %.6f\t%.6f 1.0\r\n" % tuple(p) for p in POINTS) + "vn 0 0 1\r\nvt 0 1\r\nl 1 2 3 4\r\n"
    with open(d + "/c.obj", "w", newline="") as file:
        file.write(text)
    note = apply(d, d + "/c.obj", d + "/o.obj").stderr
    assert "normals" in note, note
    with open(d + "/o.obj", newline="") as file:
        got = file.read()
    before, after = text.split("\r\n"), got.split("\r\n")
    assert len(before) == len(after)
    moved = []
    for x, y in zip(before, after):
        if x.startswith("v "):
            assert y.split()[4] == "1.0" and "\t" in y and "  " in y, y
            moved.append([float(n) for n in y.split()[1:4]])
        else:
            assert x == y, (x, y)
    assert np.abs(moved - image_of(POINTS)).max() < NEAR * FACTOR, moved - image_of(POINTS)
    # And back again.
    apply(d, d + "/o.obj", d + "/p.obj", "--from", 1, "--to", 0)
    with open(d + "/p.obj") as file:
        back = [[float(n) for n in l.split()[1:4]] for l in file if l.startswith("v ")]
    assert np.abs(back - POINTS).max() < 1e-3, back


def case_times(d):
    """To a time between, and from there on."""
    np.savetxt(d + "/p.txt", POINTS)
    apply(d, d + "/p.txt", d + "/half.txt", "--to", 0.5)
    half = np.loadtxt(d + "/half.txt")
    assert np.abs(half - image_of(POINTS, 0.5)).max() < NEAR * FACTOR
    apply(d, d + "/half.txt", d + "/end.txt", "--from", 0.5)
    assert np.abs(np.loadtxt(d + "/end.txt") - image_of(POINTS)).max() < NEAR * FACTOR


def case_csv(d):
    """Columns in any order and other columns, by name; without names the first three numbers."""
    with open(d + "/t.csv", "w") as file:
        file.write('id;"Pos Z";x [mm];y;note\n' + "".join("p%d;%g;;;\n".replace(";;;", ";%g;%g;\"a;b\"") % (i, p[2], p[0], p[1])
                                                             for i, p in enumerate(POINTS)))
    text = open(d + "/t.csv").read().replace("Pos Z", "z")
    open(d + "/t.csv", "w").write(text)
    apply(d, d + "/t.csv", d + "/u.csv")
    rows = [l.split(";") for l in open(d + "/u.csv").read().split("\n")[:-1]]
    assert rows[0] == ["id", '"z"', "x [mm]", "y", "note"] and rows[1][0] == "p0" and rows[1][4:] == ['"a', 'b"'], rows[:2]
    got = np.array([[float(r[2]), float(r[3]), float(r[1])] for r in rows[1:]])
    assert np.abs(got - image_of(POINTS)).max() < NEAR * FACTOR
    np.savetxt(d + "/n.csv", np.c_[POINTS, np.arange(4)], delimiter=",", fmt="%g")
    apply(d, d + "/n.csv", d + "/m.csv")
    got = np.loadtxt(d + "/m.csv", delimiter=",")
    assert np.abs(got[:, :3] - image_of(POINTS)).max() < NEAR * FACTOR and (got[:, 3] == np.arange(4)).all()


def case_tables_as_programs_write_them(d):
    """A byte order mark, an index column without a name and tabs, CR ends."""
    rows = [[repr(float(n)) for n in p] for p in POINTS]
    texts = {"bom": "\ufeffx,y,z\n" + "".join(",".join(r) + "\n" for r in rows),
             "bare": "\ufeff" + "".join(",".join(r + ["7"]) + "\n" for r in rows),
             "pandas": "\tx\ty\tz\n" + "".join("\t".join([str(i)] + r) + "\n" for i, r in enumerate(rows)),
             "mac": "x,y,z\r" + "".join(",".join(r) + "\r" for r in rows)}
    for name, text in texts.items():
        with open(d + "/%s.csv" % name, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        apply(d, d + "/%s.csv" % name, d + "/out.csv")
        with open(d + "/out.csv", encoding="utf-8", newline="") as file:
            got = file.read()
        mark, end = "\t" if name == "pandas" else ",", "\r" if name == "mac" else "\n"
        lines = [l.split(mark) for l in got.lstrip("\ufeff").split(end)[:-1]]
        first = 1 if name == "pandas" else 0
        moved = np.array([[float(n) for n in l[first:first + 3]] for l in lines[0 if name == "bare" else 1:]])
        assert np.abs(moved - image_of(POINTS)).max() < NEAR * FACTOR, (name, moved)
        assert got.startswith("\ufeff") == (name in ("bom", "bare")), name


def case_ply(d):
    """Text and binary of both byte orders, doubles, other elements before the points; faces and colours are kept."""
    for order, kind in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        head = ("ply\nformat %s 1.0\nelement camera 1\nproperty list uchar short ids\nelement vertex 4\nproperty uchar red\n"
                "property double z\nproperty float x\nproperty float y\nelement face 1\nproperty list uchar int vertex_indices\n"
                "end_header\n" % kind).encode()
        body = struct.pack(order + "Bhh", 2, 7, 8)
        body += b"".join(struct.pack(order + "Bdff", 9 + i, p[2], p[0], p[1]) for i, p in enumerate(POINTS))
        body += struct.pack(order + "Biii", 3, 0, 1, 2)
        with open(d + "/b.ply", "wb") as file:
            file.write(head + body)
        apply(d, d + "/b.ply", d + "/c.ply")
        got = open(d + "/c.ply", "rb").read()
        assert got[:len(head)] == head and len(got) == len(head + body) and got[-13:] == body[-13:]
        assert got[len(head):len(head) + 5] == body[:5]
        rows = [struct.unpack_from(order + "Bdff", got, len(head) + 5 + 17 * i) for i in range(4)]
        assert [r[0] for r in rows] == [9, 10, 11, 12]
        moved = np.array([[r[2], r[3], r[1]] for r in rows])
        assert np.abs(moved - image_of(POINTS)).max() < NEAR * FACTOR, moved


def case_landmarks(d):
    """3D Slicer's points are in RAS where the file says so; names stay."""
    for said, sign in (("LPS", 1), ("RAS", -1)):
        lines = ["# Markups fiducial file version = 5.0", "# CoordinateSystem = " + said]
        lines += ["id%d,%g,%g,%g,0,0,0,1,1,1,0,name %d,," % (i, sign * p[0], sign * p[1], p[2], i) for i, p in enumerate(POINTS)]
        open(d + "/l.fcsv", "w").write("\n".join(lines) + "\n")
        apply(d, d + "/l.fcsv", d + "/m.fcsv")
        got = open(d + "/m.fcsv").read().split("\n")
        assert got[:2] == lines[:2] and "name 3" in got[5]
        moved = np.array([[float(n) for n in l.split(",")[1:4]] for l in got[2:6]]) * [sign, sign, 1]
        assert np.abs(moved - image_of(POINTS)).max() < NEAR * FACTOR, moved


def case_image(d):
    """A ramp in the object's own coordinates is carried with it; labels keep their numbers."""
    n = 48
    affine = np.diag([-1 / 16, -1 / 16, 1 / 16, 1])  # LPS axes
    affine[:3, 3] = [1.5, 1.5, -1.5]
    index = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1)
    world = index / 16 - 1.5
    ramp = (100 + 40 * world[..., 0] + 20 * world[..., 2]).astype(np.float32)
    nibabel.save(nibabel.Nifti1Image(ramp, affine), d + "/ramp.nii")
    step = FACTOR / 16
    target = np.diag([-step, -step, step, 1])
    target[:3, 3] = [1.5 * FACTOR - SHIFT[0], 1.5 * FACTOR - SHIFT[1], SHIFT[2] - 1.5 * FACTOR]
    nibabel.save(nibabel.Nifti1Image(ramp * 0, target), d + "/like.nii")
    apply(d, d + "/ramp.nii", d + "/out.nii.gz", "--like", d + "/like.nii", "--image", "grey")
    got = nibabel.load(d + "/out.nii.gz")
    assert np.allclose(got.affine, target, atol=1e-5)
    inside = (world[..., 0] ** 2 + (world[..., 1] / 0.6) ** 2 + (world[..., 2] / 0.4) ** 2) < 0.5
    # A point that is off by half a voxel is off by that in value along the ramp.
    slack = NEAR * np.hypot(40, 20)
    assert np.abs(got.get_fdata() - ramp)[inside].max() < slack, np.abs(got.get_fdata() - ramp)[inside].max()
    labels = np.where(world[..., 0] > 0, 7, 3).astype(np.int16)
    nibabel.save(nibabel.Nifti1Image(labels, affine), d + "/labels.nii")
    apply(d, d + "/labels.nii", d + "/moved.mha", "--like", d + "/like.nii", "--image", "labels")
    run("convert", d + "/moved.mha", "-o", d + "/moved.nii")
    got = nibabel.load(d + "/moved.nii").get_fdata()
    clear = inside & (np.abs(world[..., 0]) > NEAR + 1 / 32)
    assert (got[clear] == labels[clear]).all()


def case_space(d):
    """A carried image is in the space of the voxels that it is written on."""
    i, j, k = np.meshgrid(*[np.arange(24)] * 3, indexing="ij")
    ball = (100 * ((i - 11) ** 2 + (j - 12) ** 2 + (k - 12) ** 2 < 49)).astype(np.int16)
    for name, code, shift in (("one", 1, 0), ("four", 4, 2), ("three", 3, 0)):
        image = nibabel.Nifti1Image(np.roll(ball, shift, 0), np.eye(4))
        image.set_sform(np.eye(4), code), image.set_qform(np.eye(4), code)
        nibabel.save(image, d + "/" + name + ".nii")
    inputs = [d + "/" + name + ".nii" for name in ("one", "four", "one")]
    for options, code in (((), 4), (("--like", d + "/three.nii"), 3)):
        run("apply", *inputs, "-o", d + "/out.nii", "--image", "grey", "--align", "none", *options)
        header = nibabel.load(d + "/out.nii").header
        assert (int(header["sform_code"]), int(header["qform_code"])) == (code, code), (options, header)


def check_field(vectors, world, t0, t1):
    """Displacements at world points near the object, which is at a time."""
    size, here = 1 + t0 * (FACTOR - 1), t0 * SHIFT
    own = (world - here) / size
    inside = (own[..., 0] ** 2 + (own[..., 1] / 0.6) ** 2 + (own[..., 2] / 0.4) ** 2) < 0.5
    wanted = image_of(own, t1) - world
    assert inside.sum() > 200, inside.sum()
    off = np.abs(vectors - wanted)[inside].max()
    assert off < NEAR * FACTOR, off


def case_field(d):
    """The same numbers in all formats: LPS, at the points of --from, to where these are at --to."""
    field = lambda name, *more: run("apply", *pair(d), "--field", "-o", d + "/" + name, "--plan", plan(), *more)
    for t0, t1 in ((0, 1), (1, 0), (0, 0.5)):
        note = field("f.nii.gz", "--from", t0, "--to", t1).stderr
        assert "displacement" in note and "LPS" in note, note
        got = nibabel.load(d + "/f.nii.gz")
        assert got.header.get_intent()[0] == "vector" and got.shape[3:] == (1, 3), got.shape
        assert ("t=%g to t=%g, LPS mm" % (t0, t1)).encode() in got.header["descrip"].tobytes(), got.header["descrip"]
        index = np.stack(np.meshgrid(*map(np.arange, got.shape[:3]), indexing="ij"), -1)
        world = (index @ got.affine[:3, :3].T + got.affine[:3, 3]) * [-1, -1, 1]
        nifti = got.get_fdata()[..., 0, :]
        check_field(nifti, world, t0, t1)
    field("f.nii.gz")
    nifti = nibabel.load(d + "/f.nii.gz").get_fdata()[..., 0, :]
    field("f.nrrd")
    head, body = open(d + "/f.nrrd", "rb").read().split(b"\n\n", 1)
    assert b"kinds: vector domain domain domain" in head and b"space: left-posterior-superior" in head, head
    values = np.frombuffer(gzip.decompress(body), "<f4").reshape(nifti.shape[2::-1] + (3,))
    assert np.array_equal(values.transpose(2, 1, 0, 3), nifti.astype(np.float32))
    field("f.mha")
    whole = open(d + "/f.mha", "rb").read()
    at = whole.index(b"ElementDataFile = LOCAL\n") + 24
    assert b"ElementNumberOfChannels = 3" in whole[:at] and b"Comment = displacement from t=0 to t=1" in whole[:at]
    assert zlib.decompress(whole[at:]) == values.tobytes()
    field("f.vdb")
    grid = vdb.read(d + "/f.vdb", "displacement")
    low, high = grid.evalActiveVoxelBoundingBox()
    array = np.zeros([h - l + 1 for l, h in zip(low, high)] + [3], np.float32)
    grid.copyToArray(array, ijk=low)
    assert np.array_equal(array, nifti.astype(np.float32))


def case_plans(d):
    """By a plan the same comes out as without, for points and fields; the plan names the objects where nothing else does."""
    a, b = pair(d)
    with open(d + "/p.csv", "w") as file:
        file.write("x,y,z\n" + "".join("%.17g,%.17g,%.17g\n" % tuple(p) for p in POINTS))
    run("plan", a, b, "-o", d + "/x.plan", *SMALL)
    same = lambda one, other: open(d + one, "rb").read() == open(d + other, "rb").read()
    run("apply", a, b, d + "/p.csv", "-o", d + "/without.csv", *SMALL)
    run("apply", d + "/p.csv", "-o", d + "/by.csv", "--plan", d + "/x.plan")
    assert same("/without.csv", "/by.csv")
    run("apply", a, b, "--field", "-o", d + "/without.mha", *SMALL)
    run("apply", "--field", "-o", d + "/by.mha", "--plan", d + "/x.plan")
    assert same("/without.mha", "/by.mha")
    os.mkdir(d + "/moved")
    for name in ("a.obj", "b.obj"):
        os.rename(d + "/" + name, d + "/moved/" + name)
    words = [d + "/moved/a.obj", d + "/moved/b.obj", d + "/p.csv", "-o", d + "/moved.csv", "--plan", d + "/x.plan"]
    error = run("apply", d + "/p.csv", "-o", d + "/o.csv", "--plan", d + "/x.plan", code=1).stderr
    assert "a.obj" in error, error
    run("apply", *words)
    assert same("/without.csv", "/moved.csv")
    error = run("apply", *words, "--slices", 33, code=2).stderr
    assert "--slices 33" in error and "made with 32" in error, error
    error = run("apply", words[1], *words[:1], *words[2:], code=1).stderr
    assert "x.plan" in error and "other objects" in error, error
    open(d + "/job.toml", "w").write('inputs = ["moved/a.obj", "moved/b.obj"]\nresolution = 40\nslices = 32\n')
    run("plan", "--config", "job.toml", "-o", "job.plan", cwd=d)
    error = run("apply", d + "/p.csv", "-o", d + "/o.csv", "--plan", d + "/job.plan", code=1).stderr
    assert "job.plan" in error and "'config'" in error, error
    assert not os.path.exists(d + "/o.csv")


def case_wrong(d):
    """Messages name the file, the option and what would be right; nothing is written."""
    a, b = pair(d)
    open(d + "/bad.csv", "w").write("x,y,z\n1,2,3\n1,two,3\n")
    open(d + "/p.txt", "w").write("1 2 3\n")
    open(d + "/far.txt", "w").write("100 2 3\n")
    open(d + "/short.csv", "w").write("z,y,x\n1,2,3\n1\n")
    open(d + "/huge.txt", "w").write("1e300 2 3\n")
    open(d + "/count.off", "w").write("OFF\n1e300 0 0\n0 0 0\n")
    open(d + "/list.ply", "w").write("ply\nformat ascii 1.0\nelement strip 1\nproperty list int int of\nelement vertex 1\n"
                                     "property float x\nproperty float y\nproperty float z\nend_header\n1e300 5\n1 nan 3\n")
    for words, code, says in (
            ([a, b, d + "/p.txt", "-o", d + "/o.csv"], 2, ["o.csv", ".txt"]),
            ([a, b, d + "/none.txt", "-o", d + "/o.txt"], 1, ["none.txt", "no such file"]),
            ([a, b, d + "/bad.csv", "-o", d + "/o.csv"], 2, ["bad.csv:3", "'two'", "y"]),
            ([a, b, d + "/short.csv", "-o", d + "/o.csv"], 2, ["short.csv:3", "1 columns"]),
            ([a, b, d + "/huge.txt", "-o", d + "/o.txt"], 2, ["huge.txt:1"]),
            ([a, b, d + "/count.off", "-o", d + "/o.off"], 2, ["count.off:2", "number of points"]),
            ([a, b, d + "/list.ply", "-o", d + "/o.ply"], 2, ["list.ply", "point 1", "'nan'"]),
            ([a, b, a, "-o", d + "/o.stl"], 2, ["o.stl", ".obj"]),
            ([a, b, "-o", d + "/o.obj"], 2, ["two objects", "what is to be carried"]),
            ([a, b, "-o", d + "/o.obj", "--field"], 2, ["o.obj", ".nii.gz", ".vdb"]),
            ([a, "-o", d + "/o.vdb", "--field"], 2, ["two objects"]),
            ([a, b, d + "/p.txt", "-o", d + "/o.txt", "--to", 2], 2, ["--to 2", "0 to 1"]),
            ([a, b, d + "/p.txt", "-o", d + "/o.####.txt"], 2, ["####"])):
        error = run("apply", *words, code=code).stderr
        for said in says:
            assert said in error, (words, said, error)
    assert not [n for n in os.listdir(d) if n.startswith("o.")], os.listdir(d)
    assert "far from the objects" in apply(d, d + "/far.txt", d + "/f.txt").stderr


sys.exit(run_cases([(name.replace("_", " "), case) for name, case in named_cases(globals())], ONLY))
