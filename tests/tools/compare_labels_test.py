#!/usr/bin/env python3
"""`compare` of two label maps, label by label, against numpy and scipy.

usage: compare_labels_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Distances are between the centres of outer voxels (with a neighbour over a face outside of the label), both directions
together; lengths are millimetres.
"""
import csv
import json
import os
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
from scipy import ndimage

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
SPACING = np.array([0.8, 1.1, 2.5])


program = Program(sys.argv[1])
run = program.run


def turned(origin=(3, -4, 5)):
    """LPS affine of voxels on turned axes."""
    c, s = np.cos(0.3), np.sin(0.3)
    affine = np.eye(4)
    affine[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) * SPACING
    affine[:3, 3] = origin
    return affine


def save(name, labels, affine):
    nib.save(nib.Nifti1Image(labels, LPS @ affine), name)


def ball(shape, middle, radius):
    index = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), -1)
    return np.linalg.norm((index - np.array(middle)) * SPACING, axis=-1) < radius


def expected(a, b, label, spacing):
    """Dice, and mean, 95 % and largest distance of outer voxels."""
    a, b = a == label, b == label
    outer = [m & ~ndimage.binary_erosion(m) for m in (a, b)]
    to = [ndimage.distance_transform_edt(~m, sampling=spacing) for m in outer]
    distances = np.r_[to[1][outer[0]], to[0][outer[1]]]
    return 2 * (a & b).sum() / (a.sum() + b.sum()), distances.mean(), np.percentile(distances, 95), distances.max()


def two_maps():
    shape = (44, 36, 20)
    a, b = np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
    a[ball(shape, (14, 15, 8), 9)] = 1
    b[ball(shape, (16, 14, 9), 8)] = 1
    a[ball(shape, (34, 20, 8), 6)] = 4
    b[ball(shape, (33, 20, 8), 6) & ~ball(shape, (33, 20, 8), 3)] = 4
    a[0:4, 0:5, 0:3] = 9  # at the border, and only in one
    b[20:23, 1:4, 15:17] = 200
    return a, b


def near(found, true, tolerance=1e-5):
    """Floats of 32 bits: seven digits."""
    assert abs(found - true) <= tolerance * max(1, abs(true)), (found, true)


def case_every_label():
    """Volumes, Dice, distances and centroids of each label are scipy's; JSON and CSV say the same."""
    a, b = two_maps()
    affine = turned()
    save("a.nii.gz", a, affine), save("b.nii.gz", b.astype(np.int16), affine)
    printed = run("compare", "a.nii.gz", "b.nii.gz", "--report", "r.csv", "--report", "r.json").stdout
    assert "dice" in printed and "only in A" in printed and "only in B" in printed
    rows = {row["label"]: row for row in json.load(open("r.json"))["labels"]}
    assert sorted(rows) == [1, 4, 9, 200]
    voxel = abs(np.linalg.det(affine[:3, :3]))
    for label, row in rows.items():
        for values, side in ((a, "A"), (b, "B")):
            at = np.argwhere(values == label)
            near(row["volumeMl" + side], len(at) * voxel / 1000)
            if len(at):
                middle = affine[:3, :3] @ at.mean(0) + affine[:3, 3]
                assert np.abs(np.array(row["centroid" + side]) - middle).max() < 1e-4
            else:
                assert row["centroid" + side] is None
        if label in (9, 200):
            assert row["dice"] == 0 and row["distanceMm"]["mean"] is None
            continue
        dice, mean, p95, most = expected(a, b, label, SPACING)
        near(row["dice"], dice, 1e-12)
        near(row["distanceMm"]["mean"], mean), near(row["distanceMm"]["p95"], p95), near(row["distanceMm"]["max"], most)
        near(row["centroidDistanceMm"], np.linalg.norm(np.array(row["centroidA"]) - row["centroidB"]))
    table = list(csv.DictReader(open("r.csv")))
    assert [int(row["label"]) for row in table] == [1, 4, 9, 200]
    for row in table:
        own = rows[int(row["label"])]
        assert float(row["dice"]) == own["dice"] and float(row["volume_a_ml"]) == own["volumeMlA"]
        assert row["distance_p95_mm"] == ("" if own["distanceMm"]["p95"] is None else repr(own["distanceMm"]["p95"]))


