#!/usr/bin/env python3
"""What people drew on slices, through `slicemorph reconstruct`: structure sets as planning systems write them, labels on
slices of their own, far apart, or across several axes, and grey stacks. Against closed forms, polygons and pydicom.

usage: drawn_slices_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-nibabel, python3-pydicom, python3-scipy.
"""
import csv
import os
import sys

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian, generate_uid
from scipy import ndimage

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
SHARED = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data")
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
STRUCTURES = "1.2.840.10008.5.1.4.1.1.481.3"


program = Program(sys.argv[1])
run = program.run
refused = program.refused


def says(result, *parts):
    for part in parts:
        assert part in result.stderr, "%r is not in: %s" % (part, result.stderr)


# Structure sets.

def circle(x, y, z, radius, count=60):
    angle = np.arange(count) * 2 * np.pi / count
    return np.c_[x + radius * np.cos(angle), y + radius * np.sin(angle), np.full(count, float(z))]


def area(points):
    x, y = points[:, 0], points[:, 1]
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def column(x, y, radius, planes, kind="CLOSED_PLANAR"):
    return [(kind, circle(x, y, z, radius)) for z in planes]


def write_structures(path, structures, syntax=ExplicitVRLittleEndian, preamble=True, meta=True):
    """`structures`: triples of number, name and contours, which are pairs of type and N x 3 points."""
    data = FileDataset(path, {}, file_meta=FileMetaDataset(), preamble=b"\0" * 128 if preamble else None)
    data.SOPClassUID, data.SOPInstanceUID, data.Modality = STRUCTURES, generate_uid(), "RTSTRUCT"
    data.StructureSetLabel, data.ApprovalStatus = "test", "UNAPPROVED"
    data.StructureSetROISequence, data.ROIContourSequence, data.RTROIObservationsSequence = [], [], []
    for number, name, contours in structures:
        roi, region, seen = Dataset(), Dataset(), Dataset()
        roi.ROINumber, roi.ROIName = number, name
        region.ReferencedROINumber, seen.ReferencedROINumber, seen.ObservationNumber = number, number, number
        region.ContourSequence = []
        for kind, points in contours:
            item = Dataset()
            item.ContourGeometricType, item.NumberOfContourPoints = kind, len(points)
            item.ContourData = ["%.4f" % v for v in np.asarray(points, float).reshape(-1)]
            region.ContourSequence.append(item)
        data.StructureSetROISequence.append(roi)
        data.ROIContourSequence.append(region)
        data.RTROIObservationsSequence.append(seen)
    data.is_little_endian, data.is_implicit_VR = True, syntax == ImplicitVRLittleEndian
    if meta:
        data.file_meta.MediaStorageSOPClassUID, data.file_meta.MediaStorageSOPInstanceUID = STRUCTURES, data.SOPInstanceUID
        data.file_meta.TransferSyntaxUID = syntax
    data.save_as(path, write_like_original=not (preamble and meta))
    return data


def rows(path):
    return {row["name"]: row for row in csv.DictReader(open(path))}


def assert_stack_volume(volume, contours):
    """A stack's volume is its areas times its gaps, and at either end at most half a gap more."""
    z = np.array([p[0, 2] for _, p in contours])
    areas = np.array([area(p) for _, p in contours])
    gaps = np.diff(z)
    inner = (0.5 * (areas[1:] + areas[:-1]) * gaps).sum()
    ends = 0.5 * (areas[0] * gaps[0] + areas[-1] * gaps[-1])
    # Half a voxel of the surface more or less; voxels are at most a third of a gap.
    around = 0.5 * gaps.min() / 3 * (2 * np.sqrt(np.pi * areas)).mean() * np.ptp(z)
    assert inner - around <= 1000 * volume <= inner + ends + around, (volume, inner, ends, around)


GOOD = column(10, 5, 12, np.arange(0, 33, 3))
BAD = [("CLOSED_PLANAR", [[0, 0, 0], [10, 0, 0], [10, 10, 3], [0, 10, 0]])]


