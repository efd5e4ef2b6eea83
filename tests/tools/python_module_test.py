#!/usr/bin/env python3
"""The Python package: plans and frames in memory, against closed forms and against the program.

usage: python_module_test.py PATH/TO/slicemorph FOLDER REPOSITORY [NAME...]
FOLDER: that holds the package; NAME: only the cases whose name contains it

Needs Debian's python3-openvdb, python3-nibabel and python3-tqdm, and their Python.
"""
import gc
import json
import os
import re
import resource
import signal
import subprocess
import sys
import threading
import time

sys.path.append("/usr/lib/python3/dist-packages")
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
if len(sys.argv) < 4:
    sys.exit(__doc__)
PACKAGE, ONLY = os.path.abspath(sys.argv[2]), sys.argv[4:]
sys.path.insert(0, PACKAGE)

import numpy as np
import pyopenvdb as vdb

import slicemorph
from cases import run_within
from grids import level_set, puff, write
from program import Program

PROGRAM = Program(sys.argv[1])
H = 0.05
SIDE = 72
SMALL = {"slices": 24, "samples": 48}


def positions(side=SIDE, h=H):
    """World positions of the voxels, side x side x side x 3, around 0."""
    return (np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1) - (side - 1) / 2) * h


ORIGIN = positions()[0, 0, 0]


def ball(radius, middle, grey=False):
    """Signed distances, below 0 inside; grey: above 0 inside, as a scan is bright."""
    distance = np.linalg.norm(positions() - np.array(middle), axis=-1) - radius
    return (-distance if grey else distance).astype(np.float32)


BALLS = ((0.9, (-0.4, 0, 0)), (0.5, (0.7, 0.3, -0.2)))


def between(t):
    """Radius and middle of the ball between the two."""
    (r, p), (s, q) = BALLS
    return (1 - t) * r + t * s, (1 - t) * np.array(p) + t * np.array(q)


def errors(mesh, t):
    """Mean and greatest distance of the vertices from the ball between, in voxels."""
    radius, middle = between(t)
    distance = np.abs(np.linalg.norm(mesh.vertices - middle, axis=1) - radius) / H
    return distance.mean(), distance.max()


def grids():
    return [slicemorph.Grid.from_numpy(ball(*b), H, ORIGIN, name="surface", grid_class="level set", background=3 * H)
            for b in BALLS]


def images():
    return [slicemorph.from_numpy(ball(*b, grey=True), H, ORIGIN, name=name) for b, name in zip(BALLS, "ab")]


def raises(kind, call, *says):
    """Returns the exception, whose text holds all of `says`."""
    try:
        call()
    except kind as error:
        for part in says:
            assert part in str(error), "%r is not in: %s" % (part, error)
        return error
    raise AssertionError("no %s was raised" % kind.__name__)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def case_numpy_balls_to_a_sequence():
    """Grids and grey images of two balls: every frame is the ball between; points follow."""
    for inputs, options in ((grids(), {}), (images(), {"iso": 0})):
        plan = slicemorph.plan(*inputs, **options)
        frames = list(plan.frames(5))
        assert [f.number for f in frames] == [1, 2, 3, 4, 5] and [f.t for f in frames] == [0, 0.25, 0.5, 0.75, 1]
        for frame in frames:
            mesh = frame.to_mesh()
            mean, most = errors(mesh, frame.t)
            # What the project promises, as in tests/engine/morph_test.cpp.
            assert mean < 0.1 and most < 1, "t = %g: mean %.3f, most %.3f voxels" % (frame.t, mean, most)
            assert mesh.vertices.dtype == np.float32 and mesh.faces.shape[1] == 3
        direction = np.random.default_rng(1).normal(size=(200, 3))
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        carried = plan.apply(between(0)[1] + between(0)[0] * direction, 0, 0.5)
        radius, middle = between(0.5)
        far = np.abs(np.linalg.norm(carried - middle, axis=1) - radius) / H
        assert far.max() < 1, "carried points lie up to %.2f voxels off the surface" % far.max()
        back = plan.apply(carried, from_=[0.5, 0.5], to=0.0)
        assert np.abs(back - (between(0)[1] + between(0)[0] * direction)).max() < H


