#!/usr/bin/env python3
"""`slicemorph retime`: sequences of smoke and level sets at another speed.

usage: retime_test.py PATH/TO/slicemorph REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb. Real smoke is read where ../shared/data is beside the repository.
"""
import os
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import named_cases, run_cases
import frames
from frames import folder
from grids import level_set, puff, real, write

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, REPOSITORY, ONLY = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3:]
ORIGIN = 1.2  # of the coordinates that puff() takes, in the world
DATA = os.path.join(REPOSITORY, "..", "shared", "data", "vdb")


def run(o, *words, code=0):
    done = subprocess.run([PROGRAM, "retime", *map(str, words)], cwd=o, capture_output=True, text=True, timeout=600)
    assert done.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, words)), done.returncode, done.stderr)
    return done


def made(o, name):
    return os.path.join(o, name)


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def dense(path, name="density"):
    """Values of a grid and the index of the first one."""
    grid = vdb.read(path, name)
    low, high = (np.array(corner) for corner in grid.evalActiveVoxelBoundingBox())
    array = np.zeros(high - low + 1, np.float32)
    grid.copyToArray(array, ijk=tuple(map(int, low)))
    return array, low, grid.transform.voxelSize()[0]


def total_and_centre(path):
    """Sum of the densities, and their centre in the coordinates of puff()."""
    array, low, h = dense(path)
    total = float(array.sum())
    index = np.stack(np.meshgrid(*map(np.arange, array.shape), indexing="ij"), -1)
    return total, h * (low + (index * array[..., None]).reshape(-1, 3).sum(0) / total) - ORIGIN


def puffs(o, numbers, middle, radius=0.45):
    """Puffs s.NUMBER.vdb, one a number, whose middles are middle(number)."""
    for number in numbers:
        puff(made(o, "s.%04d.vdb" % number), middle(number), radius)
    return "s.####.vdb"


def along_x(number):
    return (0.2 * number - 0.4, 0, 0)


def with_velocity(path, velocity, staggered=False):
    """Adds velocities that are the same wherever there is density: one grid of vectors, or three of numbers."""
    density = vdb.read(path, "density")
    where = np.zeros((24, 24, 24), np.float32)
    density.copyToArray(where)
    grids = [density]
    if staggered:
        for axis, value in zip("xyz", velocity):
            part = vdb.FloatGrid()
            part.copyFromArray((where > 0) * np.float32(value))
            part.name, part.transform = "vel." + axis, density.transform
            grids.append(part)
    else:
        vectors = vdb.Vec3SGrid()
        vectors.copyFromArray((where > 0)[..., None] * np.array(velocity, np.float32))
        vectors.name, vectors.transform = "vel", density.transform
        grids.append(vectors)
    write(path, *grids)


def case_slower(o):
    """Files are passed through byte for byte, and what lies between two is where it belongs, with its total."""
    pattern = puffs(o, (1, 2, 3), along_x)
    run(o, pattern, "-o", "slow.####.vdb", "--factor", 4)
    names = ["slow.%04d.vdb" % n for n in range(1, 10)]
    assert [n for n in sorted(os.listdir(o)) if n.startswith("slow")] == names, os.listdir(o)
    assert not [n for n in os.listdir(o) if n.startswith(".")]
    for number, name in ((1, names[0]), (2, names[4]), (3, names[8])):
        assert bytes_of(made(o, "s.%04d.vdb" % number)) == bytes_of(made(o, name)), name
    whole, _ = total_and_centre(made(o, "s.0001.vdb"))
    for i in (1, 2, 3, 5, 6, 7):
        total, centre = total_and_centre(made(o, names[i]))
        # A hundredth of the total; a fifth of a voxel.
        assert abs(total / whole - 1) < 0.01, (names[i], total / whole)
        assert np.abs(centre - along_x(1 + i / 4)).max() < 0.02, (names[i], centre)
    assert "vel" in [grid.name for grid in vdb.readAllGridMetadata(made(o, names[1]))]