def case_left_out():
    """What makes no body is named, wherever it stands in the file, and the rest goes on."""
    marker, none, line, points = column(0, 0, 5, [15]), [], column(0, 0, 9, [0, 3, 6], "OPEN_PLANAR"), [("POINT", [[1, 2, 3]])]
    for n, order in enumerate(([("marker", marker), ("good", GOOD)], [("none", none), ("good", GOOD), ("marker", marker)],
                               [("line", line), ("point", points), ("good", GOOD), ("bad", BAD)])):
        write_structures("x.dcm", [(i + 1, name, contours) for i, (name, contours) in enumerate(order)])
        for output in ("o.stl", "o.nii.gz", "o.vdb"):
            result = run("reconstruct", "x.dcm", "-o", output, "--report", "o.csv")
            table = rows("o.csv")
            assert list(table) == ["good"], table
            assert_stack_volume(float(table["good"]["volume_ml"]), GOOD)
            for name, contours in order:
                if name != "good" and contours:
                    says(result, name)
            assert "x.dcm: x.dcm" not in result.stderr, result.stderr
    for name in ("good", "3"):
        run("reconstruct", "x.dcm:" + name, "-o", "one.stl")
    refused("reconstruct", "x.dcm:bad", "-o", "b.stl", says=["x.dcm", "bad", "not flat"])
    refused("reconstruct", "x.dcm:line", "-o", "b.stl", says=["x.dcm", "line", "good"])
    write_structures("y.dcm", [(1, "marker", marker), (2, "line", line)])
    refused("reconstruct", "y.dcm", "-o", "b.stl", says=["y.dcm", "marker", "one plane", "OPEN_PLANAR"])


def case_without_preamble():
    """Data sets alone, or with the meta information but no preamble; also as a folder's only file."""
    structures = [(4, "body", GOOD), (2, "iso", [("POINT", [[0, 0, 0]])])]
    write_structures("whole.dcm", structures)
    run("reconstruct", "whole.dcm", "-o", "whole.stl")
    for n, (syntax, meta) in enumerate(((ImplicitVRLittleEndian, False), (ExplicitVRLittleEndian, False),
                                        (ImplicitVRLittleEndian, True), (ExplicitVRLittleEndian, True))):
        folder = "f%d" % n
        os.mkdir(folder)
        write_structures(folder + "/rs.dcm", structures, syntax, preamble=False, meta=meta)
        assert open(folder + "/rs.dcm", "rb").read()[128:132] != b"DICM"
        read = pydicom.dcmread(folder + "/rs.dcm", force=True)
        assert read.StructureSetROISequence[0].ROIName == "body"
        for path in (folder + "/rs.dcm", folder):
            run("reconstruct", path, "-o", "o.stl")
            assert open("o.stl", "rb").read() == open("whole.stl", "rb").read(), (syntax, meta, path)


def case_interpolated():
    """INTERPOLATED_PLANAR contours are closed ones; their type is named."""
    write_structures("closed.dcm", [(1, "organ", GOOD)])
    run("reconstruct", "closed.dcm", "-o", "closed.stl")
    mixed = [("INTERPOLATED_PLANAR" if n % 2 else "CLOSED_PLANAR", p) for n, (_, p) in enumerate(GOOD)]
    for contours in (mixed, [("INTERPOLATED_PLANAR", p) for _, p in GOOD]):
        write_structures("x.dcm", [(1, "organ", contours)])
        says(run("reconstruct", "x.dcm", "-o", "o.stl"), "INTERPOLATED_PLANAR", "organ")
        assert open("o.stl", "rb").read() == open("closed.stl", "rb").read()


