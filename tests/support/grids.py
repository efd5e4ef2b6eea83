"""Shared by the Python tests: grids made and read with Debian's python3-openvdb."""
import os
import re
import subprocess

import numpy as np
import pyopenvdb as vdb

from cases import Skip


def level_set(distance, origin, h, name):
    """The narrow band of signed distances distance[i, j, k] on a box whose index coordinates begin at `origin`."""
    grid = vdb.FloatGrid(background=3 * h)
    grid.copyFromArray(np.clip(distance, -3 * h, 3 * h).astype(np.float32), ijk=origin, tolerance=0)
    grid.signedFloodFill()
    grid.prune()
    grid.gridClass = vdb.GridClass.LEVEL_SET
    grid.transform = vdb.createLinearTransform(h)
    grid.name = name
    return grid


def write(path, *grids, **metadata):
    vdb.write(path, grids=list(grids), metadata=metadata or None)
    return path


def puff(path, middle, radius, h=0.1):
    """Writes a ball of density 1 with a soft rim, on 24 voxels a side around 0."""
    n = 24
    x, y, z = np.meshgrid(*[(np.arange(n) - n / 2) * h] * 3, indexing="ij")
    distance = np.sqrt((x - middle[0]) ** 2 + (y - middle[1]) ** 2 + (z - middle[2]) ** 2) - radius
    grid = vdb.FloatGrid(background=0.0)
    grid.copyFromArray(np.clip(0.5 - distance / (3 * h), 0, 1).astype(np.float32))
    grid.name, grid.gridClass, grid.transform = "density", vdb.GridClass.FOG_VOLUME, vdb.createLinearTransform(h)
    return write(path, grid)


def ball(path, radius, center=(1, 2, 3), voxel=0.25):
    """Writes the level set of a ball."""
    return write(path, vdb.createLevelSetSphere(radius=radius, center=center, voxelSize=voxel))


def fog_of_smoke(shift):
    """A ball of fog on 24 x 20 x 22 voxels, `shift` of them up, their first index, and the place of such voxels of .3."""
    x, y, z = np.mgrid[:24, :20, :22]
    fog = np.clip(1.2 - np.sqrt((x - 12) ** 2 + (y - 10) ** 2 + (z - 9 - shift) ** 2) / 8, 0, 1).astype(np.float32)
    return fog, x, vdb.createLinearTransform([[.3, 0, 0, 0], [0, .3, 0, 0], [0, 0, .3, 0], [5, -2, 1 + shift, 1]])


def names(path):
    """Grids of a file with their types, by vdb_print, which knows all types."""
    out = subprocess.run(["vdb_print", "-l", path], capture_output=True, text=True).stdout
    return dict(zip(re.findall(r"^Name: (.*)$", out, re.M), re.findall(r"^  Type: (.*)$", out, re.M)))


def real(folder, name):
    """Path of a file of shared data; the case is skipped where it does not exist."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        raise Skip("no " + path)
    return path