def case_same_bytes_as_the_program():
    """Frames of grids, images, meshes and fog that are in memory are the program's files, byte by byte."""
    a, b = grids()
    for name, grid in (("a", a), ("b", b)):
        write(name + ".vdb", grid.to_pyopenvdb())
    PROGRAM.run("morph", "a.vdb", "b.vdb", "--slices", 24, "--samples", 48, "--frames", 5, "-o", "m.####.vdb")
    memory = slicemorph.plan(slicemorph.from_grids(a, name="a"), slicemorph.from_grids(b, name="b"), **SMALL)
    files = slicemorph.plan(slicemorph.load("a.vdb"), "b.vdb", **SMALL)
    for plan in (memory, files):
        for frame in plan.frames(5):
            frame.save("n.vdb")
            assert read("n.vdb") == read("m.%04d.vdb" % frame.number), "frame %d differs" % frame.number
    # A frame at a time is that of a sequence of as many frames.
    slicemorph.plan("a.vdb", "b.vdb", frames=5, **SMALL).frame(0.75).save("n.vdb")
    assert read("n.vdb") == read("m.0004.vdb")
    PROGRAM.run("morph", "a.vdb", "b.vdb", "--slices", 24, "--samples", 48, "--weights", "0.3,0.7", "-o", "w.ply")
    memory.frame(weights=[0.3, 0.7]).save("n.ply")
    assert read("n.ply") == read("w.ply")

    for image in images():
        image.save(image.name + ".nrrd")
    PROGRAM.run("morph", "a.nrrd", "b.nrrd", "--iso", 0, "--slices", 24, "--samples", 48, "--at", 0.5, "-o", "m.nii.gz")
    slicemorph.plan(*images(), iso=0, **SMALL).frame(0.5).save("n.nii.gz")
    assert read("n.nii.gz") == read("m.nii.gz")

    puff("p.vdb", (0, 0, 0), 0.8), puff("q.vdb", (0.3, 0, 0), 0.5)
    PROGRAM.run("morph", "p.vdb", "q.vdb", "--slices", 24, "--samples", 48, "--frames", 3, "-o", "f.####.vdb")
    fogs = [slicemorph.from_pyopenvdb(vdb.read(name + ".vdb", "density"), name=name) for name in "pq"]
    for frame in slicemorph.plan(*fogs, **SMALL).frames(3):
        frame.save("n.vdb")
        # pyopenvdb's grids lack the file's metadata; the voxels are what counts.
        theirs, ours = (vdb.read(path, "density") for path in ("f.%04d.vdb" % frame.number, "n.vdb"))
        assert theirs.activeVoxelCount() == ours.activeVoxelCount() and active_values(theirs) == active_values(ours), frame


def active_values(grid):
    """The active values of a grid of pyopenvdb, and where they are."""
    return [(value.min, value.max, value.value) for value in grid.citerOnValues()]


def case_morph_writes_the_programs_files():
    a, b = grids()
    write("a.vdb", a.to_pyopenvdb()), write("b.vdb", b.to_pyopenvdb())
    PROGRAM.run("morph", "a.vdb", "b.vdb", "--slices", 24, "--samples", 48, "--frames", 3, "-o", "m.####.vdb")
    calls = []
    made = slicemorph.morph("a.vdb", "b.vdb", output="n.####.vdb", frames=3, progress=lambda *c: calls.append(c), **SMALL)
    assert made == ["n.%04d.vdb" % n for n in (1, 2, 3)]
    assert all(read(path) == read("m" + path[1:]) for path in made)
    assert calls and all(isinstance(stage, str) and 0 <= share <= 1 for stage, share in calls)
    held = slicemorph.morph(a, b, output="h.####.vdb", frames=3, report="h.json", **SMALL)
    assert held == ["h.%04d.vdb" % n for n in (1, 2, 3)] and os.path.getsize("h.json") > 1000, held
    raises(slicemorph.InputError, lambda: slicemorph.morph(a, b, output="h.####.vdb", resume=True), "resume")