def case_missing_numbers(o):
    """Files need not be evenly spaced; --start, --frames and ranges count the frames of the output."""
    def slowly(number):
        return (0.15 * number - 1.3, 0, 0)

    pattern = puffs(o, (6, 8, 11), slowly)
    run(o, pattern, "-o", "f.####.vdb")
    assert [n for n in sorted(os.listdir(o)) if n.startswith("f.")] == ["f.%04d.vdb" % n for n in range(6, 12)]
    for number in (7, 9, 10):
        _, centre = total_and_centre(made(o, "f.%04d.vdb" % number))
        assert np.abs(centre - slowly(number)).max() < 0.03, (number, centre)
    run(o, pattern + "@6,11", "-o", "g.####.vdb", "--frames", 3, "--start", 101, "--range", "102-103")
    assert [n for n in sorted(os.listdir(o)) if n.startswith("g.")] == ["g.0102.vdb", "g.0103.vdb"]
    assert bytes_of(made(o, "g.0103.vdb")) == bytes_of(made(o, "s.0011.vdb"))
    _, centre = total_and_centre(made(o, "g.0102.vdb"))
    assert np.abs(centre - slowly(8.5)).max() < 0.05, centre


def case_what_stands_still(o):
    """Grids that are the same in both files are not carried by the smoke's map: obstacles, flags, sources."""
    x, y, z = np.meshgrid(*[np.arange(24) * 0.1 - ORIGIN] * 3, indexing="ij")
    obstacle = level_set(np.maximum(np.abs(x), np.abs(y)) - 0.7, (0, 0, 0), 0.1, "phi_obstacle")
    pattern = puffs(o, (1, 2), along_x)
    for number in (1, 2):
        path = made(o, "s.%04d.vdb" % number)
        write(path, vdb.read(path, "density"), obstacle)
    run(o, pattern, "-o", "m.####.vdb", "--factor", 2)
    new, low, _ = dense(made(o, "m.0002.vdb"), "phi_obstacle")
    old, at, _ = dense(made(o, "s.0001.vdb"), "phi_obstacle")
    assert (low == at).all() and (new == old).all()


def case_curve(o):
    """Forwards, standing still, and backwards."""
    pattern = puffs(o, (1, 2, 3), along_x)
    run(o, pattern, "-o", "c.####.vdb", "--curve", "11@1 13@3, 14@3 16@2")
    for number, shown in ((11, 1), (12, 2), (13, 3), (14, 3), (16, 2)):
        assert bytes_of(made(o, "c.%04d.vdb" % number)) == bytes_of(made(o, "s.%04d.vdb" % shown)), number
    _, centre = total_and_centre(made(o, "c.0015.vdb"))
    assert np.abs(centre - along_x(2.5)).max() < 0.02, centre


def case_velocities(o):
    """The simulation's own velocities are as much smaller as the sequence is slower, whichever way they are stored."""
    for kind, staggered in (("whole", False), ("parts", True)):
        f = folder(o, kind)
        pattern = puffs(f, (1, 2), along_x)
        for number in (1, 2):
            with_velocity(made(f, "s.%04d.vdb" % number), (4.8, 0, -1.2), staggered)
        run(f, pattern, "-o", "slow.####.vdb", "--factor", 4)
        for number in range(1, 6):
            path = made(f, "slow.%04d.vdb" % number)
            assert vdb.readMetadata(path)["frame"] == number, (number, vdb.readMetadata(path))
            names = [grid.name for grid in vdb.readAllGridMetadata(path)]
            wanted = ["density"] + (["vel.x", "vel.y", "vel.z"] if staggered else ["vel"])
            assert sorted(names) == wanted, names
            values = [vdb.read(path, "vel." + a) for a in "xyz"] if staggered else [vdb.read(path, "vel")]
            at = vdb.read(path, "density").transform.worldToIndexCellCentered(
                tuple(ORIGIN + np.array(along_x(1 + (number - 1) / 4))))
            found = [grid.getConstAccessor().getValue(at) for grid in values]
            found = np.array(found if staggered else found[0])
            # Half floats have 11 bits.
            assert np.abs(found - (1.2, 0, -0.3)).max() < 1e-3, (number, found)
        old, low, _ = dense(made(f, "s.0001.vdb"))
        new, _, _ = dense(made(f, "slow.0001.vdb"))
        assert (old == new).all()