def case_overlap():
    """Structures that overlap: each has its own volume and mask; the label map says what it cannot hold."""
    planes = np.arange(0, 33, 3)
    outer, inner, aside = column(0, 0, 20, planes), column(4, 0, 10, planes), column(60, 0, 8, planes)
    write_structures("x.dcm", [(3, "outer", outer), (7, "inner", inner), (9, "aside", aside)])
    result = run("reconstruct", "x.dcm", "-o", "x.nii.gz", "--report", "x.csv")
    table = rows("x.csv")
    for name, contours in (("outer", outer), ("inner", inner), ("aside", aside)):
        assert_stack_volume(float(table[name]["volume_ml"]), contours)
    says(result, "outer", "####")
    assert "inner: has" not in result.stderr and "aside: has" not in result.stderr, result.stderr
    run("reconstruct", "x.dcm", "-o", "m.####.nii.gz", "--report", "m.csv")
    assert sorted(f for f in os.listdir(".") if f.startswith("m.0")) == ["m.0003.nii.gz", "m.0007.nii.gz", "m.0009.nii.gz"]
    for name, number, contours in (("outer", 3, outer), ("inner", 7, inner), ("aside", 9, aside)):
        image = nib.load("m.%04d.nii.gz" % number)
        mask = np.asanyarray(image.dataobj)
        assert set(np.unique(mask)) == {0, 1}
        volume = mask.sum() * np.prod(image.header.get_zooms()) / 1000
        row = rows("m.csv")[name]
        assert abs(float(row["volume_ml"]) - volume) < 1e-3 * volume and row["file"] == "m.%04d.nii.gz" % number
        # Between the first and the last plane the body is the polygon's prism.
        ijk = np.stack(np.meshgrid(*map(np.arange, mask.shape), indexing="ij"), -1).reshape(-1, 3)
        world = (LPS @ image.affine @ np.c_[ijk, np.ones(len(ijk))].T).T[:, :3]
        middle, radius = contours[0][1].mean(0), np.hypot(*(contours[0][1][0] - contours[0][1].mean(0))[:2])
        off = np.hypot(world[:, 0] - middle[0], world[:, 1] - middle[1]) - radius
        clear = (world[:, 2] >= 0) & (world[:, 2] <= 30) & (abs(off) > max(image.header.get_zooms()))
        assert np.array_equal(mask.reshape(-1)[clear] == 1, off[clear] < 0), name


def case_overlap_shared():
    """A clinical structure set with overlaps: volumes are pydicom's polygons times the planes' distance."""
    path = os.path.join(SHARED, "faults/image/overlap.dcm")
    if not os.path.exists(path):
        raise Skip("overlap.dcm is not there")
    says(run("reconstruct", path, "-o", "x.nii.gz", "--report", "x.csv", "--voxel-size", 1.5), "Tumor Bed Block", "####")
    table, read = rows("x.csv"), pydicom.dcmread(path)
    names = {r.ROINumber: r.ROIName for r in read.StructureSetROISequence}
    for region in read.ROIContourSequence:
        polygons = [np.array(c.ContourData, float).reshape(-1, 3) for c in region.ContourSequence]
        slab = 3 * sum(area(p) for p in polygons) / 1000  # planes are 3 mm apart, and no polygon of these is a hole
        around = 3 * 0.75 * sum(np.linalg.norm(p - np.roll(p, 1, 0), axis=1).sum() for p in polygons) / 1000  # half a voxel
        volume = float(table[names[region.ReferencedROINumber]]["volume_ml"])
        assert abs(volume - slab) < around, (names[region.ReferencedROINumber], volume, slab, around)


# Label maps.

def save(name, values, spacing=(1, 1, 1)):
    nib.save(nib.Nifti1Image(values, np.diag([*spacing, 1.0])), name)


def load(name):
    return np.asanyarray(nib.load(name).dataobj)


def tube(shape, start, slope, radius):
    """A slanted tube along k, as signed distances in its planes: negative inside. Straight in between, so linear motion is
    exact."""
    i, j, k = np.meshgrid(*map(np.arange, shape), indexing="ij")
    return np.hypot(i - start[0] - slope[0] * k, j - start[1] - slope[1] * k) - radius