def case_every_option_has_its_name():
    """The options are those of `morph --help-all`."""
    helped = PROGRAM.run("morph", "--help-all").stdout
    told = set(re.findall(r"^\s+(?:-o,)?--([a-z0-9-]+)", helped, re.M)) - {"help", "help-all"}
    ours = {row["name"] for row in slicemorph.options("morph").values()} - {"feature", "region"}
    assert told == ours, told ^ ours
    assert "voxel_size" in slicemorph.plan.__doc__ and "voxel_size" in slicemorph.options()
    raises(slicemorph.InputError, lambda: slicemorph.plan("a", "b", voxelsize=1), "voxel_size")
    raises(slicemorph.InputError, lambda: slicemorph.plan(*grids(), slices=3), "--slices 3", "8 to 1024")
    raises(slicemorph.InputError, lambda: slicemorph.plan(*grids(), conserve="no"), "conserve")


def case_errors_have_fields():
    error = raises(slicemorph.IoError, lambda: slicemorph.load("none.vdb"))
    assert (error.about, error.text) == ("none.vdb", "no such file") and isinstance(error, OSError)
    error = raises(slicemorph.InputError, lambda: slicemorph.plan(*grids(), slizes=9))
    assert error.about == "slizes" and isinstance(error, ValueError)
    with open("bad.vdb", "w") as file:
        file.write("no grid")
    error = raises(slicemorph.IoError, lambda: slicemorph.plan("bad.vdb", "bad.vdb"))
    assert error.about == "bad.vdb" and isinstance(error, slicemorph.Error)
    flat = slicemorph.from_numpy(np.zeros((4, 4, 4), np.float32))
    raises(slicemorph.GeometryError, lambda: slicemorph.plan(flat, flat))
    plan = slicemorph.plan(*grids(), **SMALL)
    raises(slicemorph.InputError, lambda: plan.frame(1.5), "1.5")
    raises(slicemorph.InputError, lambda: plan.frame(), "time or weights")
    raises(slicemorph.InputError, lambda: plan.frame(weights=[1]), "weights")
    raises(slicemorph.InputError, lambda: plan.apply(np.zeros((3, 2))), "N x 3")
    raises(slicemorph.InputError, lambda: slicemorph.plan(np.zeros((3, 3, 3)), "b.vdb"), "from_numpy")
    raises(slicemorph.InputError, lambda: slicemorph.from_numpy(np.zeros((3, 3))), "three axes")
    raises(slicemorph.InputError, lambda: slicemorph.from_numpy(np.zeros((3, 3, 3)), spacing=-1), "spacing")
    raises(slicemorph.InputError, lambda: slicemorph.from_numpy(np.zeros((3, 3, 3), complex)), "complex")


def case_no_growth():
    """Plans and frames in one process, 100 with SLICEMORPH_ALL_TESTS: not every quarter of them takes more memory than the one before."""
    small = [slicemorph.Grid.from_numpy(ball(*b)[::3, ::3, ::3].copy(), 3 * H, ORIGIN, grid_class="level set", background=9 * H)
             for b in BALLS]

    def taken():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * resource.getpagesize() / 1e6

    at, quarter = [], 25 if os.environ.get("SLICEMORPH_ALL_TESTS") else 7
    for _ in range(4):
        for _ in range(quarter):
            frame = slicemorph.plan(*small, slices=8, samples=16).frame(0.5)
            frame.to_mesh(), frame.to_numpy()
            gc.collect()
        at.append(taken())
    # A frame that is kept takes 0.5 MB and a plan more, in every quarter; the allocator takes and gives some MB now and then.
    grown = min(np.diff(at)) / quarter
    print("    resident after each %d plans: %s MB; at least %.3f MB a plan" % (quarter, ", ".join("%.1f" % x for x in at), grown))
    assert grown < 0.1, "%.3f MB more with each plan" % grown