def vortex(path, angle, velocity):
    """Balls of smoke in a vortex about z after its middle has turned by `angle` (radians); it slows down outwards. `velocity`: per second; how
    it is stored: None, "staggered" or "parts"."""
    n, h = 40, 0.1
    at = np.stack(np.meshgrid(*[np.arange(n) - n / 2 + 0.5] * 3, indexing="ij"), -1)
    slower = np.exp(-(at[..., 0] ** 2 + at[..., 1] ** 2) / (2 * 10.0**2))
    c, s = np.cos(-angle * slower), np.sin(-angle * slower)
    was = np.stack([c * at[..., 0] - s * at[..., 1], s * at[..., 0] + c * at[..., 1], at[..., 2]], -1)
    density = np.zeros((n, n, n))
    random = np.random.default_rng(3)
    for _ in range(12):
        middle, radius, strength = random.uniform(-10, 10, 3) * [1, 1, 0.8], random.uniform(1.7, 3), random.uniform(0.4, 1)
        density += strength * np.exp(-((was - middle) ** 2).sum(-1) / (2 * radius**2))
    grids = []

    def add(name, values, kind=vdb.FloatGrid):
        grid = kind()
        grid.copyFromArray(values.astype(np.float32))
        grid.name, grid.transform = name, vdb.createLinearTransform(h)
        grids.append(grid)
        return grid

    add("density", np.where(density < 0.02, 0, density)).gridClass = vdb.GridClass.FOG_VOLUME
    turn = 24 * h * np.radians(110) * slower / 4  # four frames for 110 degrees
    vectors = np.stack([-turn * at[..., 1], turn * at[..., 0], 0 * turn], -1)
    if velocity == "staggered":
        # Components on the faces before the voxels' middles; half a voxel along its own axis hardly changes one here.
        add("velocity", vectors, vdb.Vec3SGrid).gridClass = vdb.GridClass.STAGGERED
    elif velocity == "parts":
        for axis in range(3):
            add("v_" + "xyz"[axis], vectors[..., axis])
    write(path, *grids)


def case_velocities_lead(o):
    """Ways too far for a search: a vortex whose middle turns by 110 degrees from file to file. With the smoke's own velocities the frame half
    way is off by less than half as much as without, and by less than a tenth of its total, however they are stored."""
    vortex(made(o, "true.vdb"), np.radians(55), None)
    true, low, _ = dense(made(o, "true.vdb"))

    def error(stored):
        for number in (0, 4):
            vortex(made(o, "%s.%d.vdb" % (stored, number)), np.radians(110) * number / 4, stored)
        run(o, "%s.#.vdb" % stored, "-o", "out_%s.#.vdb" % stored, "--factor", 1, "--range", 2, "--quiet")
        got = np.zeros(true.shape, np.float32)
        grid = vdb.read(made(o, "out_%s.2.vdb" % stored), "density")
        grid.copyToArray(got, ijk=tuple(map(int, low)))
        return np.abs(got - true).sum() / true.sum()

    blind = error(None)
    for stored in ("staggered", "parts"):
        led = error(stored)
        assert led < 0.5 * blind and led < 0.1, (stored, led, blind)


def case_smooth_paths(o):
    """What moves on a circle stays on it: a chord of a turn of 40 degrees is 6 % of the radius inside, and a cubic with the
    chords' mean velocities at its ends a tenth of that."""
    def on_circle(number):
        angle = np.radians(40 * (number - 2.5))
        return (0.8 * np.cos(angle) - 0.4, 0.8 * np.sin(angle), 0)

    pattern = puffs(o, (1, 2, 3, 4), on_circle, 0.3)
    run(o, pattern, "-o", "slow.####.vdb", "--factor", 2)
    _, centre = total_and_centre(made(o, "slow.0004.vdb"))
    inside = 0.4 - centre[0]  # from where it should be, at (0.4, 0, 0)
    assert abs(inside) < 0.3 * 0.8 * (1 - np.cos(np.radians(20))), inside
    # Of the first pair only one neighbour is known: it is at least no worse than the chord.
    _, centre = total_and_centre(made(o, "slow.0002.vdb"))
    assert np.linalg.norm(centre - on_circle(1.5)) < 0.8 * (1 - np.cos(np.radians(20))), centre


def case_level_sets(o):
    """A ball that moves and grows; in-betweens are level sets of its name with velocities."""
    x, y, z = np.meshgrid(*[(np.arange(32) - 16) * 0.1] * 3, indexing="ij")
    for number, (at, radius) in ((1, (-0.3, 0.6)), (3, (0.3, 0.8))):
        ball = level_set(np.sqrt((x - at) ** 2 + y ** 2 + z ** 2) - radius, (-16, -16, -16), 0.1, "liquid")
        write(made(o, "l.%d.vdb" % number), ball)
    run(o, "l.#.vdb", "-o", "m.####.vdb")
    grid = vdb.read(made(o, "m.0002.vdb"), "liquid")
    assert grid.gridClass == vdb.GridClass.LEVEL_SET
    for point in ((0.7, 0, 0), (-0.7, 0, 0), (0, 0.7, 0), (0, 0, -0.7)):
        value = grid.getConstAccessor().getValue(grid.transform.worldToIndexCellCentered(point))
        assert abs(value) < 0.02, (point, value)


