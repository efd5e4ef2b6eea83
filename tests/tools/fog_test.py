#!/usr/bin/env python3
"""Fog volumes, other grids, velocities and sequences through the program, read by pyopenvdb and vdb_print.

usage: fog_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb; cases that read ../shared/data/vdb are skipped, with a message, where it does
not exist.
"""
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_cases
from grids import level_set, names, real, write

if len(sys.argv) < 2:
    sys.exit(__doc__)
PROGRAM = os.path.abspath(sys.argv[1])
ONLY = sys.argv[2:]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data/vdb")
FPS = 24


def run(*arguments, code=0):
    result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, errors="replace", timeout=300)
    assert result.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, arguments)), result.returncode, result.stderr)
    return result


def fog(values, transform, name="density", kind=vdb.FloatGrid):
    """A grid of values[i, j, k] on a box whose index coordinates begin at `origin`."""
    array, origin = values
    grid = kind(background=0.0) if kind is vdb.FloatGrid else kind()
    grid.copyFromArray(array, ijk=origin)
    if kind is vdb.FloatGrid:
        grid.prune()
        grid.gridClass = vdb.GridClass.FOG_VOLUME
    grid.transform = transform
    grid.name = name
    return grid


def box(middle, reach, h):
    low = np.floor((np.asarray(middle) - reach) / h).astype(int)
    high = np.ceil((np.asarray(middle) + reach) / h).astype(int)
    axes = [np.arange(low[a], high[a] + 1) * h - middle[a] for a in range(3)]
    return np.meshgrid(*axes, indexing="ij"), tuple(int(i) for i in low)


def puff(middle, widths, h, turn=np.eye(3), name="density"):
    """exp(-|turn^T (p - middle) / widths|^2 / 2), cut below a thousandth."""
    (x, y, z), origin = box(middle, 4 * max(widths), h)
    local = np.stack([x, y, z], -1) @ turn
    values = np.exp(-0.5 * ((local / np.asarray(widths)) ** 2).sum(-1)).astype(np.float32)
    values[values < 1e-3] = 0
    return fog((values, origin), vdb.createLinearTransform(h), name)


def solid(distance, middle, reach, h, name="surface"):
    """A level set of a signed distance function of coordinates relative to `middle`."""
    (x, y, z), origin = box(middle, reach, h)
    return level_set(distance(x, y, z), origin, h, name)


def dense(grid):
    low, high = grid.evalActiveVoxelBoundingBox()
    shape = [high[a] - low[a] + 1 for a in range(3)]
    array = np.zeros(shape + ([3] if grid.valueTypeName == "vec3s" else []),
                     np.float32 if grid.valueTypeName != "bool" else bool)
    grid.copyToArray(array, ijk=low)
    return array, np.asarray(low)


def figures(grid):
    """Total, peak and centroid of a fog."""
    array, low = dense(grid)
    matrix = np.array([grid.transform.indexToWorld(tuple(float(i == a) for i in range(3))) for a in range(3)])
    origin = np.array(grid.transform.indexToWorld((0.0, 0.0, 0.0)))
    total = float(array.sum(dtype=np.float64))
    middle = np.array([(array.sum(axis=tuple(b for b in range(3) if b != a), dtype=np.float64) *
                        (np.arange(array.shape[a]) + low[a])).sum() / total for a in range(3)])
    return total * abs(np.linalg.det(matrix - origin)), float(array.max()), origin + middle @ (matrix - origin)


def frames(folder, name="m"):
    return [os.path.join(folder, f) for f in sorted(os.listdir(folder)) if re.match(name + r"\.\d+\.vdb$", f)]


def metadata(path, name):
    return vdb.readGridMetadata(path, name).metadata


# ---------------------------------------------------------------- puffs