def case_same():
    a, _ = two_maps()
    save("a.nii.gz", a, turned()), save("b.nrrd.nii", a, turned())
    for row in json.loads(run("compare", "a.nii.gz", "b.nrrd.nii", "--json").stdout)["labels"]:
        assert row["dice"] == 1 and row["distanceMm"]["max"] == 0 and row["centroidDistanceMm"] == 0


def case_other_voxels():
    """A map on a part of the other's voxels, and stored in another order, is the same labels at the same places."""
    a, b = two_maps()
    affine = turned()
    part = affine.copy()
    part[:3, 3] = affine[:3, :3] @ [2, 3, 1] + affine[:3, 3]
    moved = b[2:, 3:, 1:][:, ::-1]
    part[:3, 3] += part[:3, 1] * (moved.shape[1] - 1)
    part[:3, 1] = -part[:3, 1]
    save("a.nii.gz", a, affine), save("part.nii.gz", np.ascontiguousarray(moved), part)
    cut = b.copy()
    cut[:2], cut[:, :3], cut[:, :, :1] = 0, 0, 0
    result = run("compare", "a.nii.gz", "part.nii.gz", "--json")
    assert "other voxels" in result.stderr
    for row in json.loads(result.stdout)["labels"]:
        if row["label"] not in (1, 4):
            continue
        dice, mean, p95, most = expected(a, cut, row["label"], SPACING)
        near(row["dice"], dice, 1e-12), near(row["distanceMm"]["mean"], mean), near(row["distanceMm"]["max"], most)
    # The other way round the first map's voxels do not reach as far as the second one's.
    for row in json.loads(run("compare", "part.nii.gz", "a.nii.gz", "--json").stdout)["labels"]:
        at = np.argwhere(a == row["label"])
        near(row["volumeMlB"], len(at) * abs(np.linalg.det(affine[:3, :3])) / 1000)
        if row["label"] in (1, 4):
            near(row["dice"], expected(a, cut, row["label"], SPACING)[0], 1e-12)


def case_lost_label():
    """A label that the coarser voxels of the first map pass over is still in the list."""
    a = np.zeros((8, 8, 8), np.uint8)
    a[2:6, 2:6, 2:6] = 1
    fine = np.repeat(np.repeat(np.repeat(a, 3, 0), 3, 1), 3, 2)
    fine[0, 0, 0], fine[23, 12, 3] = 5, 1
    coarse, small = np.diag([3.0, 3, 3, 1]), np.eye(4)
    small[:3, 3] = -1
    save("a.nii", a, coarse), save("b.nii", fine, small)
    rows = {row["label"]: row for row in json.loads(run("compare", "a.nii", "b.nii", "--json").stdout)["labels"]}
    assert sorted(rows) == [1, 5], rows
    near(rows[5]["volumeMlB"], 1e-3), near(rows[5]["volumeMlA"], 0)
    assert rows[5]["dice"] == 0


def case_shapes():
    """Of shapes the table has one line with the figures of --json."""
    a, _ = two_maps()
    save("a.nii.gz", (a == 1).astype(np.float32) * 100, turned())
    run("convert", "a.nii.gz", "-o", "a.ply", "--iso", 50)
    found = json.loads(run("compare", "a.nii.gz", "a.ply", "--json", "--report", "r.csv", "--image", "grey", "--iso", "50").stdout)
    (row,) = csv.DictReader(open("r.csv"))
    assert float(row["dice"]) == found["dice"] and float(row["distance_p95"]) == found["distance"]["p95"]
    assert found["distance"]["mean"] <= found["distance"]["p95"] <= found["distance"]["p99"] <= found["distance"]["max"]
    assert "labels" not in found


sys.exit(run_within(globals(), ONLY))
