"""A mesh of another package, here two arrays, morphed into a file's; the half-way surface as arrays and as a file.

usage: meshes.py FILE.ply
"""
import sys

import numpy as np

import slicemorph

corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]

# Objects with `vertices` and `faces`, as those of trimesh, are taken as they are.
plan = slicemorph.plan((corners, quads), sys.argv[1], resolution=48, slices=32, fit="size",
                       progress=lambda stage, share: print("%3.0f %% %s" % (100 * share, stage)))
half = plan.frame(0.5)
vertices, faces, colors = half.to_mesh()
print(len(vertices), "vertices,", len(faces), "faces, box", vertices.min(0), "to", vertices.max(0))
half.save("half.ply")
print(slicemorph.compare(half, (corners, quads), resolution=48)["distance"])