def puff_travels(d):
    """Puffs ten widths apart: in-betweens have one of the same peak and total; cross-dissolve has two."""
    to = np.array([8.0, -5.0, 3.3])
    a = write(d + "/a.vdb", puff((0, 0, 0), (1, 1, 1), 0.25))
    b = write(d + "/b.vdb", puff(to, (1, 1, 1), 0.25))
    run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 4, "--velocity", "none", "--quiet")
    total, peak, _ = figures(vdb.read(a, "density"))
    for i, path in enumerate(frames(d)):
        t = i / 3
        at = figures(vdb.read(path, "density"))
        assert abs(at[0] / total - 1) < 0.02 and abs(at[1] / peak - 1) < 0.02, (path, at, total, peak)
        # A tenth of a voxel allows for the spline's asymmetry and the cut at a thousandth.
        assert np.linalg.norm(at[2] - t * to) < 0.025, (path, at[2], t * to)
    run("morph", a, b, "-o", d + "/x.vdb", "--at", 0.5, "--method", "dissolve", "--quiet")
    ghosts = vdb.read(d + "/x.vdb", "density")
    accessor = ghosts.getConstAccessor()
    value = lambda p: accessor.getValue(tuple(int(round(c)) for c in ghosts.transform.worldToIndex(tuple(p))))
    assert abs(value((0, 0, 0)) - 0.5) < 0.02 and abs(value(to) - 0.5) < 0.02 and value(to / 2) < 0.01
    assert "vel" not in names(d + "/x.vdb")


def puff_turns(d):
    """A turn by 90 degrees, whose direction a second puff beside it determines."""
    turn = lambda a: np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])

    def pair(angle):
        q = turn(angle)
        grid = puff((0, 0, 0), (2, 0.7, 0.7), 0.25, q)
        side = puff(q @ np.array([1.5, 1.2, 0]), (0.5, 0.5, 0.5), 0.25)
        grid.combine(side, lambda x, y: x + y)
        return grid
    a, b = write(d + "/a.vdb", pair(0)), write(d + "/b.vdb", pair(math.pi / 2))
    run("morph", a, b, "-o", d + "/m.vdb", "--at", 0.5, "--align", "auto", "--quiet")
    got, wanted = vdb.read(d + "/m.vdb", "density"), pair(math.pi / 4)
    accessor = got.getConstAccessor()
    array, low = dense(wanted)
    off = max(abs(float(array[i]) - accessor.getValue(tuple(int(c) for c in low + i)))
              for i in map(np.array, np.argwhere(array > 0.05)[::7]) for i in [tuple(i)])
    # A tenth of a voxel where the puff is steepest: 0.1 * 0.25 / 0.5 * 0.61 = 0.03; the spline adds as much
    # at the small puff.
    assert off < 0.08, off


def puff_doubles(d):
    """Twice the size: the total follows the volume or, with --conserve, changes linearly."""
    a = write(d + "/a.vdb", puff((0, 0, 0), (1, 1, 1), 0.25))
    b = write(d + "/b.vdb", puff((0, 0, 0), (2, 2, 2), 0.25))
    start, end = figures(vdb.read(a, "density"))[0], figures(vdb.read(b, "density"))[0]
    for flags in ([], ["--conserve"]):
        run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 3, "--velocity", "none", "--quiet", *flags)
        for i, path in enumerate(frames(d)):
            t = i / 2
            wanted = (1 - t) * start + t * end if flags else start * (1 + t) ** 3
            assert abs(figures(vdb.read(path, "density"))[0] / wanted - 1) < 0.02, (path, flags)


# ---------------------------------------------------------------- velocities

def velocity_of_a_moving_sphere(d):
    ball = lambda middle: solid(lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 1, middle, 1.4, 0.1)
    to = np.array([3.0, 1.0, -2.0])
    a, b = write(d + "/a.vdb", ball((0, 0, 0))), write(d + "/b.vdb", ball(to))
    run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 3, "--fps", FPS, "--quiet")
    speed = to * FPS / 2  # the whole distance in the two steps between three frames
    for path in frames(d):
        array, _ = dense(vdb.read(path, "vel"))
        moving = array[np.abs(array).sum(-1) > 0]
        assert len(moving) and np.abs(moving - speed).max() < 0.01 * np.linalg.norm(speed), (path, np.abs(moving - speed).max())
    run("morph", a, b, "-o", d + "/f.####.vdb", "--frames", 2, "--velocity", "v", "--velocity-unit", "frame",
        "--spine", "straight", "--quiet")
    array, _ = dense(vdb.read(d + "/f.0002.vdb", "v"))
    moving = array[np.abs(array).sum(-1) > 0]
    assert len(moving) and np.abs(moving - to).max() < 0.01 * np.linalg.norm(to)
    run("morph", a, b, "-o", d + "/n.vdb", "--at", 0.5, "--velocity", "none", "--slices", 16, "--quiet")
    assert list(names(d + "/n.vdb")) == ["surface"]