def only(values, slices, axis=2):
    kept = np.zeros_like(values)
    index = [slice(None)] * 3
    index[axis] = slices
    kept[tuple(index)] = values[tuple(index)]
    return kept


def pieces(mask):
    """8-connected pieces of a slice."""
    return ndimage.label(mask, np.ones((3, 3)))[1]


def assert_tube(found, off, slices, radius, slope, label=1):
    """Between two slices the tube is where it was drawn. Voxels are known to one, half at either end of a distance; where the
    motion is not found at all, the blend of two circles' distances d apart is too narrow by r - sqrt(r^2 - d^2 / 4)."""
    first, last = slices[0], slices[-1]
    apart = np.hypot(*slope) * np.diff(slices).max()
    inner = found[:, :, first:last + 1] == label
    clear = abs(off[:, :, first:last + 1]) > 1 + radius - np.sqrt(radius ** 2 - apart ** 2 / 4)
    wrong = (inner != (off[:, :, first:last + 1] < 0)) & clear
    assert not wrong.any(), (label, slices, wrong.sum(), np.unique(np.nonzero(wrong)[2]) + first)
    for k in range(first, last + 1):
        assert pieces(found[:, :, k] == label) == 1, k


def case_uneven_gaps():
    """Slices drawn at unequal distances are gaps, and filled in; --given and --every say so by hand."""
    off = tube((64, 48, 44), (20, 22), (0.5, 0.1), 10)
    body = (off < 0).astype(np.uint8)
    for slices in ([0, 10, 25], [3, 10, 30], [0, 10, 20, 40], [5, 15, 20, 35, 40], [0, 4, 8, 20, 24], [1, 7, 8, 21]):
        thin = only(body, slices)
        save("thin.nii", thin, (1, 1, 2))
        result = run("reconstruct", "thin.nii", "-o", "dense.nii.gz")
        says(result, "axis k", ", ".join(map(str, slices)))
        dense = load("dense.nii.gz")
        assert np.array_equal(dense[:, :, slices], body[:, :, slices])
        assert_tube(dense, off, slices, 10, (0.5, 0.1))
        assert not dense[:, :, :slices[0]].any() and not dense[:, :, slices[-1] + 1:].any()
        run("reconstruct", "thin.nii", "-o", "told.nii.gz", "--given", ",".join(map(str, slices)))
        assert np.array_equal(load("told.nii.gz"), dense)
        turned = np.ascontiguousarray(thin.transpose(2, 0, 1))
        save("turned.nii", turned, (2, 1, 1))
        says(run("reconstruct", "turned.nii", "-o", "turned.nii.gz"), "axis i")
        assert np.array_equal(load("turned.nii.gz").transpose(1, 2, 0), dense)
    # Told otherwise: every fifth slice is given, and nothing is on the empty ones.
    save("thin.nii", only(body, [0, 10, 25]))
    run("reconstruct", "thin.nii", "-o", "every.nii.gz", "--every", 5)
    dense = load("every.nii.gz")
    assert not dense[:, :, [5, 15, 20]].any() and dense[:, :, [0, 10, 25]].any((0, 1)).all()
    run("reconstruct", "thin.nii", "-o", "all.nii.gz", "--given", "0,5,10,25")
    assert not load("all.nii.gz")[:, :, 5].any()
    assert load("all.nii.gz")[:, :, 18].any()
    refused("reconstruct", "thin.nii", "-o", "x.nii", "--given", "0,25", says=["--given", "10"])
    refused("reconstruct", "thin.nii", "-o", "x.nii", "--given", "0,10,99", says=["--given", "44"])
    refused("reconstruct", "thin.nii", "-o", "x.nii", "--given", "0,10,5", says=["--given"])
    refused("reconstruct", "thin.nii", "-o", "x.nii", "--given", "0,10,25", "--every", 5, says=["--given", "--every"])


