#!/usr/bin/env python3
"""EXR slices through the program, read by OpenImageIO, oiiotool and pyopenvdb.

usage: slices_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openvdb; cases that need python3-openimageio or openimageio-tools are skipped, with a
message, where these are not installed.
"""
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_cases

try:
    import OpenImageIO as oiio
except ImportError:
    oiio = None

if len(sys.argv) < 2:
    sys.exit(__doc__)
PROGRAM = os.path.abspath(sys.argv[1])
ONLY = sys.argv[2:]


def run(*arguments, code=0):
    result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert result.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, arguments)), result.returncode, result.stderr)
    return result


# Rotated, with other voxels along each axis: rows are the steps along i, j, k, then the origin.
TURN = np.array([[0.8, 0.6, 0], [-0.48, 0.64, 0.6], [0.36, -0.48, 0.8]])
STEPS = np.array([0.5, 0.6, 0.7])[:, None] * TURN
ORIGIN = np.array([3.0, -2.0, 5.0])


def transform():
    matrix = np.zeros((4, 4))
    matrix[:3, :3], matrix[3, :3], matrix[3, 3] = STEPS, ORIGIN, 1
    return vdb.createLinearTransform(matrix.tolist())


def make_volume(path, n=24):
    """A cloud with temperature and velocity on a rotated grid with
    unequal voxels, and a level set of a ball."""
    i, j, k = np.meshgrid(*[np.arange(-n, n + 1)] * 3, indexing="ij")
    r2 = (i / n) ** 2 + (j / n) ** 2 + (k / n) ** 2
    values = np.where(r2 < 1, np.exp(-2 * r2) * (1 + 0.3 * np.sin(i / 3) * np.cos(j / 4)), 0)
    density = vdb.FloatGrid()
    density.copyFromArray(values, ijk=(-n, -n, -n))
    density.name, density.gridClass, density.transform = "density", vdb.GridClass.FOG_VOLUME, transform()
    heat = vdb.FloatGrid()
    heat.copyFromArray(np.where(r2 < 1, 300 + 50 * np.sin(k / 5), 0), ijk=(-n, -n, -n))
    heat.name, heat.transform = "temperature", transform()
    vel = vdb.Vec3SGrid()
    vel.copyFromArray(np.stack([np.where(r2 < 1, f, 0) for f in (j / n, -i / n, np.sin(k / 4))], axis=-1), ijk=(-n, -n, -n))
    vel.name, vel.transform = "vel", transform()
    ball = vdb.createLevelSetSphere(radius=8, center=tuple(ORIGIN), voxelSize=0.5, halfWidth=3)
    ball.name = "surface"
    vdb.write(path, grids=[density, heat, vel, ball])
    return {g.name: g for g in (density, heat, vel, ball)}


def trilinear(grid, world):
    """Values at world points (N x 3) from the voxels around them."""
    index = np.array([grid.transform.worldToIndex(tuple(p)) for p in world])
    base = np.floor(index).astype(int)
    w = index - base
    accessor = grid.getConstAccessor()
    total = 0
    for c in range(8):
        d = np.array([c >> 2 & 1, c >> 1 & 1, c & 1])
        weight = np.prod(np.where(d, w, 1 - w), axis=1)
        v = np.array([accessor.getValue(tuple(int(x) for x in b + d)) for b in base], dtype=float)
        total = total + (weight if v.ndim == 1 else weight[:, None]) * v
    return total


def read(path):
    """All parts: (spec, pixels)."""
    if oiio is None:
        raise Skip("python3-openimageio is not installed")
    source = oiio.ImageInput.open(path)
    assert source, "%s: %s" % (path, oiio.geterror())
    parts, n = [], 0
    while source.seek_subimage(n, 0):
        parts.append((source.spec(), source.read_image(n, 0, 0, source.spec().nchannels, oiio.FLOAT)))
        n += 1
    source.close()
    return parts


def attribute(spec, name):
    value = spec.getattribute(name)
    assert value is not None, "no attribute " + name
    return value