def case_arrays():
    """Arrays of images are views; dense copies of grids are pyopenvdb's; boxes choose."""
    values = np.arange(2 * 3 * 4, dtype=np.int16).reshape(2, 3, 4)
    for array in (values, np.asfortranarray(values), values[::-1], values.transpose(2, 0, 1)):
        image = slicemorph.from_numpy(array, (1, 2, 3), (5, 6, 7))
        back = image.to_numpy()
        assert np.array_equal(back, array) and back.dtype == array.dtype
        assert not back.flags.writeable and np.shares_memory(back, image.to_numpy())
        assert np.allclose(image.affine, [[1, 0, 0, 5], [0, 2, 0, 6], [0, 0, 3, 7], [0, 0, 0, 1]])
    del image
    gc.collect()
    assert back.sum() == values.sum()
    for kind, made in ((bool, np.uint8), (np.int64, np.int32), (np.float16, np.float32), (">f4", np.float32)):
        back = slicemorph.from_numpy((values % 2).astype(kind)).to_numpy()
        assert back.dtype == made and np.array_equal(back, values % 2), kind
    raises(slicemorph.InputError, lambda: slicemorph.from_numpy(values.astype(np.int64) << 40), "32 bits")

    grid = grids()[0]
    theirs = grid.to_pyopenvdb()
    (i, j, k), (l, m, n) = theirs.evalActiveVoxelBoundingBox()
    assert grid.box == ((i, j, k), (l, m, n))
    dense = np.empty((l - i + 1, m - j + 1, n - k + 1), np.float32)
    theirs.copyToArray(dense, ijk=(i, j, k))
    assert np.array_equal(grid.to_numpy(), dense)
    part = grid.to_numpy(box=((3, 4, 5), (10, 12, 14)))
    assert part.shape == (8, 9, 10) and np.array_equal(part, ball(*BALLS[0])[3:11, 4:13, 5:15])
    vectors = np.random.default_rng(2).normal(size=(5, 6, 7, 3)).astype(np.float32)
    assert np.array_equal(slicemorph.Grid.from_numpy(vectors).to_numpy(), vectors)
    flags = vectors[..., 0] > 0
    assert np.array_equal(slicemorph.Grid.from_numpy(flags).to_numpy(box=((0, 0, 0), (4, 5, 6))), flags)


def case_nibabel_round_trip():
    """An oblique image comes back with its affine; world positions are LPS, so x and y are turned round."""
    import nibabel
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = turn * [0.7, 0.8, 1.1], [-12, 30, 4]
    values = np.random.default_rng(4).integers(0, 999, (6, 7, 8)).astype(np.int16)
    theirs = nibabel.Nifti1Image(values, affine)
    ours = slicemorph.from_nibabel(theirs)
    assert np.allclose(ours.affine, np.diag([-1, -1, 1, 1]) @ affine)
    assert np.allclose(ours.spacing, [0.7, 0.8, 1.1]) and np.array_equal(ours.to_numpy(), values)
    back = ours.to_nibabel()
    assert np.allclose(back.affine, affine) and np.array_equal(np.asarray(back.dataobj), values)
    # The file, as the library reads it itself, is the same.
    nibabel.save(theirs, "a.nii.gz")
    read_ours = slicemorph.load("a.nii.gz")
    assert np.allclose(read_ours.affine, ours.affine, atol=1e-5) and np.array_equal(read_ours.to_numpy(), values)
    ours.save("b.nii")
    again = nibabel.load("b.nii")
    assert np.allclose(again.affine, affine, atol=1e-5) and np.array_equal(np.asarray(again.dataobj), values)
    many = nibabel.Nifti1Image(np.zeros((3, 3, 3, 2), np.float32), affine)
    raises(slicemorph.InputError, lambda: slicemorph.from_nibabel(many), "one volume")


