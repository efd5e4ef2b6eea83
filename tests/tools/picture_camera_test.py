#!/usr/bin/env python3
"""EXR pictures tell where they were taken from: balls at known places are drawn where the file's matrices put them. Read
with OpenImageIO.

usage: picture_camera_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-openimageio and python3-openvdb.
"""
import os
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import OpenImageIO as oiio
import pyopenvdb as vdb

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
program = Program(sys.argv[1])
ONLY = sys.argv[2:]
RADIUS = 0.4
BALLS = np.array([[3.0, 1.0, -2.0], [-2.5, 2.0, 1.0], [0.5, -3.0, 4.0]])
SIZE = (400, 260)
CAMERA = ("--camera", "1,2,20", "--look-at", "0.5,0,0", "--fov", "40")


def seen(*camera):
    """The picture of the balls: its channels by name, and its two matrices, which rows are multiplied by."""
    grid = vdb.createLevelSetSphere(radius=RADIUS, center=tuple(BALLS[0]), voxelSize=0.02)
    for centre in BALLS[1:]:  # they are far apart: none of one's voxels is of another
        ball = vdb.createLevelSetSphere(radius=RADIUS, center=tuple(centre), voxelSize=0.02)
        grid.combine(ball, min)
    vdb.write("balls.vdb", grids=[grid])
    program.run("render", "balls.vdb", "-o", "balls.exr", "--size", "%dx%d" % SIZE, *camera)
    file = oiio.ImageInput.open("balls.exr")
    pixels, spec = file.read_image("float"), file.spec()
    file.close()
    matrix = lambda name: np.array(spec.getattribute(name), float).reshape(4, 4)
    return ({name: pixels[..., i] for i, name in enumerate(spec.channelnames)}, matrix("worldToCamera"), matrix("worldToNDC"))


def transformed(point, matrix):
    row = np.append(point, 1) @ matrix
    return row[:3] / row[3]


def drawn_where_matrices_say(*camera):
    channels, to_camera, to_screen = seen(*camera)
    rows, columns = np.mgrid[:SIZE[1], :SIZE[0]] + 0.5
    for centre in BALLS:
        x, y, _ = transformed(centre, to_screen)
        column, row = (x + 1) / 2 * SIZE[0], (1 - y) / 2 * SIZE[1]
        # A ball's radius is 7 to 15 pixels, the balls are more than 40 apart.
        near = np.hypot(columns - column, rows - row) < 20
        weight = channels["mask"] * near
        assert weight.sum() > 50, (camera, centre, weight.sum())
        # In perspective the outline is an ellipse whose middle lies beyond the centre by (radius / distance)^2 of the
        # distance from the picture's middle, (.4 / 15)^2 * 130 = .1 pixel; the edge's samples move it by less than .3.
        assert abs(np.average(columns, weights=weight) - column) < 0.4, (camera, centre, column)
        assert abs(np.average(rows, weights=weight) - row) < 0.4, (camera, centre, row)
        # The nearest point lies a radius before the centre, give or take the voxel of .02.
        depth = transformed(centre, to_camera)[2]
        assert abs(channels["Z"][near].min() - (depth - RADIUS)) < 0.02, (depth, channels["Z"][near].min())
    # Left-handed: right, up and forward from the camera.
    turn = to_camera[:3, :3]
    assert np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) and abs(np.linalg.det(turn) + 1) < 1e-5
    return to_camera


def case_perspective():
    to_camera = drawn_where_matrices_say(*CAMERA)
    assert np.allclose(transformed([1, 2, 20], to_camera), 0, atol=1e-5)


def case_orthographic():
    drawn_where_matrices_say("--ortho", "--view", "0.3,-0.4,-1")


def case_focal_length_as_compositors_find_it():
    """The half angle of view from the two matrices, the way scripts for Nuke find it: the point (1, 0, 1) of the camera."""
    _, to_camera, to_screen = seen(*CAMERA)
    x = transformed(transformed([1, 0, 1], np.linalg.inv(to_camera)), to_screen)[0]
    assert abs(1 / x - np.tan(np.radians(20)) * SIZE[0] / SIZE[1]) < 1e-4, x


sys.exit(run_within(globals(), ONLY))