def case_parts_are_the_whole(o):
    """Ranges, interrupted runs and any number of threads give the same bytes."""
    pattern = puffs(o, (1, 2, 3, 4), along_x)
    whole, parts = folder(o, "whole"), folder(o, "parts")
    words = [os.path.join(o, pattern), "--factor", 3]
    run(whole, *words, "-o", "r.####.vdb", "--threads", 1)
    run(parts, *words, "-o", "r.####.vdb", "--range", "8-10", "--threads", 2)
    run(parts, *words, "-o", "r.####.vdb", "--range", "1-8", "--resume")
    assert frames.sums(whole, ".vdb") == frames.sums(parts, ".vdb")
    assert len(frames.sums(whole, ".vdb")) == 10
    assert not [n for n in os.listdir(parts) if n.startswith(".")]


def case_one_grid_for_all_files(o):
    """The grid of the first file is that of all, though others have one that would come before it: ranges give the bytes of the whole, and
    the smoke is where it belongs. All grids of the files are carried."""
    pattern = puffs(o, (1, 2, 3, 4), along_x)
    x, y, z = np.meshgrid(*[np.arange(24) * 0.1 - ORIGIN] * 3, indexing="ij")
    for number in (2, 3, 4):
        path = made(o, "s.%04d.vdb" % number)
        ball = level_set(np.sqrt(x ** 2 + (y - 0.3 * number + 0.9) ** 2 + z ** 2) - 0.3, (0, 0, 0), 0.1, "aaa")
        write(path, vdb.read(path, "density"), ball)
    run(o, pattern, "-o", "w.####.vdb", "--factor", 2)
    for number in (2, 4, 6):
        run(o, pattern, "-o", "r.####.vdb", "--factor", 2, "--range", number)
        assert bytes_of(made(o, "r.%04d.vdb" % number)) == bytes_of(made(o, "w.%04d.vdb" % number)), number
        _, centre = total_and_centre(made(o, "w.%04d.vdb" % number))
        assert np.abs(centre - along_x(1 + (number - 1) / 2)).max() < 0.02, (number, centre)
        assert "aaa" in [grid.name for grid in vdb.readAllGridMetadata(made(o, "w.%04d.vdb" % number))], number


def memory_of(o, *words):
    process = subprocess.Popen([PROGRAM, "retime", *words], cwd=o, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    assert status == 0, status
    return usage.ru_maxrss


def case_memory_does_not_grow(o):
    """Three plans are held at most: thirteen files take no more than a fifth more than four."""
    pattern = puffs(o, range(1, 14), lambda number: (0.03 * number, 0, 0))
    few = memory_of(o, pattern + "@1-4", "-o", "a.####.vdb", "--factor", "2")
    many = memory_of(o, pattern, "-o", "b.####.vdb", "--factor", "2")
    assert many < 1.2 * few, (few, many)


def case_refusals(o):
    pattern = puffs(o, (1, 2), along_x)
    for words, said in (
        (["s.0001.vdb", "-o", "x.####.vdb"], "s.0001.vdb is no sequence"),
        ([pattern + "@1", "-o", "x.####.vdb"], "is one file"),
        ([pattern, "-o", "x.vdb"], "name.####.vdb"),
        ([pattern, "-o", "x.####.obj"], "name.####.vdb"),
        ([pattern, "-o", "x.####.vdb", "--factor", "0"], "--factor"),
        ([pattern, "-o", "x.####.vdb", "--iso", "0.3/0.4"], "--iso names values for 2 inputs of 1"),
        ([pattern, "-o", "x.####.vdb", "--factor", "2", "--frames", "9"], "exclude"),
        ([pattern, "-o", "x.####.vdb", "--curve", "1@1 5@3"], "there is no file 3"),
        ([pattern, "-o", "x.####.vdb", "--curve", "5@1 1@2"], "frames must rise"),
        ([pattern, "-o", "x.####.vdb", "--curve", "1-1 5-2"], "not understood"),
        ([pattern, "-o", "x.####.vdb", "--range", "7"], "--range 7"),
    ):
        err = run(o, *words, code=2).stderr
        assert said in err, (said, err)
        assert not [n for n in os.listdir(o) if n.startswith("x")], os.listdir(o)


if __name__ == "__main__":
    sys.exit(run_cases(named_cases(globals()), ONLY))