def case_pyopenvdb_round_trip():
    """Names, classes, transforms, values and types of grids come back; an off-diagonal transform too."""
    theirs = level_set(ball(*BALLS[0]), (-5, 2, 7), H, "shape")
    matrix = [[0, 0.1, 0, 0], [-0.1, 0, 0, 0], [0, 0, 0.1, 0], [1, 2, 3, 1]]
    turned = theirs.deepCopy()
    turned.transform = vdb.createLinearTransform(matrix)
    for grid in (theirs, turned):
        ours = slicemorph.Grid.from_pyopenvdb(grid)
        assert ours.name == "shape" and ours.grid_class == "level set" and ours.active_voxels == grid.activeVoxelCount()
        for index in ((0, 0, 0), (1, 2, 3)):
            assert np.allclose(ours.affine @ [*index, 1], [*grid.transform.indexToWorld(index), 1])
        back = ours.to_pyopenvdb()
        assert back.name == grid.name and back.gridClass == grid.gridClass and back.background == grid.background
        assert active_values(back) == active_values(grid) and np.allclose(back.transform.indexToWorld((1, 2, 3)), grid.transform.indexToWorld((1, 2, 3)))
    shape = slicemorph.from_pyopenvdb(theirs).grids["shape"]
    assert active_values(shape.to_pyopenvdb()) == active_values(theirs)
    raises(slicemorph.InputError, lambda: slicemorph.Grid.from_numpy(np.ones((2, 2, 2))).to_pyopenvdb(), "double")


def cube(size):
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corner, np.array([t for q in quads for t in (q[:3], [q[0], q[2], q[3]])])


def case_meshes():
    """What has vertices and faces is an input; the surface that comes back is where it was."""
    class Trimesh:  # as trimesh has it
        vertices, faces = cube(2.0)

    for mesh in (Trimesh(), cube(2.0), slicemorph.Mesh(*cube(2.0))):
        shape = slicemorph.compare(mesh, mesh, resolution=32)
        assert abs(shape["a"]["volume"] - 8) < 0.1 and shape["a"]["pieces"] == 1, shape["a"]
    own = slicemorph.from_mesh(*cube(2.0)).to_mesh()
    assert np.allclose(own.vertices, cube(2.0)[0]) and np.array_equal(own.faces, cube(2.0)[1])
    surface = slicemorph.from_mesh(Trimesh()).to_mesh(resolution=32)
    assert np.allclose(surface.vertices.min(0), 0, atol=0.04) and np.allclose(surface.vertices.max(0), 2, atol=0.04)
    frame = slicemorph.plan(cube(2.0), cube(3.0), resolution=32, **SMALL).frame(0.5)
    grown = slicemorph.compare(frame, cube(2.5), resolution=32)
    assert abs(grown["a"]["volume"] ** (1 / 3) - 2.5) < 0.1, grown
    red = np.zeros((8, 3))
    red[:, 0] = 1
    colored = slicemorph.from_mesh(*cube(2.0), colors=red)
    assert np.allclose(slicemorph.plan(colored, colored, resolution=32, **SMALL).frame(0.5).to_mesh().colors, [1, 0, 0], atol=1e-3)
    raises(slicemorph.InputError, lambda: slicemorph.from_mesh(cube(1)[0], [[0, 1, 8]]), "vertex 8")
    raises(slicemorph.InputError, lambda: slicemorph.from_mesh(cube(1)[0], [0, 1, 2]), "faces")
    try:
        import trimesh
    except ImportError:
        return print("    no trimesh: its own class is not tried")
    box = trimesh.creation.box((1, 1, 1))
    back = slicemorph.from_mesh(box).to_mesh().to_trimesh()
    assert back.is_watertight and abs(back.volume - 1) < 1e-6


def case_tables_of_job_files():
    """Features, regions and keys are dicts; what is wrong with them is told."""
    with open("job.toml", "w") as file:
        file.write('[[feature]]\nname = "side"\npoint = [[0.5, 0, 0], [1.17, 0.471, -0.2]]\n')
    tables = {"feature": [{"name": "side", "point": [np.array([0.5, 0, 0]), (1.17, 0.471, -0.2)]}]}  # 20 degrees round
    plan, by_file = slicemorph.plan(*grids(), **tables, **SMALL), slicemorph.plan(*grids(), config="job.toml", **SMALL)
    assert np.array_equal(plan.frame(0.5).to_mesh().vertices, by_file.frame(0.5).to_mesh().vertices)
    off = [np.linalg.norm(p.apply([[0.5, 0, 0]], 0, 1)[0] - [1.17, 0.471, -0.2]) / H
           for p in (plan, slicemorph.plan(*grids(), **SMALL))]
    assert off[0] < 1 < off[1], off
    assert not [note for note in plan.notes if note.severity == "warning"], plan.notes
    keyed = slicemorph.plan(*grids(), keys=[{"at": 0, "input": "2"}, {"at": 1, "weights": [1, 0]}], **SMALL)
    assert keyed.weights_at(0.25) == [0.25, 0.75]
    assert slicemorph.plan(*grids(), keys=[(2, 0), (1, 1)], **SMALL).weights_at(0.25) == [0.25, 0.75]
    raises(slicemorph.InputError, lambda: slicemorph.plan(*grids(), feature=[{"pont": 1}]), "feature")
    raises(slicemorph.InputError, lambda: slicemorph.plan(*grids(), feature="top"), "list of dicts")
    raises(slicemorph.InputError, lambda: slicemorph.plan(*grids(), config="job.toml", **tables), "job file")
    raises(slicemorph.InputError, lambda: plan.save("x.plan"), "in memory")