def case_two_bodies():
    """Two bodies of one label beside each other: the empty slices of a regular stack between them part them."""
    low, high = tube((64, 48, 41), (14, 22), (0, 0), 8), tube((64, 48, 41), (48, 22), (0, 0), 8)
    body = np.zeros(low.shape, np.uint8)
    body[:, :, :17][low[:, :, :17] < 0] = 1
    body[:, :, 24:][high[:, :, 24:] < 0] = 1
    save("thin.nii", only(body, [0, 4, 8, 12, 16, 24, 28, 32, 36, 40]))
    says(run("reconstruct", "thin.nii", "-o", "dense.nii.gz"), "nothing is there", "20")
    dense = load("dense.nii.gz")
    assert not dense[:, :, 20].any() and dense[:, :, :17].any((0, 1)).all() and dense[:, :, 24:].any((0, 1)).all()


def case_own_slices():
    """Labels drawn on slices of their own are each filled in between those, and nowhere else."""
    shape = (64, 60, 44)
    tubes = {1: ((14, 30), (0.2, 0), 8), 2: ((44, 30), (0, 0.3), 8), 9: ((30, 8), (0.1, 0), 6)}
    offs = {label: tube(shape, *one) for label, one in tubes.items()}
    for own in ({1: [2, 10], 2: [4, 12]}, {1: [2, 10, 18], 2: [4, 12, 20]}, {1: [0, 8, 16, 24], 2: [4, 12, 20]},
                {1: [0, 7, 20], 2: [3, 12, 30], 9: [5, 15, 25]}, {1: [0, 10, 20], 2: [0, 5, 10, 15, 20]},
                {1: [0, 4, 8, 12, 16, 20, 24], 2: [0, 6, 12, 18, 24]}):
        thin = np.zeros(shape, np.int16)
        for label, slices in own.items():
            thin += only(np.where(offs[label] < 0, label, 0).astype(np.int16), slices)
        save("thin.nii", thin, (1, 1, 2))
        result = run("reconstruct", "thin.nii", "-o", "dense.nii.gz")
        dense = load("dense.nii.gz")
        assert np.array_equal(dense[thin != 0], thin[thin != 0])
        for label, slices in own.items():
            assert_tube(dense, offs[label], slices, tubes[label][2], tubes[label][1], label)
            assert not (dense[:, :, :slices[0]] == label).any() and not (dense[:, :, slices[-1] + 1:] == label).any(), (own, label)
        says(result, "slices of its own")


def case_absent_label():
    """On slices that were drawn for all labels, one that is not there is absent: given slices do not change."""
    shape = (64, 60, 41)
    thin = np.zeros(shape, np.uint8)
    around, inside, other = tube(shape, (30, 30), (0, 0), 24), tube(shape, (30, 30), (0, 0), 8), tube(shape, (58, 30), (0, 0), 4)
    for k in range(0, 41, 4):
        thin[:, :, k][around[:, :, k] < 0] = 1
        if k not in (16, 20):
            thin[:, :, k][inside[:, :, k] < 0] = 2
        if k not in (8,):
            thin[:, :, k][other[:, :, k] < 0] = 3
    save("thin.nii", thin)
    run("reconstruct", "thin.nii", "-o", "dense.nii.gz")
    dense = load("dense.nii.gz")
    assert np.array_equal(dense[:, :, ::4], thin[:, :, ::4])


def ellipsoid(shape, middle, radii):
    grid = np.meshgrid(*map(np.arange, shape), indexing="ij")
    return np.sqrt(sum(((g - m) / r) ** 2 for g, m, r in zip(grid, middle, radii)))


def dice(a, b):
    return 2 * (a & b).sum() / (a.sum() + b.sum())


