#!/usr/bin/env python3
"""Times the Python package against pyopenvdb's copyToArray and against the program.

usage: python_benchmark.py PATH/TO/slicemorph FOLDER     (FOLDER: that holds the package)
"""
import os
import resource
import subprocess
import sys
import tempfile
import time

sys.path.append("/usr/lib/python3/dist-packages")
program, folder = map(os.path.abspath, sys.argv[1:3])
sys.path.insert(0, folder)

import numpy as np
import pyopenvdb as vdb

import slicemorph

RUNS = 5


def seconds(call):
    """The least user CPU time and wall time of some runs, and what the last one returned."""
    user = wall = float("inf")
    for _ in range(RUNS):
        before, start = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
        result = call()
        wall = min(wall, time.perf_counter() - start)
        user = min(user, resource.getrusage(resource.RUSAGE_SELF).ru_utime - before.ru_utime)
    return user, wall, result


def dense():
    values = np.random.default_rng(1).random((256, 256, 256), np.float32) + 1
    grid = slicemorph.Grid.from_numpy(values)
    theirs = grid.to_pyopenvdb()

    def copy():
        array = np.empty((256, 256, 256), np.float32)
        theirs.copyToArray(array)
        return array
    ours, peer = seconds(grid.to_numpy), seconds(copy)
    assert np.array_equal(ours[2], peer[2]) and np.array_equal(ours[2], values)
    print("to_numpy of 256^3: user %.3f s, wall %.3f s; copyToArray: user %.3f s, wall %.3f s; ratio user %.2f, wall %.2f" %
          (*ours[:2], *peer[:2], ours[0] / peer[0], ours[1] / peer[1]))


def user_of(*words):
    """User CPU time of the program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([program, *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def frames():
    """The program's time of a frame: of a long sequence less a short one, writing included in both."""
    count = 12
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        for name, radius, x in (("a", 0.9, -0.4), ("b", 0.5, 0.7)):
            at = (np.stack(np.meshgrid(*[np.arange(160)] * 3, indexing="ij"), -1) - 79.5) * 0.02
            distance = np.linalg.norm(at - [x, 0.2, 0], axis=-1) - radius
            slicemorph.from_grids(slicemorph.Grid.from_numpy(np.clip(distance, -0.06, 0.06), 0.02, at[0, 0, 0], name="surface",
                                                             grid_class="level set", background=0.06)).save(name + ".vdb")
        theirs = min((user_of("morph", "a.vdb", "b.vdb", "--frames", str(count + 2), "--range", "2-%d" % (count + 1), "-o", "m.####.vdb") -
                      user_of("morph", "a.vdb", "b.vdb", "--frames", str(count + 2), "--range", "2", "-o", "n.####.vdb")) / (count - 1)
                     for _ in range(3))
        plan = slicemorph.plan("a.vdb", "b.vdb")
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        for n in range(1, count + 1):
            plan.frame(n / (count + 1)).save("o.vdb")
        ours = (resource.getrusage(resource.RUSAGE_SELF).ru_utime - before) / count
        os.chdir("/")
    print("frame and its file: user %.3f s, the program's %.3f s; ratio %.2f" % (ours, theirs, ours / theirs))


dense()
frames()
