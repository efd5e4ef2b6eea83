#!/usr/bin/env python3
"""Simulations and inputs of any size through the program: which grid is taken, empty frames, frame ranges, liquids,
components of velocities, strays, units, memory.

usage: simulation_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb; cases that read ../shared/data are skipped, with a message, where it does not exist.
"""
import json
import math
import os
import re
import resource
import struct
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_cases
from grids import level_set, names, real, write
from meshes import box_obj, sphere_obj

if len(sys.argv) < 2:
    sys.exit(__doc__)
PROGRAM = os.path.abspath(sys.argv[1])
ONLY = sys.argv[2:]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data")
H = 0.1  # voxel size of the small grids
GIB = 1 << 30


def run(*arguments, code=0, limit=None, peak=None):
    """Runs the program; `limit`: bytes of address space; `peak`: a list that gets the peak of its memory in bytes."""
    def before():
        if limit:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               errors="replace", preexec_fn=before)
    out, err = process.stdout.read(), process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if peak is not None:
        peak.append(usage.ru_maxrss * 1024)
    text = " ".join(map(str, arguments))
    assert process.returncode == code, "%s: exit %d\n%s" % (text, process.returncode, err)
    return subprocess.CompletedProcess(text, code, out, err)


def axes(low, high, h=H):
    low, high = np.floor(np.asarray(low) / h).astype(int), np.ceil(np.asarray(high) / h).astype(int)
    points = np.meshgrid(*[np.arange(low[a], high[a] + 1) * h for a in range(3)], indexing="ij")
    return points, tuple(int(i) for i in low)


def named(grid, name, kind, h=H):
    grid.name, grid.gridClass, grid.transform = name, kind, vdb.createLinearTransform(h)
    return grid


def fog(middle, radius, name="density", h=H):
    """A ball of density 1 with a soft rim; a radius of 0: a grid without voxels."""
    grid = vdb.FloatGrid(background=0.0)
    if radius:
        middle = np.asarray(middle, float)
        (x, y, z), origin = axes(middle - radius - h, middle + radius + h, h)
        distance = np.sqrt((x - middle[0]) ** 2 + (y - middle[1]) ** 2 + (z - middle[2]) ** 2) - radius
        grid.copyFromArray(np.clip(0.5 - distance / (2 * h), 0, 1).astype(np.float32), ijk=origin)
    return named(grid, name, vdb.GridClass.FOG_VOLUME, h)


def solid(distance, low, high, name, h=H):
    """A level set of a signed distance function of world coordinates, around a box."""
    (x, y, z), origin = axes(np.asarray(low) - 4 * h, np.asarray(high) + 4 * h, h)
    return level_set(distance(x, y, z), origin, h, name)


def box(low, high, name, h=H):
    low, high = np.asarray(low, float), np.asarray(high, float)
    middle, half = (low + high) / 2, (high - low) / 2

    def distance(x, y, z):
        q = [np.abs(p - middle[a]) - half[a] for a, p in enumerate((x, y, z))]
        return np.sqrt(sum(np.maximum(p, 0) ** 2 for p in q)) + np.minimum(np.maximum.reduce(q), 0)
    return solid(distance, low, high, name, h)


def ball(middle, radius, name="surface", h=H):
    middle = np.asarray(middle, float)
    return solid(lambda x, y, z: np.sqrt((x - middle[0]) ** 2 + (y - middle[1]) ** 2 + (z - middle[2]) ** 2) - radius,
                     middle - radius, middle + radius, name, h)


def total(path, name="density"):
    return sum(float(v.value) * v.count for v in vdb.read(path, name).citerOnValues())


def inside(path, name):
    """World positions of the voxels inside a level set, one a row."""
    grid = vdb.read(path, name)
    low, high = grid.evalActiveVoxelBoundingBox()
    array = np.zeros([high[a] - low[a] + 1 for a in range(3)], np.float32)
    grid.copyToArray(array, ijk=low)
    return (np.argwhere(array < 0) + np.asarray(low)) * grid.transform.voxelSize()[0]


# ---------------------------------------------------------------- sequences

def empty_frames_are_nothing(d):
    """A fog that begins and ends with empty frames: these are nothing, and the totals in between are its own share."""
    radii = [0, 0.6, 0.8, 0]
    for i, radius in enumerate(radii):
        write(d + "/a.%04d.vdb" % (i + 1), fog((0, 0, 0), radius))
    write(d + "/b.vdb", fog((0.5, 0, 0), 0.8))
    said = run("morph", d + "/a.####.vdb", d + "/b.vdb", "-o", d + "/m.####.vdb", "--velocity", "none").stderr
    assert "a.0001.vdb: holds nothing" in said and "a.0004.vdb: holds nothing" in said, said
    totals = [total(d + "/m.%04d.vdb" % (i + 1)) for i in range(4)]
    assert totals[0] == 0, totals
    # A third, and two thirds, of b's density, and of a ball about as large.
    whole = total(d + "/b.vdb")
    assert all(totals[i] > 0.2 * whole for i in (1, 2)) and abs(totals[3] / whole - 1) < 0.02, (totals, whole)
    assert "nothing in any" not in said
    for i in range(4):
        write(d + "/none.%04d.vdb" % (i + 1), fog((0, 0, 0), 0))
    error = run("morph", d + "/none.####.vdb", d + "/b.vdb", "-o", d + "/x.####.vdb", code=1).stderr
    assert "none.0001.vdb" in error and "active voxels" in error, error
    error = run("morph", d + "/a.0001.vdb", d + "/b.vdb", "-o", d + "/x.####.vdb", code=1).stderr
    assert "a.0001.vdb" in error, error
    run("render", d + "/a.####.vdb", "-o", d + "/p.####.png", "--size", "32x24", "--quiet")
    assert os.path.exists(d + "/p.0001.png") and os.path.exists(d + "/p.0004.png")


