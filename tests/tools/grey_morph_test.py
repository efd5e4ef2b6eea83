#!/usr/bin/env python3
"""Grey images change nothing where nothing changes: a scan morphed into itself is itself to the bit, and a morph
starts where its first scan is. The oracle is nibabel's and numpy's reading of the inputs.

usage: grey_morph_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-nibabel and python3-openvdb.
"""
import os
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data/medical")
TIMES = (0, 0.001, 0.25, 0.5, 1)
SPACING = (2.0, 2.5, 4.0)


program = Program(sys.argv[1])
run = program.run


def values(path):
    return np.asanyarray(nib.load(path).dataobj)


def scan(kind=np.int16, radius=(18, 15, 22), shift=(0, 0, 0), seed=3):
    """A body of 900 with a dark skin, darker than the isovalue of 400, cavities, and noise: on 28 x 22 x 16 voxels."""
    size = np.array([28, 22, 16])
    p = (np.stack(np.meshgrid(*[np.arange(n) for n in size], indexing="ij"), -1) - (size - 1) / 2) * SPACING - shift
    depth = 1 - np.sqrt(((p / radius) ** 2).sum(-1))
    body = np.where(depth > 0.12, 900, np.where(depth > 0, 350, -900)) - 500 * (np.abs(depth - 0.5) < 0.1)
    return (body + 25 * np.random.RandomState(seed).standard_normal(size)).astype(kind)


def write(path, data, turned=False):
    affine = np.diag([*SPACING, 1.0])
    affine[:3, 3] = -30, 12, 5
    if turned:
        affine[:3, :3] = [[0, -1, 0], [0.8, 0, 0.6], [-0.6, 0, 0.8]] @ affine[:3, :3]
    nib.save(nib.Nifti1Image(data, affine), path)


def rms(a, b):
    return float(np.sqrt(np.mean((a.astype(float) - b) ** 2)))


# ---------------------------------------------------------------------------------------------------------------------

def case_itself():
    """Every number type, an oblique lattice: the scan's own values at any time, from files of two formats, too."""
    for name, kind, turned in (("a", np.int16, False), ("b", np.float32, True), ("c", np.uint8, False)):
        data = scan(kind) if kind is not np.uint8 else (scan(float) / 8 + 120).clip(0, 255).astype(kind)
        iso = 400 if kind is not np.uint8 else 170
        write(name + ".nii.gz", data, turned)
        for other in (name + ".nii.gz", name + ".nrrd", name + ".mha"):
            if not os.path.exists(other):
                run("convert", name + ".nii.gz", "-o", other, "--image", "grey")
            run("morph", name + ".nii.gz", other, "-o", "m.##.nii.gz", "--at", ",".join(map(str, TIMES)), "--iso", iso,
                "--image", "grey")
            for frame in range(1, len(TIMES) + 1):
                got = values("m.%02d.nii.gz" % frame)
                assert got.dtype == data.dtype and np.array_equal(got, data), (name, other, frame)


def case_weights():
    """Of three scans, two of them the same: where only these count, they are what comes out."""
    a, b = scan(np.float32), scan(np.float32, radius=(15, 17, 19), shift=(3, 0, 2), seed=8)
    write("a.nii", a), write("b.nii", b)
    for weights in ("0.5,0,0.5", "0.999,0,0.001", "0.3333333333,0,0.6666666667"):
        run("morph", "a.nii", "b.nii", "a.nii", "-o", "m.nii", "--weights", weights, "--iso", 400)
        assert np.array_equal(values("m.nii"), a), weights
    run("morph", "a.nii", "a.nii", "a.nii", "-o", "m.nii", "--weights", "0.2,0.3,0.5", "--iso", 400)
    assert np.array_equal(values("m.nii"), a)


def case_outputs():
    """On another image's voxels, in other formats and by other methods: the same at every time."""
    data = scan()
    write("a.nii", data)
    finer = np.diag([1.4, 1.7, 2.1, 1.0])
    finer[:3, 3] = -29, 13, 6
    nib.save(nib.Nifti1Image(np.zeros((40, 31, 30), np.int16), finer), "like.nii")
    times = ",".join(map(str, TIMES))
    for options in (["--like", "like.nii"], ["--method", "dissolve"], ["--voxel-size", 3]):
        run("morph", "a.nii", "a.nii", "-o", "m.##.nii.gz", "--at", times, "--iso", 400, *options)
        first = values("m.01.nii.gz")
        for frame in range(2, len(TIMES) + 1):
            assert np.array_equal(values("m.%02d.nii.gz" % frame), first), (options, frame)
    for extension in ("nrrd", "mha", "vdb"):
        run("morph", "a.nii", "a.nii", "-o", "m.%s" % extension, "--at", 0.25, "--iso", 400)
        if extension == "vdb":
            grid, got = vdb.read("m.vdb", "image"), np.zeros(data.shape, np.float32)
            grid.copyToArray(got)
        else:
            run("convert", "m." + extension, "-o", "back.nii", "--image", "grey")
            got = values("back.nii")
        assert np.array_equal(got, data), extension


def case_start():
    """Two scans that differ: near t = 0 and 1 the frames go to them. What differs goes in proportion to t, and where
    depths are shifted ten times that is ample: below 1 % of the scans' own difference at t = 0.001."""
    a, b = scan(np.float32), scan(np.float32, radius=(20, 16, 20), shift=(2, 1, 0), seed=8)
    write("a.nii", a), write("b.nii", b)
    own = rms(a, b)
    for t, end in ((0.001, a), (0.999, b)):
        run("morph", "a.nii", "b.nii", "-o", "m.nii", "--at", t, "--iso", 400)
        assert rms(values("m.nii"), end) < 0.01 * own, (t, rms(values("m.nii"), end), own)


def case_asl():
    """A volume of a perfusion series with itself, and with the next one."""
    path = os.path.join(DATA, "mpld_asl.nii.gz")
    if not os.path.exists(path):
        raise Skip("mpld_asl.nii.gz is not there")
    series = nib.load(path)
    frames = [np.ascontiguousarray(np.asanyarray(series.dataobj)[..., n]) for n in (1, 2)]
    for name, data in zip("ab", frames):
        nib.save(nib.Nifti1Image(data, series.affine), name + ".nii")
    run("morph", "a.nii", "a.nii", "-o", "m.nii", "--at", 0.5)
    assert np.array_equal(values("m.nii"), frames[0])
    run("morph", "a.nii", "b.nii", "-o", "m.nii", "--at", 0.001)
    assert rms(values("m.nii"), frames[0]) < 0.01 * rms(*frames)
    # The first volume and one of far less signal: above 500 one has four times as many voxels as the other. Frames leave the
    # first without a jump.
    far = [np.ascontiguousarray(np.asanyarray(series.dataobj)[..., n]) for n in (0, 12)]
    for name, data in zip("cd", far):
        nib.save(nib.Nifti1Image(data, series.affine), name + ".nii")
    run("morph", "c.nii", "d.nii", "-o", "m.nii", "--at", 0.001, "--iso", 500)
    assert rms(values("m.nii"), far[0]) < 0.01 * rms(*far)


sys.exit(run_within(globals(), ONLY))