def interpolated(values, at):
    """Trilinear, at a position of index space."""
    low = np.floor(at).astype(int)
    share = np.asarray(at) - low
    total = np.zeros(3)
    for c in range(8):
        corner = np.array([c & 1, c >> 1 & 1, c >> 2])
        total += np.prod(np.where(corner, share, 1 - share)) * np.array(values.getValue(tuple(int(i) for i in low + corner)))
    return total


def velocity_of_a_turning_bar(d):
    """A turning body has the velocity omega x r at every voxel of its band."""
    def bar(angle):
        c, s = math.cos(angle), math.sin(angle)

        def distance(x, y, z):
            u, v = c * x + s * y, c * y - s * x
            q = [np.abs(u) - 1.5, np.abs(v) - 0.35, np.abs(z) - 0.2]
            return np.sqrt(sum(np.maximum(p, 0) ** 2 for p in q)) + np.minimum(np.maximum.reduce(q), 0)
        return solid(distance, (0, 0, 0), 1.8, 0.04)
    a, b = write(d + "/a.vdb", bar(0)), write(d + "/b.vdb", bar(math.pi / 3))
    run("plan", a, b, "-o", d + "/x.plan", "--quiet")
    planned = ["morph", "--plan", d + "/x.plan", "--frames", 5, "--quiet"]
    run(*planned, "-o", d + "/m.####.vdb", "--fps", FPS)
    omega = math.pi / 3 * FPS / 4
    for path in frames(d):
        band, vel = vdb.read(path, "surface"), vdb.read(path, "vel")
        values = vel.getConstAccessor()
        assert vel.transform.voxelSize()[0] >= 2 * band.transform.voxelSize()[0], "velocities are as fine as distances"
        worst = 0
        for item in band.citerOnValues():
            p = band.transform.indexToWorld(item.min)
            wanted = omega * np.array([-p[1], p[0], 0])
            worst = max(worst, np.linalg.norm(interpolated(values, vel.transform.worldToIndex(p)) - wanted))
        assert worst < 0.02 * omega * 1.55, (path, worst / (omega * 1.55))
        assert all(np.any(item.value) for item in vel.citerOnValues()), "zeros are stored"
        # The band is six voxels thick, and half a frame's way to both sides is twelve at most: eighteen, of which a voxel of four
        # times the size takes 64, and once more as many as there are, for the corners of what is cut: 18 / 6 / 64 * 2 < 1 / 8.
        assert 8 * vel.activeVoxelCount() <= band.activeVoxelCount(), (path, vel.activeVoxelCount(), band.activeVoxelCount())
    run(*planned, "-o", d + "/h.####.vdb", "--velocity-half")
    for path, half in zip(frames(d), frames(d, "h")):
        assert metadata(half, "vel")["is_saved_as_half_float"] and not metadata(path, "vel")["is_saved_as_half_float"]
        assert not metadata(half, "surface")["is_saved_as_half_float"]
        assert os.path.getsize(half) < os.path.getsize(path), (half, os.path.getsize(half), os.path.getsize(path))


def own_velocities_are_added(d):
    """The inputs' velocities turn and are added on request; staggered ones, too."""
    shape = puff((0, 0, 0), (1, 0.6, 0.6), 0.2)
    moved = puff((4, 0, 0), (1, 0.6, 0.6), 0.2)

    def flow(prototype, name):
        array, low = dense(prototype)
        values = np.zeros(array.shape + (3,), np.float32)
        values[array > 0] = (0, 2, 0)
        grid = vdb.Vec3SGrid()
        grid.copyFromArray(values, ijk=tuple(int(c) for c in low))
        grid.transform, grid.name = prototype.transform, name
        grid.gridClass = vdb.GridClass.STAGGERED
        return grid
    for name in ("vel", "velocity"):
        a = write(d + "/a.vdb", shape, flow(shape, name))
        b = write(d + "/b.vdb", moved, flow(moved, name))
        run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 3, "--fps", FPS, "--add-velocity", "--quiet")
        vel = vdb.read(d + "/m.0002.vdb", "vel")
        got = np.array(vel.getConstAccessor().getValue((10, 0, 0)))
        assert np.abs(got - [4 * FPS / 2, 2, 0]).max() < 0.02 * 4 * FPS / 2, got
        run("morph", a, b, "-o", d + "/n.####.vdb", "--frames", 2, "--quiet")
        assert set(names(d + "/n.0002.vdb")) == {"density", name, "vel_morph" if name == "vel" else "vel"}