def case_carry_and_velocity():
    """A further grid moves with the shapes; velocities are those of balls that move."""
    plan = slicemorph.plan(*grids(), frames=25, **SMALL)
    heat = [slicemorph.Grid.from_numpy(np.where(ball(*b) < 0, value, 0).astype(np.float32), H, ORIGIN, name="heat")
            for b, value in zip(BALLS, (1, 3))]
    carried = plan.carry(heat, 0.5)
    radius, middle = between(0.5)
    inside = np.array([carried.to_numpy(box=(tuple(i), tuple(i)))[0, 0, 0] for i in
                       np.round((middle + 0.5 * radius * np.eye(3) - carried.affine[:3, 3]) / H).astype(int)])
    assert np.allclose(inside, 2, atol=1e-3), inside
    velocity = plan.frame(0.5).velocity()
    assert velocity.value_type == "vec3s" and np.array_equal(velocity.to_numpy(), plan.velocity(0.5).to_numpy())
    lattice, box = velocity.to_numpy(), velocity.box
    at = np.stack(np.meshgrid(*[np.arange(box[0][d], box[1][d] + 1) for d in range(3)], indexing="ij"), -1)
    world = at @ velocity.affine[:3, :3].T + velocity.affine[:3, 3]
    there = np.abs(np.linalg.norm(world - middle, axis=-1) - radius) < H
    # A second has 24 frames of 24 steps: the whole way. Balls grow towards each point evenly.
    truth = (between(1)[1] - between(0)[1]) + (BALLS[1][0] - BALLS[0][0]) * (world - middle) / radius
    off = np.linalg.norm(lattice - truth, axis=-1)[there & (np.linalg.norm(lattice, axis=-1) > 0)]
    assert off.size > 50 and off.mean() < 0.1 * np.linalg.norm(truth[there], axis=-1).mean(), (off.size, off.mean())
    raises(slicemorph.InputError, lambda: plan.carry([heat[0]], 0.5), "each of 2")
    raises(slicemorph.InputError, lambda: plan.frame(weights=[0.5, 0.5]).velocity(), "velocities")


