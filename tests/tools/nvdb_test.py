#!/usr/bin/env python3
"""NanoVDB files hold what VDB files hold. Oracles: Debian's nanovdb_validate, nanovdb_convert and pyopenvdb.

usage: nvdb_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's libnanovdb-tools and python3-openvdb.
"""
import os
import subprocess
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import run_within
from grids import ball, fog_of_smoke
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
program = Program(sys.argv[1])
ONLY = sys.argv[2:]


def tool(*arguments):
    result = subprocess.run(arguments, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, (arguments, result.stdout, result.stderr)
    return result.stdout


def grids_of(path):
    return {grid.name: grid for grid in vdb.readAll(path)[0]}


def values(grid, box):
    """All values in a box of voxels, without which of them are active: pyopenvdb hands out no mask."""
    size = [int(n) for n in np.array(box[1]) - box[0] + 1]
    vector = isinstance(grid.background, tuple)
    array = np.zeros(size + [3] * vector, np.float64)
    grid.copyToArray(array, ijk=box[0])
    return array


def equal(a, b):
    """Values inside and outside, active voxels, place, name and class."""
    assert a.activeVoxelCount() == b.activeVoxelCount(), (a.name, a.activeVoxelCount(), b.activeVoxelCount())
    assert a.gridClass == b.gridClass and a.background == b.background, (a.name, a.gridClass, b.gridClass)
    box = a.evalActiveVoxelBoundingBox()
    assert box == b.evalActiveVoxelBoundingBox(), a.name
    if a.activeVoxelCount():
        wider = (tuple(n - 5 for n in box[0]), tuple(n + 5 for n in box[1]))
        assert np.array_equal(values(a, wider), values(b, wider)), a.name
    for voxel in ((0, 0, 0), (10, -3, 7)):
        assert np.allclose(a.transform.indexToWorld(voxel), b.transform.indexToWorld(voxel), rtol=1e-6, atol=1e-9), a.name


def same_as_vdb(*command):
    """A command's output as .nvdb is valid, and converted back the same as its output as .vdb."""
    program.run(*command, "-o", "as.vdb")
    program.run(*command, "-o", "as.nvdb")
    assert "failed" not in tool("nanovdb_validate", "-v", "as.nvdb").lower()
    tool("nanovdb_convert", "-f", "as.nvdb", "back.vdb")
    expected, found = grids_of("as.vdb"), grids_of("back.vdb")
    assert list(expected) == list(found), (list(expected), list(found))
    for name in expected:
        equal(expected[name], found[name])
    return found


def write_smoke(path, shift):
    """Fog and vectors on voxels of .3, off the origin."""
    fog, x, transform = fog_of_smoke(shift)
    density = vdb.FloatGrid()
    density.copyFromArray(fog)
    density.name, density.gridClass = "density", vdb.GridClass.FOG_VOLUME
    wind = vdb.Vec3SGrid()
    wind.copyFromArray(np.stack([fog, 2 * fog, x * fog], -1).astype(np.float32))
    wind.name = "wind"
    for grid in (density, wind):
        grid.transform = transform
    vdb.write(path, grids=[density, wind])


def case_morph_of_level_sets():
    for name, radius in (("a.vdb", 3.0), ("b.vdb", 4.0)):
        ball(name, radius)
    found = same_as_vdb("morph", "a.vdb", "b.vdb", "--at", "0.4")
    assert list(found) == ["surface"], list(found)


def case_morph_of_smoke():
    write_smoke("a.vdb", 0)
    write_smoke("b.vdb", 3)
    found = same_as_vdb("morph", "a.vdb", "b.vdb", "--at", "0.5")
    assert {"density", "wind"} <= set(found), list(found)


def case_image_as_grids():
    import nibabel as nib
    data = np.zeros((12, 10, 8), np.int16)
    data[3:9, 2:7, 2:6] = np.arange(6 * 5 * 4).reshape(6, 5, 4) + 100
    nib.save(nib.Nifti1Image(data, np.diag([2, 2, 3, 1.])), "scan.nii")
    same_as_vdb("convert", "scan.nii", "--iso", "150")


def case_surface_of_an_image_at_zero():
    """--iso 0 is the value 0, as any other: the surface of distances to a ball is the ball."""
    import nibabel as nib
    radius = 9.3
    at = np.stack(np.mgrid[:32, :32, :32], -1) - 15.5
    inside = (radius - np.linalg.norm(at, axis=-1)).astype(np.float32)
    affine = np.eye(4)
    affine[:3, 3] = -15.5
    nib.save(nib.Nifti1Image(inside, affine), "ball.nii")
    surface = same_as_vdb("convert", "ball.nii", "--iso", "0")["surface"]
    near = 0
    for voxel in surface.citerOnValues():
        distance = np.linalg.norm(surface.transform.indexToWorld(voxel.min)) - radius
        if abs(distance) > 1:
            continue
        near += 1
        # What is linear over a length l is off a ball by at most l^2 / 8 over its radius: values along an edge of a voxel, and sides of the
        # mesh between points in neighbouring voxels, which are at most sqrt(6) long.
        assert abs(voxel.value - distance) < (1 + 6) / (8 * (radius - 1)), (voxel.min, voxel.value, distance)
    # A shell of two voxels, to a tenth.
    assert abs(near / (8 * np.pi * radius ** 2) - 1) < 0.1, near


def case_sequence_is_the_same_for_any_threads():
    write_smoke("a.vdb", 0)
    write_smoke("b.vdb", 3)
    content = []
    for threads in ("1", "2"):
        program.run("morph", "a.vdb", "b.vdb", "--frames", "3", "--threads", threads, "-o", "x%s.####.nvdb" % threads)
        content.append([open("x%s.%04d.nvdb" % (threads, n), "rb").read() for n in (1, 2, 3)])
    assert content[0] == content[1]


def case_not_an_input():
    open("x.nvdb", "wb").write(b"NanoVDB0")
    assert ".vdb" in program.refused("convert", "x.nvdb", "-o", "y.vdb", says=["x.nvdb"])


sys.exit(run_within(globals(), ONLY))