def empty_meshes_are_nothing(d):
    """Meshes without points and faces, as programs write them, are nothing as empty grids are; what is cut short is refused."""
    empty = {"obj": b"# written by a program\no nothing\n", "ply": b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
             b"property float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n",
             "stl": bytes(84), "off": b"OFF\n0 0 0\n",
             "glb": struct.pack("<4sIII4s", b"glTF", 2, 48, 28, b"JSON") + b'{"asset":{"version":"2.0"}} '}
    ball_ = sphere_obj(d + "/b.obj", 0.8, n=8)
    whole = sphere_obj(d + "/whole.obj", 0.6, n=8)
    for kind, data in empty.items():
        run("convert", whole, "-o", d + "/a_2.%s" % kind, "--resolution", 16) if kind != "off" else write_off(d + "/a_2.off", whole)
        for i in (1, 3):
            open(d + "/a_%d.%s" % (i, kind), "wb").write(data)
        said = run("morph", d + "/a_#." + kind, ball_, "-o", d + "/m.#.ply", "--at", "0,0.5", "--resolution", 16, "--method", "sdf",
                   "--report", d + "/r.json").stderr
        assert "a_1.%s: holds nothing" % kind in said, said
        volumes = [frame["volume"] for frame in json.load(open(d + "/r.json"))["frames"]]
        assert volumes[0] == 0 and volumes[1] > 0, (kind, volumes)
        error = run("convert", d + "/a_1." + kind, "-o", d + "/x.vdb", code=1).stderr
        assert "a_1." + kind in error and "empty" in error, error
    for cut in (b"# written by a progr", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", b"this is no mesh\n", b""):
        open(d + "/a_1.obj", "wb").write(cut)
        error = run("morph", d + "/a_#.obj", ball_, "-o", d + "/x.#.ply", "--at", "0,0.5", "--resolution", 16, "--method", "sdf", code=1).stderr
        assert "a_1.obj" in error, (cut, error)


def write_off(path, obj):
    rows = [line.split() for line in open(obj)]
    points = [row[1:] for row in rows if row[0] == "v"]
    faces = [[int(i) - 1 for i in row[1:]] for row in rows if row[0] == "f"]
    with open(path, "w") as file:
        file.write("OFF\n%d %d 0\n" % (len(points), len(faces)))
        file.writelines("%s\n" % " ".join(p) for p in points)
        file.writelines("3 %d %d %d\n" % tuple(f) for f in faces)


def liquid_grows_out_of_its_first_piece(d):
    """A level set whose first frame is empty, or lacks the grid: nothing, then it grows; the tank beside it is none."""
    tank = box((-1.2, -1.2, -1.2), (1.2, 1.2, 1.2), "phi_obstacle")
    empty = named(vdb.FloatGrid(background=3 * H), "phi", vdb.GridClass.LEVEL_SET)
    write(d + "/s.0001.vdb", tank)
    write(d + "/s.0002.vdb", tank, empty)
    write(d + "/s.0003.vdb", tank, ball((0.3, 0, 0), 0.5, "phi"))
    write(d + "/s.0004.vdb", tank, ball((0.3, 0, 0), 0.6, "phi"))
    write(d + "/b.vdb", ball((0.3, 0, 0), 0.8, "phi"))
    run("morph", d + "/s.####.vdb", d + "/b.vdb", "-o", d + "/m.####.vdb", "--velocity", "none", "--report", d + "/r.json", "--quiet")
    volumes = [frame["volume"] for frame in json.load(open(d + "/r.json"))["frames"]]
    assert volumes[0] == 0 and 0 < volumes[1] < volumes[2] < volumes[3], volumes
    # The last frame is b, a dense grid, whose surface is meshed and voxelised once: two errors of h^2 / 2 R of its radius.
    assert abs(volumes[3] / (4 / 3 * math.pi * 0.8 ** 3) - 1) < 3 * H ** 2 / 0.8 ** 2, volumes
    assert "phi" in names(d + "/m.0003.vdb") and "surface" not in names(d + "/m.0003.vdb")


def ranges(d):
    """name.####.vdb@A-BxS takes these files alone; missing ones are named."""
    for i in (1, 2, 3, 4, 5, 8, 9):
        write(d + "/a.%04d.vdb" % i, fog((0.1 * i, 0, 0), 0.6))
    write(d + "/b.vdb", fog((0, 0, 0), 0.6))
    run("morph", d + "/a.####.vdb@1-5x2", d + "/b.vdb", "-o", d + "/m.####.vdb", "--method", "dissolve", "--quiet")
    assert os.path.exists(d + "/m.0003.vdb") and not os.path.exists(d + "/m.0004.vdb")
    assert abs(total(d + "/m.0001.vdb") / total(d + "/a.0001.vdb") - 1) < 1e-6
    run("morph", d + "/a.####.vdb@2,4:density", d + "/b.vdb", "-o", d + "/n.####.vdb", "--method", "dissolve", "--quiet")
    assert os.path.exists(d + "/n.0002.vdb") and not os.path.exists(d + "/n.0003.vdb")
    error = run("morph", d + "/a.####.vdb@4-9", d + "/b.vdb", "-o", d + "/x.####.vdb", code=1).stderr
    assert "frames 6-7 are missing" in error, error
    said = run("morph", d + "/a.####.vdb", d + "/b.vdb", "-o", d + "/g.####.vdb", "--frames", 2, "--method", "dissolve").stderr
    assert "frames 6-7 are missing" in said, said
    for wrong in ("@9-4", "@1-", "@a", "@1-3x0", "@"):
        error = run("morph", d + "/a.####.vdb" + wrong, d + "/b.vdb", "-o", d + "/x.####.vdb", code=2).stderr
        assert "no range of frames" in error, (wrong, error)


# ---------------------------------------------------------------- grids

def liquid_before_obstacle(d):
    """phi before what stands still, by its name or as it is the same in both files; info says why."""
    tank = box((-1.5, -1.5, -0.2), (1.5, 1.5, 1.5), "phi_obstacle")
    a = write(d + "/a.vdb", tank, ball((0, 0, 0.6), 0.5, "phi"))
    b = write(d + "/b.vdb", tank, ball((0.3, 0, 0.6), 0.7, "phi"))
    said = run("morph", a, b, "-o", d + "/m.vdb", "--at", 0.5, "--velocity", "none").stderr
    assert "took grid 'phi' of 2" in said and "one world" in said, said
    assert set(names(d + "/m.vdb")) == {"phi", "phi_obstacle"}, names(d + "/m.vdb")
    info = json.loads(run("info", a, "--json").stdout)
    assert info["chosen"] == "phi" and "liquid" in info["why"], info
    # Half way the ball has the mean radius.
    radius = (len(inside(d + "/m.vdb", "phi")) * H ** 3 * 3 / (4 * math.pi)) ** (1 / 3)
    assert abs(radius - 0.6) < 0.5 * H, radius
    # Without names that tell, what does not change is passed over.
    still = box((-1.5, -1.5, -0.2), (1.5, 1.5, 1.5), "aaa")
    a = write(d + "/c.vdb", still, ball((0, 0, 0.6), 0.5, "bbb"))
    b = write(d + "/d.vdb", still, ball((0.3, 0, 0.6), 0.7, "bbb"))
    said = run("morph", a, b, "-o", d + "/n.vdb", "--at", 0.5, "--method", "sdf").stderr
    assert "took grid 'bbb' of 2" in said, said
    # The obstacle is drawn where it is named, and only there.
    pictures = [run("render", d + "/a.vdb" + grid, "-o", d + "/p.png", "--size", "32x24", "--view", "0,1,0", "--up", "z", "--quiet")
                and open(d + "/p.png", "rb").read() for grid in ("", ":phi", ":phi_obstacle")]
    assert pictures[0] == pictures[1] != pictures[2]
    # Alone it is a shape like any other.
    write(d + "/t.vdb", tank)
    assert json.loads(run("info", d + "/t.vdb", "--json").stdout)["chosen"] == "phi_obstacle"


def real_liquid(d):
    path = real(DATA, "vdb/liquid_0040.vdb")
    assert json.loads(run("info", path, "--json").stdout)["chosen"] == "phi"


def types_and_marks(d):
    """The half flag stays; marks and statistics of the inputs' boxes do not."""
    for half in (False, True):
        for name, radius in (("a", 0.5), ("b", 0.7)):
            grid = ball((0, 0, 0), radius, "shape", h=0.2)
            grid.saveFloatAsHalf = half
            grid.updateMetadata({"file_base_resolution": "7 7 7", "roi": "1 2 3", "artist": "kept"})
            write(d + "/%s.vdb" % name, grid, render_bbox="9", scene="kept")
        run("morph", d + "/a.vdb", d + "/b.vdb", "-o", d + "/m.####.vdb", "--frames", 3, "--method", "sdf", "--quiet")
        for i in (1, 2, 3):
            path = d + "/m.%04d.vdb" % i
            grid = vdb.readGridMetadata(path, "shape")
            assert bool(grid.saveFloatAsHalf) == half, path
            assert not {"file_base_resolution", "roi"} & set(grid.metadata), grid.metadata
            whole = vdb.readMetadata(path)
            assert "render_bbox" not in whole and whole["scene"] == "kept", whole
            low, high = grid.metadata["file_bbox_min"], grid.metadata["file_bbox_max"]
            assert (tuple(low), tuple(high)) == vdb.read(path, "shape").evalActiveVoxelBoundingBox()


def components_of_velocity(d):
    """vel.x vel.y vel.z are one field: it turns with the map, is added, and is written as three grids again."""
    def gas(angle, middle):
        c, s = math.cos(angle), math.sin(angle)
        middle = np.asarray(middle, float)
        (x, y, z), origin = axes(middle - 1.6, middle + 1.6)
        u, v = c * (x - middle[0]) + s * (y - middle[1]), c * (y - middle[1]) - s * (x - middle[0])
        values = np.exp(-0.5 * ((u / 0.5) ** 2 + (v / 0.25) ** 2 + ((z - middle[2]) / 0.25) ** 2))
        values += 0.8 * np.exp(-0.5 * (((u - 0.6) / 0.2) ** 2 + ((v - 0.3) / 0.2) ** 2 + ((z - middle[2]) / 0.2) ** 2))
        values[values < 1e-3] = 0
        grids = []
        for name, number in (("density", None), ("vel.x", -2 * s), ("vel.y", 2 * c), ("vel.z", 0)):
            grid = vdb.FloatGrid(background=0.0)
            grid.copyFromArray((values if number is None else np.where(values > 0, number, 0)).astype(np.float32), ijk=origin)
            grids.append(named(grid, name, vdb.GridClass.FOG_VOLUME if number is None else vdb.GridClass.UNKNOWN))
        return grids
    a, b = write(d + "/a.vdb", *gas(0, (0, 0, 0))), write(d + "/b.vdb", *gas(math.pi / 2, (0, 0, 0)))
    common = ["morph", a, b, "-o", d + "/m.####.vdb", "--frames", 3, "--fps", 24, "--align", "auto", "--quiet"]
    run(*common)
    assert set(names(d + "/m.0002.vdb")) == {"density", "vel.x", "vel.y", "vel.z", "vel_morph"}
    at = lambda name: vdb.read(d + "/m.0002.vdb", name).getConstAccessor().getValue((0, 0, 0))
    # The flow turns by 45 degrees with the gas; as numbers it would be (-1, 1, 0).
    got = [at("vel.x"), at("vel.y"), at("vel.z")]
    assert np.abs(np.array(got) - [-math.sqrt(2), math.sqrt(2), 0]).max() < 0.1, got
    alone = np.array(at("vel_morph"))
    # The ends hold what the inputs hold.
    x = vdb.read(d + "/m.0001.vdb", "vel.y").getConstAccessor().getValue((0, 0, 0))
    assert x == 2, x
    run(*common, "--add-velocity")
    assert set(names(d + "/m.0002.vdb")) == {"density", "vel.x", "vel.y", "vel.z", "vel"}
    summed = np.array(at("vel"))
    assert np.abs(summed - alone - got).max() < 1e-4 and np.allclose(summed, [at("vel.x"), at("vel.y"), at("vel.z")])
    said = run("morph", write(d + "/c.vdb", fog((0, 0, 0), 0.5)), write(d + "/e.vdb", fog((0, 0, 0), 0.6)), "-o", d + "/v.vdb",
               "--at", 1, "--add-velocity").stderr
    assert "--add-velocity: no input has a velocity grid" in said, said


def stray_voxel(d):
    """One voxel three hundred lengths away takes no part in the matching, and nothing of the body is lost."""
    a = fog((0, 0, 0), 0.8)
    a.getAccessor().setValueOn((3000, 0, 0), 1.0)
    write(d + "/a.vdb", a)
    write(d + "/b.vdb", fog((1, 0, 0), 0.8))
    said = run("morph", d + "/a.vdb", d + "/b.vdb", "-o", d + "/m.vdb", "--at", 0.5, "--velocity", "none").stderr
    assert "takes no part in the matching" in said, said
    whole = total(d + "/b.vdb")
    assert abs(total(d + "/m.vdb") / whole - 1) < 0.05, (total(d + "/m.vdb"), whole)


def smaller_than_a_voxel(d):
    """A mesh smaller than one voxel is refused by name, beside fog and beside a mesh; nothing crashes."""
    tiny, ball_ = sphere_obj(d + "/tiny.obj", 0.05), sphere_obj(d + "/ball.obj", 1)
    gas = write(d + "/gas.vdb", fog((0, 0, 0), 0.8))
    for other in (gas, ball_):
        for pair in ((other, tiny), (tiny, other)):
            error = run("morph", *pair, "-o", d + "/m.####.vdb", "--frames", 3, "--voxel-size", 0.3, code=1).stderr
            assert "tiny" in error and "voxel size of at most" in error, error


# ---------------------------------------------------------------- liquids

def column_sinks(d):
    """A column of liquid becomes a wide pool: it sinks and spreads, and nothing topples."""
    a = write(d + "/liquid_0040.vdb", box((-0.4, -0.4, 0), (0.4, 0.4, 2.4), "phi"))
    b = write(d + "/liquid_0100.vdb", box((-1.2, -1.2, 0), (1.2, 1.2, 0.4), "phi"))
    said = run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 5, "--velocity", "none").stderr
    assert "one world" in said, said
    heights, widths = [], []
    for i in range(5):
        points = inside(d + "/m.%04d.vdb" % (i + 1), "phi")
        low, high = points.min(0), points.max(0)
        heights.append(high[2] - low[2] + H), widths.append(high[:2] - low[:2] + H)
        # What stands on the floor stays there, and the axis stays in the middle: to a voxel.
        assert abs(low[2]) < 1.5 * H and np.abs(points.mean(0)[:2]).max() < H, (i, low, points.mean(0))
    assert all(x > y for x, y in zip(heights, heights[1:])), heights
    assert all((x < y).all() for x, y in zip(widths, widths[1:])), widths
    said = run("morph", a, b, "-o", d + "/t.ply", "--at", 1, "--align", "auto").stderr
    assert "one world" not in said
    # Numbered files of one folder are of one simulation, whatever their grids are called; others are not.
    for one, other, together in (("x_1", "x_2", True), ("x", "y", False)):
        write(d + "/%s.vdb" % one, ball((0, 0, 0), 0.5)), write(d + "/%s.vdb" % other, ball((0, 0, 0), 0.6))
        said = run("morph", d + "/%s.vdb" % one, d + "/%s.vdb" % other, "-o", d + "/u.ply", "--at", 1).stderr
        assert ("one world" in said) == together, (one, other, said)