def case_other_commands():
    """compare, render, slice and reconstruct against closed forms, and their files against the program's."""
    a, b = grids()
    compared = slicemorph.compare(a, b)
    (r, p), (s, q) = BALLS
    for key, radius in (("a", r), ("b", s)):
        assert abs((compared[key]["volume"] / (4 / 3 * np.pi)) ** (1 / 3) - radius) < 0.1 * H, compared[key]
    far = np.linalg.norm(np.subtract(q, p)) + r - s
    assert abs(compared["distance"]["max"] - max(far, np.linalg.norm(np.subtract(q, p)) + s - r)) < H
    write("a.vdb", a.to_pyopenvdb()), write("b.vdb", b.to_pyopenvdb())
    told = json.loads(PROGRAM.run("compare", "a.vdb", "b.vdb", "--json").stdout)
    ours = slicemorph.compare("a.vdb", "b.vdb")
    assert told == ours, (told, ours)

    picture = slicemorph.render(a, size="120x90", view=(0, 0, -1), ortho=True, transparent=True)
    assert picture.shape == (90, 120, 4) and picture.dtype == np.float32
    seen = picture[..., 3] > 0.5
    rows, columns = np.nonzero(seen)
    assert abs(np.ptp(rows) - np.ptp(columns)) <= 1 and abs(seen.sum() / (np.pi / 4 * (np.ptp(rows) + 1) ** 2) - 1) < 0.05
    assert slicemorph.render(a, turntable=3, size="40x30").shape == (3, 30, 40, 4)
    assert slicemorph.srgb(picture)[..., :3].max() <= 1
    PROGRAM.run("render", "a.vdb", "--size", "60x40", "-o", "theirs.png")
    slicemorph.render("a.vdb", size="60x40", output="ours.png")
    assert read("ours.png") == read("theirs.png")

    cuts = slicemorph.slice(a, slices=9, axis="x")
    assert len(cuts) == 9
    for cut in cuts:
        values = cut.values["surface"]
        j, i = np.indices(values.shape)
        world = cut.origin + cut.pixel_size * (i[..., None] * cut.x_axis + j[..., None] * cut.y_axis)
        truth = np.linalg.norm(world - p, axis=-1) - r
        near = np.abs(truth) < 2 * H
        assert np.abs(values - truth)[near].max() < 0.1 * H, np.abs(values - truth)[near].max()
    PROGRAM.run("slice", "a.vdb", "--slices", 3, "-o", "t.####.exr")
    assert slicemorph.slice("a.vdb", slices=3, output="o.####.exr") == ["o.000%d.exr" % n for n in (1, 2, 3)]
    assert read("o.0002.exr") == read("t.0002.exr")

    labels = (ball(*BALLS[0]) < 0).astype(np.uint8)
    sparse = np.zeros_like(labels)
    sparse[:, :, ::4] = labels[:, :, ::4]
    given = slicemorph.from_numpy(sparse, H, ORIGIN, name="sparse", labels=True)
    dense = slicemorph.reconstruct(given, every=4).to_numpy()
    given.save("sparse.nrrd")
    PROGRAM.run("reconstruct", "sparse.nrrd", "--every", 4, "--image", "labels", "-o", "dense.nrrd")
    assert np.array_equal(dense, slicemorph.load("dense.nrrd").to_numpy())
    assert 2 * (dense * labels).sum() / (dense.sum() + labels.sum()) > 0.97
    surfaces = slicemorph.reconstruct(given, every=4, surfaces=True)
    assert list(surfaces) == ["label_1"] and abs(slicemorph.compare(surfaces["label_1"], a)["dice"] - 1) < 0.03


def case_ctrl_c():
    """Ctrl-C ends a long call with KeyboardInterrupt, and the next call works; so does an exception of the progress."""
    big = [slicemorph.from_mesh(*cube(size)) for size in (2.0, 3.0)]
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    start = time.time()
    try:
        slicemorph.morph(*big, output="m.####.vdb", frames=2000, resolution=128)
        raise AssertionError("was not interrupted")
    except KeyboardInterrupt:
        assert time.time() - start < 60
    assert len(os.listdir(".")) < 2000

    def stop(stage, share):
        raise RuntimeError("no more")
    raises(RuntimeError, lambda: slicemorph.plan(*big, resolution=128, progress=stop), "no more")
    assert slicemorph.plan(*big, resolution=24, **SMALL).overlap > 0.9


def case_progress_bars():
    class Bar:  # as tqdm has it
        def __init__(self, total=None):
            self.total, self.n, self.stages = total, 0, []

        def update(self, n):
            assert n > 0
            self.n += n

        def set_description(self, text, refresh=True):
            self.stages.append(text)

    bar = Bar(total=10)
    slicemorph.plan(*[slicemorph.from_mesh(*cube(size)) for size in (2.0, 3.0)], resolution=96, progress=bar)
    assert bar.n == 10 and bar.stages, (bar.n, bar.stages)
    from tqdm import tqdm
    with open("bar.txt", "w") as out:
        real = tqdm(total=100, file=out)
        slicemorph.plan(*[slicemorph.from_mesh(*cube(size)) for size in (2.0, 3.0)], resolution=24, progress=real, **SMALL)
        assert real.n == 100
        real.close()