def case_cross_slices():
    """Labels drawn on slices across two or three axes: each is one body through all its slices."""
    shape = (90, 80, 70)
    bodies = {1: ellipsoid(shape, (40, 36, 34), (28, 22, 20)), 4: ellipsoid(shape, (77, 62, 50), (10, 14, 16))}
    full = np.zeros(shape, np.int16)
    for label, body in bodies.items():
        full[body < 1] = label
    for planes in ({2: range(16, 70, 8), 1: range(18, 80, 9)}, {0: range(14, 70, 9), 1: [36, 60], 2: [20, 34, 35, 36, 48, 58]},
                   {0: [40, 74], 1: range(16, 80, 9), 2: [34, 50]}):
        thin = np.zeros(shape, np.int16)
        for axis, slices in planes.items():
            thin += np.where(thin == 0, only(full, list(slices), axis), 0).astype(np.int16)
        save("thin.nii", thin, (0.5, 0.5, 0.5))
        result = run("reconstruct", "thin.nii", "-o", "dense.nii.gz", "--report", "r.csv")
        says(result, "label 1", "across", "axis j")
        dense = load("dense.nii.gz")
        assert np.array_equal(dense[thin != 0], thin[thin != 0])
        for label in bodies:
            print("      %s label %d: Dice %.3f" % (sorted(planes), label, dice(dense == label, full == label)))
            assert dice(dense == label, full == label) > 0.9, label
            assert ndimage.label(dense == label)[1] == 1
            # Where its slices are, a label is not beside what was drawn.
            for axis, slices in planes.items():
                for at in slices:
                    if (np.take(full, at, axis) == label).sum() > 50:
                        assert np.array_equal(np.take(dense, at, axis) == label, np.take(full, at, axis) == label), (axis, at)
    run("reconstruct", "thin.nii", "-o", "s.####.stl")
    assert sorted(f for f in os.listdir(".") if f.endswith(".stl")) == ["s.0001.stl", "s.0004.stl"]
    save("whole.nii", full)
    refused("reconstruct", "whole.nii", "-o", "x.nii", says=["whole.nii", "dense"])


def case_masks_of_labels():
    """-o name.####.nii.gz of a label map writes a mask of each label."""
    off = {3: tube((40, 40, 17), (12, 12), (0.2, 0), 7), 5: tube((40, 40, 17), (28, 28), (0, 0), 6)}
    thin = sum(only(np.where(o < 0, label, 0).astype(np.uint8), [0, 4, 8, 12, 16]) for label, o in off.items())
    save("thin.nii", thin)
    run("reconstruct", "thin.nii", "-o", "dense.nii")
    run("reconstruct", "thin.nii", "-o", "m.##.nii", "--report", "m.csv")
    for label in off:
        assert np.array_equal(load("m.%02d.nii" % label), (load("dense.nii") == label).astype(np.uint8))
    assert {row["file"] for row in rows("m.csv").values()} == {"m.03.nii", "m.05.nii"}


# Grey stacks.

def waves(shape, speed):
    """A body with a texture that moves in the planes from slice to slice, all of it smooth at a pixel's size."""
    i, j, k = np.meshgrid(*map(lambda n: np.arange(n, dtype=float), shape), indexing="ij")
    x, y = i - speed[0] * k, j - speed[1] * k
    body = 1 / (1 + np.exp((np.hypot(x - 24, y - 24) - 15) / 1.5))
    return body * (600 + 250 * np.sin(2 * np.pi * x / 16) * np.cos(2 * np.pi * y / 20))