# ---------------------------------------------------------------- files

def gas(d):
    """Every grid of the cache at every frame; ends equal the inputs, and the total changes monotonically."""
    a, b = real(DATA, "c42_gas_0006.vdb"), real(DATA, "c42_gas_0010.vdb")
    run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 3, "--quiet")
    wanted = names(a)
    totals = []
    for path in frames(d):
        got = names(path)
        assert {k: v for k, v in got.items() if k != "vel"} == wanted and got["vel"] == "Tree_vec3s_5_4_3", got
        meta = metadata(path, "density")
        assert meta["is_saved_as_half_float"] and meta["class"] == "fog volume" and meta["file_voxel_count"] > 0
        assert metadata(path, "velocity")["class"] == "staggered"
        totals.append(figures(vdb.read(path, "density"))[0])
    assert all(x < y for x, y in zip(totals, totals[1:])), totals
    ends = [(frames(d)[0], a), (frames(d)[-1], b)]
    for got, source in ends:
        for name in ("density", "temperature", "velocity", "phi_obstacle", "shadow"):
            x, y = vdb.read(got, name), vdb.read(source, name)
            assert x.evalActiveVoxelBoundingBox() == y.evalActiveVoxelBoundingBox() and x.transform == y.transform, name
            assert np.array_equal(dense(x)[0], dense(y)[0]), name
    assert metadata(frames(d)[1], "density")["file_compression"].startswith("blosc")


def odd_files(d):
    """Rotated transforms, three grids of one name, grids missing in one
    input: all end in the right position."""
    dragon, triple, sphere = real(DATA, "dragon_with_xform.vdb"), real(DATA, "three_grids_same_name.vdb"), real(DATA, "ls_sphere.vdb")
    heat = puff((2, 0, 0), (2, 1, 1), 0.3, name="heat")
    other = write(d + "/other.vdb", puff((2, 0, 0), (2, 1, 1), 0.3), heat)
    source = vdb.read(dragon, "density")
    for to, words in ((sphere, ["--at", "0,0.5", "--align", "none"]), (other, ["--at", "0,0.5,1"])):
        run("morph", dragon, to, "-o", d + "/m.####.vdb", *words, "--velocity", "none", "--quiet")
        first, middle = vdb.read(d + "/m.0001.vdb", "density"), vdb.read(d + "/m.0002.vdb", "density")
        assert first.transform == source.transform and first.activeVoxelCount() == source.activeVoxelCount()
        assert middle.gridClass == vdb.GridClass.FOG_VOLUME
        ends = [figures(source)[2], (2, 0, 0) if to == other else (0, 0, 0)]
        # The centroid of density need not be that of the shape: a tenth of the dragon's 20 units.
        assert np.linalg.norm(figures(middle)[2] - np.mean(ends, 0)) < 2, (figures(middle)[2], ends)
    whole = figures(heat)[1]
    peaks = [figures(vdb.read(path, "heat"))[1] if vdb.readGridMetadata(path, "heat") and
             vdb.read(path, "heat").activeVoxelCount() else 0 for path in frames(d)]
    assert peaks[0] == 0 and abs(peaks[1] - 0.5 * whole) < 0.05 and peaks[2] == whole, peaks
    run("morph", triple, triple, "-o", d + "/t.####.vdb", "--frames", 2, "--quiet")
    run("morph", triple, other, "-o", d + "/t.####.vdb", "--frames", 3, "--velocity", "none", "--quiet")
    for path in frames(d, "t"):
        assert [g.name for g in vdb.readAll(path)[0]].count("density") == 3, path
    counts = lambda path: sorted(g.activeVoxelCount() for g in vdb.readAll(path)[0] if g.name == "density")
    assert counts(d + "/t.0001.vdb") == counts(triple)


