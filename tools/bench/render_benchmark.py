#!/usr/bin/env python3
"""Time of `slicemorph render` as a ratio of OpenVDB's vdb_render. usage: render_benchmark.py SLICEMORPH [MESH]

Both programs draw the same level set, 256 voxels along its longest side (of the mesh, else a sphere made by
OpenVDB), from the same position, as an EXR of 640 x 480 with the same samples per pixel. The runs alternate;
the fastest of each counts. On a busy machine only the processor time means something.
"""
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROUNDS = 3
FOV = 25  # degrees, from bottom to top


def seconds(command):
    """Wall clock and processor time of a command."""
    before, start = os.times(), time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    clock, after = time.perf_counter() - start, os.times()
    return clock, after.children_user + after.children_system - before.children_user - before.children_system


def make_sphere(path):
    script = "import pyopenvdb as v, sys; v.write(sys.argv[1], grids=[v.createLevelSetSphere(radius=127.5)])"
    subprocess.run(["/usr/bin/python3", "-c", script, path], check=True)


def box_of(program, path):
    """Lower and upper corner of a shape, world units."""
    text = subprocess.run([program, "info", path], check=True, capture_output=True, text=True).stdout
    numbers = [float(n) for n in re.search(r"box +(.*)", text).group(1).replace("..", " ").split()]
    return numbers[:3], numbers[3:]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = os.path.abspath(sys.argv[1])
    if not shutil.which("vdb_render"):
        sys.exit("vdb_render is not installed (Debian: libopenvdb-tools)")
    with tempfile.TemporaryDirectory() as folder:
        volume = folder + "/volume.vdb"
        if len(sys.argv) > 2:
            subprocess.run([program, "convert", sys.argv[2], "-o", volume, "--resolution", "256", "--quiet"], check=True)
        else:
            make_sphere(volume)
        low, high = box_of(program, volume)
        middle = [(a + b) / 2 for a, b in zip(low, high)]
        size = max(b - a for a, b in zip(low, high))
        camera = [middle[0] + 0.6 * size, middle[1] + 0.4 * size, middle[2] + 2.2 * size]
        position, target = (",".join("%.9g" % c for c in p) for p in (camera, middle))
        # vdb_render's angle of view is horizontal, ours vertical.
        across = math.degrees(2 * math.atan(math.tan(math.radians(FOV / 2)) * 640 / 480))
        for samples in (1, 4):
            theirs = ["vdb_render", volume, folder + "/theirs.exr", "-res", "640x480", "-samples", str(samples),
                      "-translate", position, "-lookat", target, "-fov", "%.9g" % across]
            ours = [program, "render", volume, "-o", folder + "/ours.exr", "--resolution", "640x480", "--samples", str(samples),
                    "--camera", position, "--look-at", target, "--fov", str(FOV), "--quiet"]
            best = [min(times) for times in zip(*[seconds(ours) + seconds(theirs) for _ in range(ROUNDS)])]
            print("samples a pixel %d: clock %.3f s, vdb_render %.3f s, ratio %.2f; processors %.3f s, vdb_render %.3f s, "
                  "ratio %.2f" % (samples, best[0], best[2], best[0] / best[2], best[1], best[3], best[1] / best[3]))


if __name__ == "__main__":
    main()