def splash(d):
    """Drops that fall into a pool: pieces come and join; nothing is lost, nothing turns."""
    pool = lambda x, y, z, top: np.maximum.reduce([np.abs(x) - 1, np.abs(y) - 1, z - top, -z])
    drop = lambda x, y, z, p: np.sqrt((x - p[0]) ** 2 + (y - p[1]) ** 2 + (z - p[2]) ** 2) - 0.2

    def frame(path, top, drops):
        f = lambda x, y, z: np.minimum.reduce([pool(x, y, z, top)] + [drop(x, y, z, p) for p in drops])
        return write(path, solid(f, (-1, -1, 0), (1, 1, 2), "phi", h=0.08))
    a = frame(d + "/s_01.vdb", 0.5, [(0.5, 0.3, 1.5), (-0.4, -0.2, 1.2)])
    b = frame(d + "/s_02.vdb", 0.56, [])
    run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 5, "--velocity", "none", "--report", d + "/r.json", "--quiet")
    report = json.load(open(d + "/r.json"))
    volumes = [f["volume"] for f in report["frames"]]
    assert report["settings"]["align"] == "directions"
    assert min(volumes) > 0.9 * min(volumes[0], volumes[-1]) and max(volumes) < 1.1 * max(volumes[0], volumes[-1]), volumes
    for i in range(5):
        low = inside(d + "/m.%04d.vdb" % (i + 1), "phi").min(0)
        assert abs(low[2]) < 0.12, (i, low)