def unknown_types(d):
    """A grid of an unknown type is left out with a note; the others are morphed."""
    good = puff((0, 0, 0), (1, 1, 1), 0.3)
    path = write(d + "/a.vdb", good, puff((0, 0, 0), (1, 1, 1), 0.3, name="mystery"))
    whole = open(path, "rb").read()
    at = whole.index(b"Tree_float_5_4_3", whole.index(b"mystery"))
    with open(path, "wb") as f:
        f.write(whole[:at] + b"Tree_riddle_5_4_" + whole[at + 16:])
    b = write(d + "/b.vdb", puff((2, 0, 0), (1, 1, 1), 0.3))
    notes = run("morph", path, b, "-o", d + "/m.vdb", "--at", 0.5).stderr
    assert "'mystery'" in notes and "left out" in notes and "Tree_riddle_5_4_" in notes, notes
    assert set(names(d + "/m.vdb")) == {"density"}


def order_is_kept(d):
    """Output grids are in the order of the first input's file, then of the other's, then ours."""
    a = write(d + "/a.vdb", puff((0, 0, 0), (1, 1, 1), 0.3, name="zeta"), puff((0, 0, 0), (1, 1, 1), 0.3),
              puff((0, 0, 0), (1, 1, 1), 0.3, name="alpha"))
    b = write(d + "/b.vdb", puff((2, 0, 0), (1, 1, 1), 0.3, name="middle"), puff((2, 0, 0), (1, 1, 1), 0.3))
    run("morph", a, b, "-o", d + "/m.####.vdb", "--frames", 2, "--quiet")
    whole = open(d + "/m.0002.vdb", "rb").read()
    # The table of contents names each grid before its data, which ends with the next one's name.
    offsets = [whole.index(b"\x10\x00\x00\x00Tree_", whole.index(struct.pack("<I", len(n)) + n)) for n in
              (b"zeta", b"density", b"alpha", b"middle", b"vel")]
    assert offsets == sorted(offsets), offsets