def check_values(parts, grids, tolerance, points=1000):
    rng = np.random.default_rng(1)
    names = {"density": ["density.Y"], "temperature": ["temperature.Y"], "vel": ["vel.X", "vel.Y", "vel.Z"],
             "surface": ["surface.sdf"]}
    checked = 0
    for spec, pixels in parts:
        channels = list(spec.channelnames)
        assert set(channels) == set(sum(names.values(), ["coverage"])), channels
        i = rng.integers(0, spec.width, points // len(parts) + 1)
        j = rng.integers(0, spec.height, points // len(parts) + 1)
        origin, x, y = (np.array(attribute(spec, a), float) for a in ("sliceOrigin", "sliceAxisX", "sliceAxisY"))
        world = origin + attribute(spec, "slicePixelSize") * (i[:, None] * x + j[:, None] * y)
        matrix = np.array(attribute(spec, "pixelToWorld"), float).reshape(4, 4)
        by_matrix = (np.stack([i, j, 0 * i, 0 * i + 1], axis=1) @ matrix)[:, :3]
        assert np.abs(by_matrix - world).max() < 1e-9
        for name, grid in grids.items():
            exact = trilinear(grid, world).reshape(len(i), -1)
            for c, channel in enumerate(names[name]):
                error = np.abs(pixels[j, i, channels.index(channel)] - exact[:, c])
                limit = tolerance * np.maximum(1, np.abs(exact[:, c]))
                assert (error <= limit).all(), "%s: error %g" % (channel, error.max())
        checked += len(i)
    assert checked >= points


def values_are_trilinear(d):
    """Along an oblique axis, one file per slice: 1,000 points within 1e-5 (relative to values above 1)."""
    grids = make_volume(d + "/v.vdb")
    run("slice", d + "/v.vdb", "-o", d + "/s.####.exr", "--slices", 12, "--axis", "1,2,-0.7")
    parts = sum((read("%s/s.%04d.exr" % (d, n)) for n in range(1, 13)), [])
    check_values(parts, grids, 1e-5)
    assert [attribute(s, "sliceIndex") for s, _ in parts] == list(range(12))
    spec = parts[3][0]
    assert attribute(spec, "sliceUnits") == "world units" and attribute(spec, "compression").startswith("zip")
    assert (spec.full_width, spec.full_height) == (spec.width, spec.height)
    assert attribute(spec, "density.class") == "fog volume" and attribute(spec, "surface.class") == "level set"


def parts_tiles_half_planes(d):
    """One file of parts on given planes of different sizes, tiled, half floats: 11 bits of every value."""
    grids = make_volume(d + "/v.vdb")
    with open(d + "/planes.csv", "w") as f:
        f.write("ox,oy,oz,nx,ny,nz\n3,-2,5,0,0,1\n3,-2,9,0.1,0,1 # leaning\n3;-2;12;0;0.3;1\n")
    for options in ([], ["--tiles", 32, "--compression", "piz"], ["--half", "--compression", "zips"]):
        run("slice", d + "/v.vdb", "-o", d + "/s.exr", "--planes", d + "/planes.csv", *options)
        parts = read(d + "/s.exr")
        assert len(parts) == 3
        check_values(parts, grids, 2.0 ** -11 if "--half" in options else 1e-5)
        assert (parts[0][0].tile_width == 32) == ("--tiles" in options)
        assert len({(s.full_width, s.full_height) for s, _ in parts}) == 1 and len({s.width for s, _ in parts}) > 1


def oiiotool_reads_all(d):
    if not shutil.which("oiiotool"):
        raise Skip("oiiotool is not installed")
    make_volume(d + "/v.vdb")
    for compression in "none rle zips zip piz pxr24 b44 b44a dwaa dwab".split():
        run("slice", d + "/v.vdb", "-o", d + "/s.exr", "--slices", 2, "--compression", compression, "--pixel-size", 1)
        out = subprocess.run(["oiiotool", "--info", "-v", "-a", d + "/s.exr"], capture_output=True, text=True)
        assert out.returncode == 0 and not out.stderr, out.stderr
        for word in ("density.Y", "vel.Z", "surface.sdf", "coverage", "sliceOrigin", "worldToCamera", compression):
            assert word in out.stdout, word + " is missing:\n" + out.stdout


def rebuilt_within_a_tenth_of_a_voxel(d):
    """Rotated, unequal voxels, an oblique axis: the fog's values and the ball's distances are recovered."""
    grids = make_volume(d + "/v.vdb")
    run("slice", d + "/v.vdb", "-o", d + "/s.####.exr", "--slices", 80, "--axis", "1,2,-0.7")
    run("reconstruct", d + "/s.####.exr", "-o", d + "/back.vdb")
    back = {g.name: g for g in vdb.readAll(d + "/back.vdb")[0]}
    assert set(back) == set(grids), set(back)
    for name in grids:
        assert back[name].gridClass == grids[name].gridClass, name
        assert np.allclose(back[name].transform.voxelSize(), 0.5), back[name].transform.voxelSize()
    rng = np.random.default_rng(2)
    h = 0.5
    directions = rng.normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    world = ORIGIN + directions * (8 + rng.uniform(-h, h, 2000))[:, None]
    error = np.abs(trilinear(back["surface"], world) - (np.linalg.norm(world - ORIGIN, axis=1) - 8)) / h
    print("    ball: mean %.4f, largest %.4f voxels" % (error.mean(), error.max()))
    assert error.mean() <= 0.1
    # Error in voxels: the difference divided by the change of the field over a voxel there.
    world = ORIGIN + rng.uniform(-7, 7, (4000, 3)) @ TURN
    inside = np.linalg.norm((world - ORIGIN) @ np.linalg.inv(STEPS) / 24, axis=1) < 0.9
    world = world[inside]
    for name in ("density", "temperature"):
        exact = trilinear(grids[name], world)
        change = sum(np.abs(trilinear(grids[name], world + h * e) - trilinear(grids[name], world - h * e)) / 2 for e in np.eye(3))
        error = np.abs(trilinear(back[name], world) - exact).mean() / change.mean()
        print("    %s: mean %.4f voxels" % (name, error))
        assert error <= 0.1, name


def same_bytes_for_any_threads(d):
    make_volume(d + "/v.vdb")
    for threads in (1, 2, 4):
        run("slice", d + "/v.vdb", "-o", "%s/p%d.exr" % (d, threads), "--slices", 9, "--threads", threads)
        run("reconstruct", "%s/p%d.exr" % (d, threads), "-o", "%s/b%d.vdb" % (d, threads), "--threads", threads)
    for name in ("p%d.exr", "b%d.vdb"):
        contents = {open(d + "/" + name % t, "rb").read() for t in (1, 2, 4)}
        assert len(contents) == 1, name


def constants_stay_themselves(d):
    """With a background that is no exact sum of floats, only voxels that were active are active again."""
    grid = vdb.FloatGrid(293.15)
    grid.copyFromArray(np.full((6, 6, 6), 300.1, np.float32), ijk=(10, 10, 10))
    grid.name, grid.transform = "temperature", transform()
    vdb.write(d + "/t.vdb", grids=[grid])
    run("slice", d + "/t.vdb", "-o", d + "/s.exr", "--slices", 9, "--axis", "1,2,-0.7")
    exact = {np.float32(293.15), np.float32(300.1)}
    values = np.concatenate([pixels.ravel() for _, pixels in read(d + "/s.exr")])
    assert values.min() == min(exact) and values.max() == max(exact), (values.min(), values.max())
    run("reconstruct", d + "/s.exr", "-o", d + "/b.vdb")
    assert vdb.read(d + "/b.vdb", "temperature").activeVoxelCount() < 4 * 8 ** 3


def frames_are_not_mixed(d):
    """Slices of two frames are no volume."""
    make_volume(d + "/v.vdb")
    for n in (1, 2):
        run("slice", d + "/v.vdb", "-o", "%s/s.%04d.exr" % (d, n), "--slices", 4)
    assert "there twice" in run("reconstruct", d + "/s.####.exr", "-o", d + "/b.vdb", code=1).stderr
    assert not os.path.exists(d + "/b.vdb")


def morph_slices_hold_all_of_the_fog(d):
    """Slices show fog beyond the surface that was found in it, at the fog's own voxel size."""
    grids = make_volume(d + "/v.vdb")
    run("morph", d + "/v.vdb:density", d + "/v.vdb:density", "-o", d + "/m.exr", "--at", 0.5, "--exr", "slices", "--exr-slices", 60,
        "--exr-axis", "z")
    parts = read(d + "/m.exr")
    pixel = attribute(parts[0][0], "slicePixelSize")
    assert abs(pixel - 0.5) < 1e-9, pixel
    gap = attribute(parts[1][0], "sliceOrigin")[2] - attribute(parts[0][0], "sliceOrigin")[2]
    total = sum(p[..., list(s.channelnames).index("density.Y")].sum() for s, p in parts) * pixel ** 2 * abs(gap)
    exact = sum(v["value"] * v["count"] for v in grids["density"].citerOnValues()) * np.prod([0.5, 0.6, 0.7])
    assert abs(total / exact - 1) < 0.02, (total, exact)


def what_cannot_be_written_leaves_nothing(d):
    """A disk that is full after some bytes, for slices and pictures; and Ctrl-C in the middle."""
    make_volume(d + "/v.vdb")
    os.mkdir(d + "/out")
    run("slice", d + "/v.vdb", "-o", d + "/whole.exr", "--slices", 6)
    size = os.path.getsize(d + "/whole.exr")

    def full_after(size):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        return limit

    jobs = [(["slice", d + "/v.vdb", "-o", d + "/out/s.exr", "--slices", 6], n) for n in (0, 5000, size // 2, size - 100, size - 1)]
    jobs += [(["slice", d + "/v.vdb", "-o", d + "/out/s.####.exr", "--slices", 6], 5000),
             (["render", d + "/v.vdb:surface", "-o", d + "/out/r.exr", "--size", "200x200"], 3000)]
    for words, limit in jobs:
        result = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, preexec_fn=full_after(limit))
        assert result.returncode == 1 and ".exr" in result.stderr, (words, limit, result.returncode, result.stderr)
        assert os.listdir(d + "/out") == [], (words, limit, os.listdir(d + "/out"))
    job = subprocess.Popen([PROGRAM, "slice", d + "/v.vdb", "-o", d + "/out/s.exr", "--slices", "3000", "--pixel-size", "0.1"],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.time() + 60
    while not os.listdir(d + "/out") and time.time() < until:
        time.sleep(0.01)
    assert job.poll() is None and os.listdir(d + "/out"), "it ended before it could be interrupted"
    job.send_signal(signal.SIGINT)
    assert job.wait(60) != 0 and os.listdir(d + "/out") == [], os.listdir(d + "/out")


def lost_slices_are_told(d):
    make_volume(d + "/v.vdb")
    run("slice", d + "/v.vdb", "-o", d + "/s.####.exr", "--slices", 9)
    os.remove(d + "/s.0004.exr")
    assert "8 slices of 9" in run("reconstruct", d + "/s.####.exr", "-o", d + "/b.vdb").stderr


def morph_straight_to_images(d):
    """EXR slices and pictures of morph equal those that slice and render make of its VDBs."""
    assets = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../assets")
    run("plan", assets + "/blade.ply", assets + "/ring.ply", "--resolution", 32, "-o", d + "/x.plan")
    words = ["morph", "--plan", d + "/x.plan", "--frames", 3]
    run(*words, "-o", d + "/m.####.vdb")
    plane = "0.01,0.02,0.03/1,2,3"
    run(*words, "-o", d + "/m.####.exr", "--exr", "slices", "--exr-plane", plane, "--pixel-size", 0.02)
    camera = ["--camera", "3,2,6", "--look-at", "0,0,0", "--fov", 30, "--size", "80x60"]
    run(*words, "-o", d + "/p.####.exr", *camera)
    run(*words, "-o", d + "/all.####.exr")
    run(*words, "-o", d + "/stack.####.exr", "--exr", "slices", "--exr-slices", 5, "--half")
    for n in (1, 2, 3):
        run("slice", "%s/m.%04d.vdb" % (d, n), "-o", d + "/s.exr", "--plane", plane, "--pixel-size", 0.02)
        (own, a), = read("%s/m.%04d.exr" % (d, n))
        (_, b), = read(d + "/s.exr")
        # One plane is as large as all frames need, the other as its own frame: they share whole pixels.
        shift = np.array(attribute(own, "sliceOrigin"), float) - attribute(_, "sliceOrigin")
        i, j = (int(round(np.dot(shift, attribute(own, axis)) / 0.02)) for axis in ("sliceAxisX", "sliceAxisY"))
        height, width = (min(b.shape[n] - max(o, 0), a.shape[n] - max(-o, 0)) for n, o in ((0, j), (1, i)))
        theirs = b[max(j, 0):max(j, 0) + height, max(i, 0):max(i, 0) + width]
        same = a[max(-j, 0):max(-j, 0) + height, max(-i, 0):max(-i, 0) + width]
        assert list(own.channelnames) == list(_.channelnames) and same.size > 0.8 * b.size, (same.shape, b.shape)
        # Their pixels' positions are sums of different doubles.
        assert np.abs(same - theirs).max() < 1e-6, np.abs(same - theirs).max()
        assert abs(attribute(own, "sliceT") - (n - 1) / 2) < 1e-12 and attribute(own, "sliceFrame") == n
        run("render", "%s/m.%04d.vdb" % (d, n), "-o", d + "/r.exr", *camera)
        (spec, a), = read("%s/p.%04d.exr" % (d, n))
        (_, b), = read(d + "/r.exr")
        assert set("RGBAZ") < set(spec.channelnames), spec.channelnames
        assert np.array_equal(a, b), np.abs(a - b).max()
        (spec, a), = read("%s/all.%04d.exr" % (d, n))
        mask = a[..., list(spec.channelnames).index("mask")]
        assert mask.max() == 1 and max(mask[0].max(), mask[-1].max(), mask[:, 0].max(), mask[:, -1].max()) == 0
    stacks = [[s for s, _ in read("%s/stack.%04d.exr" % (d, n))] for n in (1, 2, 3)]
    assert [len(s) for s in stacks] == [5, 5, 5]
    for other in stacks[1:]:
        for a, b in zip(stacks[0], other):
            assert attribute(a, "sliceOrigin") == attribute(b, "sliceOrigin") and (a.width, a.height) == (b.width, b.height)


CASES = [morph_straight_to_images, values_are_trilinear, parts_tiles_half_planes, oiiotool_reads_all, rebuilt_within_a_tenth_of_a_voxel,
         same_bytes_for_any_threads, constants_stay_themselves, frames_are_not_mixed,
         morph_slices_hold_all_of_the_fog, what_cannot_be_written_leaves_nothing, lost_slices_are_told]
sys.exit(run_cases([(case.__name__, case) for case in CASES], ONLY))