# ---------------------------------------------------------------- sizes

def metres_and_millimetres(d):
    """Sizes that differ by more than 20 are told, with both; --fit and braces bring them together, and the report tells how."""
    small = box_obj(d + "/small.obj", (0, 0, 0), (1, 3, 2))
    large = box_obj(d + "/large.obj", (5000, 0, 0), (6000, 2000, 3000))  # in millimetres, and z up
    said = run("morph", small, large, "-o", d + "/m.ply", "--at", 1, "--resolution", 32).stderr
    assert "metres and millimetres" in said and "3 long" in said and "3000" in said, said
    for braces, fit in (("{scale=0.001}", "none"), ("", "size"), ("{upright=z}", "box")):
        said = run("morph", small, large + braces, "-o", d + "/m.####.ply", "--frames", 2, "--fit", fit, "--resolution", 32,
                   "--report", d + "/r.json").stderr
        assert "metres and millimetres" not in said and "was scaled by 0.001" in said or "was scaled by 0.00" in said, said
        entry = json.load(open(d + "/r.json"))["inputs"][1]
        matrix = np.array(entry["transform"])
        assert abs(abs(np.linalg.det(matrix[:3, :3])) / 1e-9 - 1) < 0.1, matrix
        assert abs(entry["volume"] / 6 - 1) < 0.1, entry
        # The inverse takes the last frame back to the input.
        data = open(d + "/m.0002.ply", "rb").read()
        count = int(re.search(rb"element vertex (\d+)", data).group(1))
        start = data.index(b"end_header\n") + 11
        stride = 4 * len(re.findall(rb"property float", data))
        points = np.array([struct.unpack_from("<fff", data, start + i * stride) for i in range(count)])
        back = (points - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
        # To a voxel of 3000 / 32.
        assert np.abs(back.min(0) - [5000, 0, 0]).max() < 100 and np.abs(back.max(0) - [6000, 2000, 3000]).max() < 100, back
        if fit == "box":
            assert np.abs(points.mean(0) - [0.5, 1.5, 1]).max() < 0.1, points.mean(0)
    with open(d + "/job.toml", "w") as job:
        job.write('inputs = ["%s", {file = "%s", scale = 0.001, upright = "z"}]\noutput = "%s"\nat = 0.5\nresolution = 32\nmethod = "sdf"\n' %
                  (small, large, d + "/j.vdb"))
    assert "was scaled by 0.001" in run("morph", "--config", d + "/job.toml").stderr
    for wrong in ("{scale=0}", "{scale=x}", "{upright=w}", "{}", "{size=3}"):
        error = run("morph", small, large + wrong, "-o", d + "/m.vdb", code=2).stderr
        assert "in braces stand" in error, (wrong, error)


def far_from_zero(d):
    """A ball of radius 5 at coordinates where single precision has steps of half a unit: as round as at 0."""
    middle = np.array([500000.25, 4649776.125, 300.0])
    points, faces = [], []
    for line in open(sphere_obj(d + "/near.obj", 5)):
        words = line.split()
        points.append([float(w) for w in words[1:]]) if words[0] == "v" else faces.append([int(w) - 1 for w in words[1:]])
    with open(d + "/far.obj", "w") as file:
        file.writelines("v %.6f %.6f %.6f\n" % tuple(np.array(p) + middle) for p in points)
        file.writelines("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)
    with open(d + "/far.ply", "wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
                   b"element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(points), len(faces)))
        file.write((np.array(points) + middle).astype("<f8").tobytes())
        file.write(b"".join(struct.pack("<B3i", 3, *f) for f in faces))
    data = np.array(points, "<f4").tobytes() + np.array(faces, "<u4").tobytes()
    text = json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                       "nodes": [{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *middle, 1]}],
                       "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "buffers": [{"byteLength": len(data)}],
                       "bufferViews": [{"buffer": 0, "byteLength": 12 * len(points)},
                                       {"buffer": 0, "byteOffset": 12 * len(points), "byteLength": 12 * len(faces)}],
                       "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": [-5] * 3, "max": [5] * 3},
                                     {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"}]}).encode()
    text += b" " * (-len(text) % 4)
    with open(d + "/far.glb", "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text +
                   struct.pack("<I4s", len(data), b"BIN\0") + data)
    volume = json.loads(run("info", d + "/near.obj", "--json").stdout)["mesh"]["signedVolume"]
    for kind in ("obj", "ply", "glb"):
        mesh = json.loads(run("info", d + "/far." + kind, "--json").stdout)["mesh"]
        assert abs(mesh["signedVolume"] / volume - 1) < 1e-5, (kind, mesh)
        assert np.abs(np.array(mesh["box"]) - [middle - 5, middle + 5]).max() < 0.01, (kind, mesh["box"])
        run("convert", d + "/far." + kind, "-o", d + "/far.vdb", "--resolution", 32)
        grid = vdb.read(d + "/far.vdb", "surface")
        h = grid.transform.voxelSize()[0]
        off = [abs(np.linalg.norm(np.array(grid.transform.indexToWorld(v.min)) - middle) - 5 - v.value) for v in grid.citerOnValues()
               if abs(v.value) < h]
        # Facets lie up to R (1 - cos(pi / 48)) = 0.011 inside the ball, across a quad twice that.
        assert len(off) > 1000 and max(off) < 0.025, (kind, len(off), max(off))


def braces_everywhere(d):
    """What stands in braces or as a range behind an input is done by every command, or refused by the input's name."""
    box_ = box_obj(d + "/box.obj", (0, 0, 0), (1, 3, 2))
    run("convert", box_, "-o", d + "/box.vdb", "--resolution", 24)
    run("convert", box_, "-o", d + "/box.nii", "--resolution", 24)
    run("slice", d + "/box.vdb", "-o", d + "/e.##.exr", "--slices", 6)
    for i in (1, 2, 3):
        run("convert", box_ + "{scale=%d}" % i, "-o", d + "/s.%d.vdb" % i, "--resolution", 24)
    info = lambda name: json.loads(run("info", name, "--json").stdout)
    size = lambda box_: np.subtract(box_[1], box_[0])
    assert np.allclose(info(box_ + "{scale=10,upright=z}")["mesh"]["box"], [[0, 0, -30], [10, 20, 0]]), info(box_ + "{scale=10,upright=z}")
    assert abs(info(box_ + "{scale=10}")["mesh"]["signedVolume"] / 6000 - 1) < 1e-6
    one, ten = info(d + "/box.vdb")["grids"][0], info(d + "/box.vdb{scale=10}")["grids"][0]
    for key in ("box", "voxelSize", "minimum", "maximum", "background"):
        assert np.allclose(np.multiply(one[key], 10), ten[key]), (key, one, ten)
    # A sequence of one file is that file; one of several is refused, with an example.
    assert size(info(d + "/s.#.vdb@3")["grids"][0]["box"])[1] > 8
    for command, more in (("info", []), ("compare", [box_]), ("convert", ["-o", d + "/x.ply"]), ("slice", ["-o", d + "/x.exr"])):
        error = run(command, d + "/s.#.vdb@2-3", *more, code=2).stderr
        assert "s.#.vdb@2-3" in error and "a sequence of 2 files" in error and "s.2.vdb" in error, error
        error = run(command, box_ + "{fit=size}", *more, code=2).stderr
        assert "box.obj{fit=size}" in error and "morph" in error, error
    assert abs(json.loads(run("compare", d + "/s.#.vdb@2", box_ + "{scale=2}", "--resolution", 24, "--json").stdout)["dice"] - 1) < 0.02
    run("convert", d + "/s.#.vdb@3", "-o", d + "/three.ply")
    assert size(info(d + "/three.ply")["mesh"]["box"])[1] > 8
    run("slice", d + "/s.#.vdb@2{scale=0.5}", "-o", d + "/half.exr", "--slices", 3)
    error = run("render", d + "/box.vdb{fit=box}", "-o", d + "/x.png", code=2).stderr
    assert "box.vdb{fit=box}" in error, error
    error = run("convert", d + "/box.nii", "-o", d + "/x.nii", "--like", d + "/box.nii{fit=box}", code=2).stderr
    assert "box.nii{fit=box}" in error, error
    # Slices lie where their attributes say; a range takes some of them.
    assert "e.##.exr{scale=2}: slices" in run("reconstruct", d + "/e.##.exr{scale=2}", "-o", d + "/x.vdb", code=2).stderr
    assert "3 slices of 6" in run("reconstruct", d + "/e.##.exr@2-4", "-o", d + "/r.vdb").stderr
    for wrong, says in (([box_ + "{scale=2}", box_, box_], "leave them out"), ([box_, box_, box_ + "{scale=2}"], "leave them out"),
                        ([box_, box_, d + "/s.#.obj"], "is a sequence"), ([d + "/s.#.vdb@2", box_, box_], "is a sequence")):
        error = run("apply", *wrong, "-o", d + "/x.obj", code=2).stderr
        assert says in error and next(w for w in wrong if w != box_) in error, error
    assert not [name for name in os.listdir(d) if name.startswith("x.")], os.listdir(d)


def fog_is_placed(d):
    """Grids of a VDB are placed with their shape: distances and velocities are scaled, densities are not."""
    write(d + "/a.vdb", fog((0, 0, 0), 0.8))
    big = fog((1000, 0, 0), 80, h=10)
    flow = vdb.Vec3SGrid()
    flow.fill(*big.evalActiveVoxelBoundingBox(), (10.0, 20.0, 30.0))
    write(d + "/b.vdb", big, named(flow, "v", vdb.GridClass.UNKNOWN, 10))
    run("morph", d + "/a.vdb", d + "/b.vdb", "-o", d + "/m.####.vdb", "--frames", 2, "--fit", "box", "--method", "dissolve", "--quiet")
    grid = vdb.read(d + "/m.0002.vdb", "density")
    middle = np.mean([grid.transform.indexToWorld(c) for c in grid.evalActiveVoxelBoundingBox()], 0)
    assert np.abs(middle).max() < 0.1, middle
    peak = max(v.value for v in grid.citerOnValues())
    assert abs(peak - 1) < 1e-6 and abs(total(d + "/m.0002.vdb") / total(d + "/b.vdb") - 1) < 1e-6
    # By the ratio of the sizes, a hundredth; and z comes to lie along y.
    at = vdb.read(d + "/m.0002.vdb", "v").getConstAccessor().getValue(grid.evalActiveVoxelBoundingBox()[0])
    assert np.abs(np.array(at) - [0.1, 0.2, 0.3]).max() < 0.01, at
    run("morph", d + "/a.vdb", d + "/b.vdb{scale=0.01,upright=z}", "-o", d + "/t.vdb", "--at", 1, "--method", "dissolve", "--quiet")
    at = vdb.read(d + "/t.vdb", "v").getConstAccessor().getValue(vdb.read(d + "/t.vdb", "v").evalActiveVoxelBoundingBox()[0])
    assert np.abs(np.array(at) - [0.1, 0.3, -0.2]).max() < 1e-6, at


# ---------------------------------------------------------------- memory

def a_marble_and_a_planet(d):
    """A ball of radius 1 to one of radius 2000: reports, GLB, EXR slices and pictures stay below 1 GiB."""
    a, b = sphere_obj(d + "/a.obj", 1), sphere_obj(d + "/b.obj", 2000)
    common = ["--resolution", 32, "--quiet"]
    peaks = []
    run("morph", a, b, "-o", d + "/m.glb", "--frames", 3, *common, "--report", d + "/r.json", "--report", d + "/r.html", peak=peaks)
    frames = json.load(open(d + "/r.json"))["frames"]
    ball_ = lambda r: 4 / 3 * math.pi * r ** 3
    # What is inside one of two frames: the larger, to the error of 32 voxels.
    assert abs(frames[2]["symmetricDifference"] / (ball_(2000) - ball_(1000.5)) - 1) < 0.03, frames[2]
    assert abs(frames[1]["symmetricDifference"] / ball_(1000.5) - 1) < 0.03, frames[1]
    for output, more in (("s.exr", ["--exr", "slices", "--exr-slices", 1]), ("p.png", ["--size", "64x48"]), ("m.vdb", [])):
        run("morph", a, b, "-o", d + "/" + output, "--at", 0.5, *common, *more, peak=peaks)
    run("render", a, b, "-o", d + "/q.####.png", "--size", "64x48", "--resolution", 32, "--quiet", peak=peaks)
    run("compare", a, b, "--resolution", 32, peak=peaks)
    assert max(peaks) < GIB, [p / GIB for p in peaks]


def memory_is_told(d):
    """What does not fit --memory or the system's own limits ends with a message that says what to change."""
    a, b = sphere_obj(d + "/a.obj", 1), sphere_obj(d + "/b.obj", 0.6)
    gas = fog((0, 0, 0), 0.5)
    gas.getAccessor().setValueOn((2000, 2000, 2000), 1.0)
    far = write(d + "/far.vdb", gas)
    jobs = [["morph", a, b, "-o", d + "/m.####.vdb", "--frames", 2, "--resolution", 64, "--memory", "120M"],
            ["convert", a, "-o", d + "/c.vdb", "--resolution", 2048, "--memory", "300M"],
            ["convert", far, "-o", d + "/c.nii.gz", "--memory", "1G"],
            ["render", a, "-o", d + "/p.png", "--size", "16000x16000", "--memory", "1G"]]
    for job in jobs:
        peaks = []
        error = run(*job, code=1, peak=peaks).stderr
        assert "--memory" in error and "about" in error or "out of memory" in error, (job, error)
        assert peaks[0] < 1.3 * GIB, (job, peaks)
    for limit in (300, 500, 900):
        process = subprocess.run(["prlimit", "--as=%d" % (limit << 20), PROGRAM, "convert", a, "-o", d + "/c.vdb", "--resolution", "1024"],
                                 capture_output=True, text=True)
        assert process.returncode == 1 and "memory" in process.stderr, (limit, process.returncode, process.stderr)
    assert not [f for f in os.listdir(d) if ".tmp-" in f], os.listdir(d)
    # Images and slices by what their headers say, before their values are read; the files are small.
    edge = 1000
    header = struct.pack("<i36x8h14xhh2x8f4xf", 348, 3, edge, edge, edge, 1, 1, 1, 1, 4, 16, 1, 1, 1, 1, 0, 0, 0, 0, 352)
    header = header.ljust(344, b"\0") + b"n+1\0" + bytes(4)
    open(d + "/big.nii", "wb").write(header)
    os.truncate(d + "/big.nii", 352 + 2 * edge ** 3)
    open(d + "/big.nhdr", "w").write("NRRD0004\ntype: short\ndimension: 3\nsizes: %d %d %d\nencoding: raw\nendian: little\ndata file: big.raw\n" %
                                     (edge, edge, edge))
    open(d + "/big.mhd", "w").write("ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = %d %d %d\nElementType = MET_SHORT\n"
                                    "ElementDataFile = big.raw\n" % (edge, edge, edge))
    open(d + "/big.raw", "wb").close()
    os.truncate(d + "/big.raw", 2 * edge ** 3)
    for name in ("big.nii", "big.nhdr", "big.mhd"):
        peaks = []
        error = run("convert", d + "/" + name, "-o", d + "/x.vdb", "--memory", "1G", code=1, peak=peaks).stderr
        assert name in error and "1000 x 1000 x 1000 voxels" in error and "--memory" in error, error
        assert peaks[0] < GIB, (name, peaks)
    run("convert", a, "-o", d + "/a.vdb", "--resolution", 16)
    run("slice", d + "/a.vdb", "-o", d + "/fine.exr", "--slices", 20, "--pixel-size", 0.002, "--half", "--compression", "rle")
    error = run("reconstruct", d + "/fine.exr", "-o", d + "/x.vdb", "--memory", "100M", code=1).stderr
    assert "fine.exr" in error and "its slices" in error and "--memory" in error, error
    for wrong in ("4", "x", "-1G", "0M", "4Q"):
        assert "expected a size" in run("info", a, "--memory", wrong, code=2).stderr
    for little in ("1K", "60M", "99M", "0.0001%"):
        assert "give it 100M or more" in run("info", a, "--memory", little, code=2).stderr
    for right in ("4G", "2000M", "1.5GiB", "50%"):
        run("info", a, "--memory", right)


def claims_of_exr_headers(d):
    """A header that claims more than a file of its size can hold is refused at once."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data

    def header(width, height, compression):
        window = struct.pack("<4i", 0, 0, width - 1, height - 1)
        return (struct.pack("<ii", 20000630, 2) +
                attribute(b"channels", b"chlist", b"Y\0" + struct.pack("<iBBBBii", 2, 0, 0, 0, 0, 1, 1) + b"\0") +
                attribute(b"compression", b"compression", bytes([compression])) +
                attribute(b"dataWindow", b"box2i", window) + attribute(b"displayWindow", b"box2i", window) +
                attribute(b"lineOrder", b"lineOrder", b"\0") + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) +
                attribute(b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0)) +
                attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0")
    for width, height, compression in ((60000, 60000, 3), (1 << 30, 1, 0), (1, (1 << 31) - 1, 0), (16384, 1 << 20, 9)):
        for i in (1, 2):
            with open(d + "/x.%02d.exr" % i, "wb") as file:
                file.write(header(width, height, compression) + bytes(256))
        for job in (["convert", d + "/x.##.exr", "-o", d + "/o.nii.gz", "--spacing", "1,1,1"],
                    ["reconstruct", d + "/x.01.exr", "-o", d + "/o.vdb"], ["info", d + "/x.##.exr"]):
            peaks = []
            error = run(*job, code=1, peak=peaks).stderr
            assert "its header claims %d x %d" % (width, height) in error and peaks[0] < GIB, (job, error, peaks)


CASES = [empty_frames_are_nothing, empty_meshes_are_nothing, liquid_grows_out_of_its_first_piece, ranges, liquid_before_obstacle, real_liquid,
         types_and_marks, components_of_velocity, stray_voxel, smaller_than_a_voxel, column_sinks, splash,
         metres_and_millimetres, far_from_zero, braces_everywhere, fog_is_placed, a_marble_and_a_planet, memory_is_told, claims_of_exr_headers]
sys.exit(run_cases([(case.__name__, case) for case in CASES], ONLY))