def mixed_pairs(d):
    """A solid becomes smoke and the other way round; --grids chooses; fog gives meshes."""
    ball = write(d + "/ball.vdb", solid(lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 1, (0, 0, 0), 1.4, 0.15))
    smoke = write(d + "/smoke.vdb", puff((3, 0, 0), (1, 0.8, 0.8), 0.15), puff((3, 0, 0), (0.7, 0.7, 0.7), 0.15, name="heat"))
    with open(d + "/cube.obj", "w") as f:
        for x, y, z in [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]:
            f.write("v %g %g %g\n" % (x, y, z))
        for q in ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"):
            f.write("f %s\n" % q)
    # The cube's voxels are about those of the smoke.
    for a, b, times in ((ball, smoke, ["--frames", 3]), (smoke, d + "/cube.obj", ["--at", 0.5]), (d + "/cube.obj", smoke, ["--at", 0.5])):
        for old in frames(d):
            os.remove(old)
        run("morph", a, b, "-o", d + "/m.####.vdb", *times, "--resolution", 8, "--quiet")
        assert len(frames(d)) == (3 if a == ball else 1), frames(d)
        for path in frames(d):
            assert set(names(path)) == {"density", "heat"} | ({"vel"} if a == ball else set()), names(path)
            assert metadata(path, "density")["class"] == "fog volume"
        middle = figures(vdb.read(frames(d)[len(frames(d)) // 2], "density"))
        assert 0.5 < middle[1] < 1.1, middle
    run("morph", ball, smoke + ":heat", "-o", d + "/h.####.vdb", "--frames", 2, "--quiet")
    assert set(names(d + "/h.0002.vdb")) == {"heat", "vel"}
    run("morph", ball, smoke, "-o", d + "/g.vdb", "--at", 0.5, "--grids", "heat,surface", "--quiet")
    assert set(names(d + "/g.vdb")) == {"surface", "heat"}
    run("morph", ball, smoke, "-o", d + "/g.ply", "--at", 0.5, "--quiet")
    assert os.path.getsize(d + "/g.ply") > 1000
    error = run("morph", ball, smoke, "-o", d + "/x.####.vdb", "--grids", "flame", code=2).stderr
    assert "no input has a grid 'flame'" in error and "heat" in error
    error = run("morph", ball, smoke, "-o", d + "/x.####.obj", "--method", "dissolve", code=2).stderr
    assert "makes no surface" in error and not frames(d, "x")


def sequences(d):
    """Two billowing clouds morph without jumps; a sequence that ends early keeps its last file."""
    def cloud(i, seed):
        grid = None
        for n in range(5):
            phase = 2 * math.pi * (n / 5 + 0.02 * i * (1 + 0.3 * seed))
            middle = (1.4 * math.cos(phase), 0.5 * n - 1 + 0.03 * i, (0.8 + 0.4 * seed) * math.sin(phase) + 4 * seed)
            one = puff(middle, [0.55 + 0.02 * i * (n % 2)] * 3, 0.2)
            if grid is None:
                grid = one
            else:
                grid.combine(one, lambda x, y: x + y)
        return grid
    for i in range(5):
        write(d + "/a.%04d.vdb" % (i + 1), cloud(i, 0))
        write(d + "/b.%04d.vdb" % (i + 1), cloud(i, 1))
    run("morph", d + "/a.####.vdb", d + "/b.####.vdb", "-o", d + "/m.####.vdb", "--velocity", "none")
    grids = [vdb.read(path, "density") for path in frames(d)]
    assert len(grids) == 5
    jumps = []
    for x, y in zip(grids, grids[1:]):
        difference = x.deepCopy()
        difference.combine(y, lambda p, q: abs(p - q))
        jumps.append(figures(difference)[0])
    print("        largest jump over the mean: %.2f" % (max(jumps) / np.mean(jumps)))
    assert max(jumps) < 1.5 * np.mean(jumps), jumps
    for i in range(1, 4):
        shutil.copy(d + "/b.%04d.vdb" % i, d + "/e.%04d.vdb" % i)
    note = run("morph", d + "/a.####.vdb", d + "/e.####.vdb", "-o", d + "/f.####.vdb", "--frames", 5, "--method", "dissolve").stderr
    assert "e.####.vdb has 3 files for 5 frames" in note and len(frames(d, "f")) == 5
    # Grids may be missing in some frames, and change their order.
    extra = cloud(4, 0)
    extra.name = "flame"
    write(d + "/a.0005.vdb", extra, cloud(4, 0))
    run("morph", d + "/a.####.vdb@4-5", d + "/b.####.vdb@4-5", "-o", d + "/c.####.vdb", "--quiet")
    assert set(names(d + "/c.0002.vdb")) == {"density", "flame", "vel"} and set(names(d + "/c.0001.vdb")) == {"density", "vel"}
    assert abs(figures(vdb.read(d + "/c.0001.vdb", "density"))[0] / figures(vdb.read(d + "/c.0002.vdb", "density"))[0] - 1) < 0.2
    error = run("morph", d + "/none.####.vdb", d + "/b.####.vdb", "-o", d + "/x.####.vdb", code=1).stderr
    assert "none.####.vdb" in error and "no such files" in error


def truncated(d):
    """Every real file, cut at ten positions: a message, no output, no crash."""
    good = write(d + "/good.vdb", puff((0, 0, 0), (1, 1, 1), 0.4))
    real(DATA, "ls_sphere.vdb")
    for name in sorted(os.listdir(DATA)):
        if not name.endswith(".vdb"):
            continue
        whole = open(os.path.join(DATA, name), "rb").read()
        for i in range(1, 11):
            path = d + "/cut.vdb"
            with open(path, "wb") as f:
                f.write(whole[:len(whole) * i // 11])
            error = run("morph", path, good, "-o", d + "/x.####.vdb", "--frames", 2, code=1).stderr
            assert "cut.vdb" in error and not frames(d, "x"), (name, i, error)


CASES = [puff_travels, puff_turns, puff_doubles, velocity_of_a_moving_sphere, velocity_of_a_turning_bar,
         own_velocities_are_added, gas, odd_files, unknown_types, order_is_kept,
         mixed_pairs, sequences, truncated]
sys.exit(run_cases([(case.__name__, case) for case in CASES], ONLY))