def case_other_threads_run():
    """Long calls release the interpreter's lock, and two plans may be made at once."""
    counted = [0, True]

    def count():
        while counted[1]:
            counted[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    results = []
    makers = [threading.Thread(target=lambda: results.append(slicemorph.plan(*grids(), **SMALL).frame(0.5).to_mesh().vertices))
              for _ in range(2)]
    for maker in makers:
        maker.start()
    for maker in makers:
        maker.join()
    counted[1] = False
    counter.join()
    assert counted[0] > 10 and len(results) == 2 and np.array_equal(*results)


def case_sequences():
    """Numbered files as inputs: each frame has its own plan, in any order that is asked for."""
    for n in (1, 2, 3):
        puff("p.%04d.vdb" % n, (0.1 * n, 0, 0), 0.8)
    puff("q.vdb", (0.3, 0, 0), 0.5)
    PROGRAM.run("morph", "p.####.vdb", "q.vdb", "--slices", 24, "--samples", 48, "-o", "m.####.vdb")
    plan = slicemorph.plan("p.####.vdb", slicemorph.load("q.vdb"), **SMALL)
    for frame in (*plan.frames(), plan.frame(0.5), plan.frame(0)):
        frame.save("n.vdb")
        assert read("n.vdb") == read("m.%04d.vdb" % frame.number), frame
    # A frame that is kept has its own inputs, wherever the plan has gone since.
    for frame in list(plan.frames()):
        frame.save("n.vdb")
        assert read("n.vdb") == read("m.%04d.vdb" % frame.number), frame
    raises(slicemorph.InputError, lambda: plan.apply([[0, 0, 0]]), "sequences")


def case_cancelled_sequences():
    """Calls on sequences that were cancelled, at whatever stage, spoil none after them: frames stay the program's."""
    class Stop(Exception):
        pass

    for n in (1, 2, 3):
        puff("p.%04d.vdb" % n, (0.1 * n, 0, 0), 0.8)
    puff("q.vdb", (0.3, 0, 0), 0.5)
    PROGRAM.run("morph", "p.####.vdb", "q.vdb", "--slices", 24, "--samples", 48, "-o", "m.####.vdb")
    for before, asked in ((0, 0.5), (1, 0)):
        stopped = 0
        for call in (1, 3, 8):  # of the progress
            for after in (asked, before):
                plan = slicemorph.plan("p.####.vdb", "q.vdb", **SMALL)
                plan.frame(before)
                calls = []

                def stop(stage, share):
                    calls.append(stage)
                    if len(calls) == call:
                        raise Stop()
                try:
                    plan.frame(asked, progress=stop)
                except Stop:
                    stopped += 1
                frame = plan.frame(after)
                frame.save("n.vdb")
                assert read("n.vdb") == read("m.%04d.vdb" % frame.number), (before, asked, calls, after)
        assert stopped > 1, "no call was long enough to be cancelled"


def case_plan_files():
    """A plan is written for the program, and the program's taken."""
    a, b = grids()
    write("a.vdb", a.to_pyopenvdb()), write("b.vdb", b.to_pyopenvdb())
    plan = slicemorph.plan("a.vdb", "b.vdb", **SMALL)
    plan.save("x.plan")
    PROGRAM.run("morph", "--plan", "x.plan", "--at", 0.5, "-o", "m.ply")
    slicemorph.plan(plan="x.plan", output="n.ply").frame(0.5).save("n.ply")
    plan.frame(0.5).save("o.ply")
    assert read("m.ply") == read("n.ply") == read("o.ply")
    raises(slicemorph.InputError, lambda: slicemorph.plan(a, b, **SMALL).save("y.plan"), "in memory")


def case_alone():
    """The package is imported where there is no program, and beside pyopenvdb, whichever comes first."""
    for first in ("import pyopenvdb, slicemorph", "import slicemorph, pyopenvdb"):
        code = "import sys; sys.path.append('/usr/lib/python3/dist-packages'); sys.path.insert(0, %r); %s; g = pyopenvdb.FloatGrid(); " \
               "print(slicemorph.Grid.from_pyopenvdb(g).value_type)" % (PACKAGE, first)
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={"PATH": ""})
        assert result.returncode == 0 and result.stdout == "float\n", result.stderr


sys.exit(run_within(globals(), ONLY))