def case_grey():
    """Grey values move from slice to slice; given slices stay to the bit, and types as they are."""
    shape, step = (64, 60, 25), 6
    full = waves(shape, (0.5, 0.3))  # 3.5 pixels from one given slice to the next
    for kind in (np.int16, np.uint16, np.float32):
        values = full.astype(kind) if kind == np.float32 else np.rint(full).astype(kind)
        given = list(range(0, 25, step))
        blend = np.stack([(1 - t % 1) * full[:, :, int(t) * step] + (t % 1) * full[:, :, min(int(t) + 1, 4) * step]
                          for t in np.arange(25) / step], -1)
        between = [k for k in range(25) if k % step]
        for name, options in (("stack", ("--between", step - 1, "--axis", "k")), ("thin", ()),
                              ("told", ("--given", ",".join(map(str, given)), "--axis", "k"))):
            save("in.nii", values[:, :, ::step] if name == "stack" else only(values, given), (1, 1, 2))
            result = run("reconstruct", "in.nii", "-o", "out.nii", *options)
            says(result, "grey", "axis k")
            out = nib.load("out.nii")
            assert out.shape == shape and out.get_data_dtype() == kind, out.header
            found = load("out.nii").astype(float)
            assert np.array_equal(load("out.nii")[:, :, given], values[:, :, given])
            error = np.sqrt(((found - full)[:, :, between] ** 2).mean())
            plain = np.sqrt(((blend - full)[:, :, between] ** 2).mean())
            print("      %s %s: rms %.1f, blended where they are %.1f" % (kind.__name__, name, error, plain))
            assert error < 0.25 * plain, (error, plain)
    # What stands still is still.
    flat = np.repeat(np.rint(full[:, :, :1]).astype(np.int16), 13, 2)
    save("flat.nii", only(flat, [0, 4, 12]))
    run("reconstruct", "flat.nii", "-o", "out.nii")
    assert np.array_equal(load("out.nii"), flat)
    refused("reconstruct", "in.nii", "-o", "x.stl", says=["in.nii", "grey", "--image labels"])
    save("dense.nii", np.rint(full).astype(np.int16))
    refused("reconstruct", "dense.nii", "-o", "x.nii", says=["dense.nii", "grey", "--between"])
    # Some flat slices do not make a dense image a sparse one.
    save("dense.nii", only(np.rint(full).astype(np.int16), [k for k in range(25) if k % 5 != 2]))
    refused("reconstruct", "dense.nii", "-o", "x.nii", says=["dense.nii", "grey", "--given"])


def case_grey_marks():
    """What is no number, or a huge mark of "no measurement", leaves the motion elsewhere and the rest of the values alone."""
    shape, step = (64, 60, 25), 6
    full = waves(shape, (0.5, 0.3)).astype(np.float32)
    for mark in (np.nan, 1e20, -3.4e38):
        marked = full.copy()
        marked[:6, :6, :] = mark
        save("in.nii", marked[:, :, ::step], (1, 1, 2))
        run("reconstruct", "in.nii", "-o", "out.nii", "--between", step - 1, "--axis", "k", "--image", "grey")
        found, between = load("out.nii"), [k for k in range(25) if k % step]
        assert np.array_equal(found[:, :, ::step], marked[:, :, ::step], equal_nan=True)
        rest = (found - full)[12:, 12:, between]  # beyond what moves in from the mark
        assert np.isfinite(rest).all() and np.sqrt((rest ** 2).mean()) < 0.1 * full.std(), (mark, np.sqrt((rest ** 2).mean()), full.std())


def case_grey_head():
    """Of a real head, every fourth slice: moved values are nearer to the true slices than values blended where they are."""
    path = "/usr/share/mricron/templates/ch2bet.nii.gz"
    if not os.path.exists(path):
        raise Skip("mricron-data is not there")
    full = load(path)[:, :, :177]
    save("in.nii", np.ascontiguousarray(full[:, :, ::4]))
    run("reconstruct", "in.nii", "-o", "out.nii", "--between", 3, "--axis", "k", "--image", "grey")
    found, whole = load("out.nii").astype(float), full.astype(float)
    assert np.array_equal(found[:, :, ::4], whole[:, :, ::4])
    between = [k for k in range(177) if k % 4]
    blend = np.stack([(1 - k % 4 / 4) * whole[:, :, k // 4 * 4] + k % 4 / 4 * whole[:, :, min(k // 4 * 4 + 4, 176)] for k in between], -1)
    error, plain = (np.sqrt(((a - whole[:, :, between]) ** 2).mean()) for a in (found[:, :, between], blend))
    print("      rms %.2f, blended where they are %.2f" % (error, plain))
    assert error < plain


sys.exit(run_within(globals(), ONLY))
