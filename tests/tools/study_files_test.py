#!/usr/bin/env python3
"""Files of a study that the program writes: DICOM segmentations, RT structure sets, segmentations of 3D Slicer, surfaces
with their coordinate system; against pydicom, dciodvfy (dicom3tools), plastimatch and closed forms.

usage: study_files_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)
"""
import glob
import gzip
import json
import os
import shutil
import struct
import subprocess
import sys
from xml.etree import ElementTree

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
import pydicom

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from program import Program
from study_objects import errors_of, points_inside, segment_masks, steps_of, write_ct

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
SPACING = (0.9, 0.7)  # between rows, between columns
TILT = np.deg2rad(20)
# Rows along x, columns down a plane that is turned about x.
OBLIQUE = (1, 0, 0, 0, np.cos(TILT), np.sin(TILT))
FIRST, COUNT, GAP, SIZE = np.array([-20.25, 12.5, -100.0]), 12, 2.5, (40, 48)


program = Program(sys.argv[1])
run = program.run
refused = program.refused


def affine_of(orientation, first=FIRST, gap=GAP):
    """LPS affine of voxels (column, row, slice)."""
    x, y = np.array(orientation[:3]), np.array(orientation[3:])
    affine = np.eye(4)
    affine[:3, 0], affine[:3, 1], affine[:3, 2], affine[:3, 3] = x * SPACING[1], y * SPACING[0], np.cross(x, y) * gap, first
    return affine


def study_labels():
    """Columns x rows x slices: 3: a ball with a hollow; 7: a ring that touches the picture's border; 250: one voxel and a
    diagonal pair."""
    i, j, k = np.meshgrid(np.arange(SIZE[1]), np.arange(SIZE[0]), np.arange(COUNT), indexing="ij")
    labels = np.zeros(i.shape, np.uint8)
    ball = ((i - 14) * 0.7) ** 2 + ((j - 18) * 0.9) ** 2 + ((k - 5) * 2.5) ** 2
    labels[(ball < 81) & (ball > 16)] = 3
    ring = ((i - 40) * 0.7) ** 2 + ((j - 20) * 0.9) ** 2
    labels[(ring < 64) & (ring > 9) & (k > 1) & (k < 10)] = 7
    labels[2, 2, 3] = labels[5, 30, 0] = labels[6, 31, 0] = 250
    return labels


def write_study(orientation=OBLIQUE):
    """A CT series `ct` and labels `labels.nii.gz` on its voxels; their array and LPS affine."""
    affine = affine_of(orientation)
    write_ct("ct", [affine[:3, 3] + k * affine[:3, 2] for k in range(COUNT)], SIZE, SPACING, orientation)
    labels = study_labels()
    nib.save(nib.Nifti1Image(labels, LPS @ affine), "labels.nii.gz")
    return labels, affine


def sources():
    """The data sets of `ct` by SOP instance UID."""
    sets = [pydicom.dcmread("ct/" + name) for name in sorted(os.listdir("ct"))]
    return {d.SOPInstanceUID: d for d in sets}


def assert_masks(path, names, labels, affine):
    """The frames hold each label at its voxels, exactly, and nothing elsewhere."""
    masks, d = segment_masks(path)
    assert set(masks) == set(names.values()), masks.keys()
    x, y = steps_of(d)
    # A float of 32 bits has 1e-5 mm at 100 mm; NIfTI's affine holds such.
    assert np.abs(x - affine[:3, 0]).max() < 1e-6 and np.abs(y - affine[:3, 1]).max() < 1e-6, (x, y)
    inverse = np.linalg.inv(affine)
    for label, name in names.items():
        found = np.zeros(labels.shape, bool)
        for position, mask in masks[name]:
            voxel = inverse[:3, :3] @ position + inverse[:3, 3]
            assert np.abs(voxel - np.rint(voxel)).max() < 1e-4 and np.abs(voxel[:2]).max() < 1e-4, voxel
            found[:, :, int(np.rint(voxel[2]))] |= mask.T
        assert np.array_equal(found, labels == label), (name, found.sum(), (labels == label).sum())
    return d


def case_segmentation():
    """Masks are exact; segments have names and colours; frames name the source's images; dciodvfy finds no error."""
    labels, affine = write_study()
    run("convert", "labels.nii.gz", "-o", "x.seg.dcm", "--source", "ct", "--names", "3=Leber groß,7=ring")
    assert not errors_of("x.seg.dcm"), errors_of("x.seg.dcm")
    d = assert_masks("x.seg.dcm", {3: "Leber groß", 7: "ring", 250: "label_250"}, labels, affine)
    images = sources()
    one = next(iter(images.values()))
    assert (d.PatientID, str(d.PatientName), d.StudyInstanceUID, d.FrameOfReferenceUID) == \
        ("P 17", "Müller^Anna", one.StudyInstanceUID, one.FrameOfReferenceUID)
    assert d.SeriesInstanceUID != one.SeriesInstanceUID and d.SegmentationType == "BINARY"
    for groups in d.PerFrameFunctionalGroupsSequence:
        source = groups.DerivationImageSequence[0].SourceImageSequence[0]
        at = np.array(images[source.ReferencedSOPInstanceUID].ImagePositionPatient, float)
        assert np.abs(at - np.array(groups.PlanePositionSequence[0].ImagePositionPatient, float)).max() < 1e-4
    assert d.ReferencedSeriesSequence[0].SeriesInstanceUID == one.SeriesInstanceUID
    colors = [tuple(s.RecommendedDisplayCIELabValue) for s in d.SegmentSequence]
    assert len(set(colors)) == 3, colors
    assert len({d.SOPInstanceUID, d.SeriesInstanceUID}) == 2 and all(len(u) <= 64 for u in (d.SOPInstanceUID, d.SeriesInstanceUID))


def case_segmentation_alone():
    """Without a source it stands for itself; of one date the same content is the same bytes, another content has other UIDs."""
    labels, affine = write_study((1, 0, 0, 0, 1, 0))
    day = {"SOURCE_DATE_EPOCH": "1767225600"}
    run("convert", "labels.nii.gz", "-o", "a.seg.dcm", env=day)
    assert not errors_of("a.seg.dcm"), errors_of("a.seg.dcm")
    d = assert_masks("a.seg.dcm", {n: "label_%d" % n for n in (3, 7, 250)}, labels, affine)
    assert d.FrameOfReferenceUID and "ReferencedSeriesSequence" not in d and d.ContentDate == "20260101"
    run("convert", "labels.nii.gz", "-o", "b.seg.dcm", "--threads", "1", env=day)
    assert open("a.seg.dcm", "rb").read() == open("b.seg.dcm", "rb").read()
    labels[20, 20, 6] = 9
    nib.save(nib.Nifti1Image(labels, LPS @ affine), "labels.nii.gz")
    run("convert", "labels.nii.gz", "-o", "c.seg.dcm", env=day)
    c = pydicom.dcmread("c.seg.dcm")
    assert not {c.SOPInstanceUID, c.SeriesInstanceUID, c.StudyInstanceUID, c.FrameOfReferenceUID} & \
        {d.SOPInstanceUID, d.SeriesInstanceUID, d.StudyInstanceUID, d.FrameOfReferenceUID}


def case_mirrored_lattice():
    """Voxels stored from back to front and from right to left keep their places."""
    labels, affine = write_study()
    turned = affine.copy()
    turned[:3, 3] += affine[:3, 0] * (labels.shape[0] - 1) + affine[:3, 2] * (labels.shape[2] - 1)
    turned[:3, 0], turned[:3, 2] = -affine[:3, 0], -affine[:3, 2]
    nib.save(nib.Nifti1Image(labels[::-1, :, ::-1].copy(), LPS @ turned), "turned.nii.gz")
    run("convert", "turned.nii.gz", "-o", "turned.seg.dcm", "--source", "ct")
    assert not errors_of("turned.seg.dcm")
    assert_masks("turned.seg.dcm", {n: "label_%d" % n for n in (3, 7, 250)}, labels[::-1, :, ::-1], turned)


def contours_of(path):
    """[(points, referenced SOP instance)] by structure's name, and the data set."""
    d = pydicom.dcmread(path)
    names = {r.ROINumber: str(r.ROIName) for r in d.StructureSetROISequence}
    found = {}
    for region in d.ROIContourSequence:
        found[names[region.ReferencedROINumber]] = [
            (np.array(c.ContourData, float).reshape(-1, 3),
             c.ContourImageSequence[0].ReferencedSOPInstanceUID if "ContourImageSequence" in c else None)
            for c in region.ContourSequence]
        for c in region.ContourSequence:
            assert c.ContourGeometricType == "CLOSED_PLANAR" and len(c.ContourData) == 3 * c.NumberOfContourPoints
    return found, d


def drawn(contours, affine, shape):
    """The mask that the contours enclose, each by the even-odd rule at the voxels' centres, together by or: a reader that
    knows nothing of holes."""
    mask = np.zeros(shape, bool)
    inverse = np.linalg.inv(affine)
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    for points, _ in contours:
        v = points @ inverse[:3, :3].T + inverse[:3, 3]
        k = int(np.rint(v[0, 2]))
        assert np.abs(v[:, 2] - k).max() < 1e-3, "points off the slice: %g of a gap" % np.abs(v[:, 2] - k).max()
        mask[:, :, k] |= points_inside(v[:, :2], np.c_[i.ravel(), j.ravel()].astype(float)).reshape(shape[:2])
    return mask


def case_structure_set():
    """Outlines lie on the source's slices, name its images and enclose each label's voxels exactly, with the hollows."""
    labels, affine = write_study()
    run("convert", "labels.nii.gz", "-o", "x.rt.dcm", "--source", "ct", "--names", "3=shell")
    assert not errors_of("x.rt.dcm"), errors_of("x.rt.dcm")
    found, d = contours_of("x.rt.dcm")
    images = sources()
    one = next(iter(images.values()))
    assert set(found) == {"shell", "label_7", "label_250"} and d.Modality == "RTSTRUCT"
    assert d.StudyInstanceUID == one.StudyInstanceUID and d.PatientID == "P 17"
    frame = d.ReferencedFrameOfReferenceSequence[0]
    series = frame.RTReferencedStudySequence[0].RTReferencedSeriesSequence[0]
    assert frame.FrameOfReferenceUID == one.FrameOfReferenceUID and series.SeriesInstanceUID == one.SeriesInstanceUID
    assert {c.ReferencedSOPInstanceUID for c in series.ContourImageSequence} == set(images)
    for label, name in ((3, "shell"), (7, "label_7"), (250, "label_250")):
        assert np.array_equal(drawn(found[name], affine, labels.shape), labels == label), name
        for points, uid in found[name]:
            at, normal = np.array(images[uid].ImagePositionPatient, float), np.cross(OBLIQUE[:3], OBLIQUE[3:])
            assert np.abs((points - at) @ normal).max() < 1e-3


def case_plastimatch():
    """plastimatch draws the same volumes within 1 %, at the same places within half a pixel."""
    if not shutil.which("plastimatch"):
        raise Skip("plastimatch is not installed")
    labels, affine = write_study((1, 0, 0, 0, 1, 0))
    run("convert", "labels.nii.gz", "-o", "x.rt.dcm", "--source", "ct")
    subprocess.run(["plastimatch", "convert", "--input", "x.rt.dcm", "--referenced-ct", "ct", "--output-prefix", "masks",
                    "--prefix-format", "nii"], check=True, capture_output=True, timeout=120)
    for label in (3, 7):
        image = nib.load("masks/label_%d.nii" % label)
        mask = np.asanyarray(image.dataobj) > 0
        own = np.argwhere(mask) @ (LPS @ image.affine)[:3, :3].T + (LPS @ image.affine)[:3, 3]
        true = np.argwhere(labels == label) @ affine[:3, :3].T + affine[:3, 3]
        voxel = abs(np.linalg.det((LPS @ image.affine)[:3, :3]))
        volume, expected = len(own) * voxel, len(true) * abs(np.linalg.det(affine[:3, :3]))
        assert abs(volume / expected - 1) < 0.01, (label, volume, expected)
        assert (np.abs(own.mean(0) - true.mean(0)) < 0.5 * np.array([0.7, 0.9, 2.5])).all(), (own.mean(0), true.mean(0))


def icosphere(radius, middle, rounds=4):
    """Points and triangles of a ball, wound outwards."""
    t = (1 + 5 ** 0.5) / 2
    points = [np.array(p, float) for p in [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t),
                                           (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(rounds):
        middles, finer = {}, []
        for a, b, c in faces:
            between = []
            for e in ((a, b), (b, c), (c, a)):
                key = tuple(sorted(e))
                if key not in middles:
                    middles[key] = len(points)
                    points.append((points[e[0]] + points[e[1]]) / 2)
                between.append(middles[key])
            ab, bc, ca = between
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return np.array([p / np.linalg.norm(p) * radius for p in points]) + middle, faces


def write_obj(path, points, faces):
    with open(path, "w") as file:
        file.writelines("v %.9g %.9g %.9g\n" % tuple(p) for p in points)
        file.writelines("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)


def case_mesh_on_source():
    """A ball as mesh or level set is drawn on the series' slices: every point on the ball within half a pixel, the areas
    those of its sections."""
    radius = 9.0
    affine = affine_of(OBLIQUE)
    middle = affine[:3, :3] @ np.array([24, 20, 5.3]) + affine[:3, 3]
    write_study()
    write_obj("ball.obj", *icosphere(radius, middle))
    run("convert", "ball.obj", "-o", "ball.vdb", "--resolution", 64)
    for source in ("ball.obj", "ball.vdb"):
        run("convert", source, "-o", "ball.rt.dcm", "--source", "ct")
        assert not errors_of("ball.rt.dcm")
        (contours,) = contours_of("ball.rt.dcm")[0].values()
        normal = np.cross(OBLIQUE[:3], OBLIQUE[3:])
        heights = [(affine[:3, 3] + k * affine[:3, 2] - middle) @ normal for k in range(COUNT)]
        assert len(contours) == sum(abs(h) < radius for h in heights), len(contours)
        total = 0
        for points, _ in contours:
            assert np.abs(np.linalg.norm(points - middle, axis=1) - radius).max() < 0.35
            p = points - points.mean(0)
            total += 0.5 * np.linalg.norm(np.cross(p, np.roll(p, -1, 0)).sum(0))
        expected = sum(np.pi * (radius ** 2 - h ** 2) for h in heights if abs(h) < radius)
        # Chords of a circle of some 10 pixels' radius lose less than (1 pixel)^2 / 8 r^2 = .2 % of the area.
        assert abs(total / expected - 1) < 0.01, (source, total, expected)
        run("convert", source, "-o", "ball.seg.dcm", "--source", "ct")
        assert not errors_of("ball.seg.dcm")
        (frames,), d = [list(part.values()) if isinstance(part, dict) else part for part in segment_masks("ball.seg.dcm")]
        x, y = steps_of(d)
        rows, columns = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]), indexing="ij")
        for position, mask in frames:
            distance = np.linalg.norm(position + columns[..., None] * x + rows[..., None] * y - middle, axis=-1) - radius
            # The level set's own voxels are a quarter of a millimetre.
            assert mask[distance < -0.15].all() and not mask[distance > 0.15].any()


def case_other_series():
    """Labels of one series are drawn on the slices of another one, finer and otherwise turned."""
    labels, affine = write_study((1, 0, 0, 0, 1, 0))
    shutil.move("ct", "first")
    other = affine_of(OBLIQUE, FIRST + [0, 2, -4], 1.25)
    write_ct("ct", [other[:3, 3] + k * other[:3, 2] for k in range(24)], (40, 48), SPACING, OBLIQUE)
    run("convert", "labels.nii.gz", "-o", "other.rt.dcm", "--source", "ct")
    found, _ = contours_of("other.rt.dcm")
    volume = 0
    for points, uid in found["label_7"]:
        at, normal = np.array(sources()[uid].ImagePositionPatient, float), np.cross(OBLIQUE[:3], OBLIQUE[3:])
        assert np.abs((points - at) @ normal).max() < 1e-3
        v = (points - affine[:3, 3]) @ np.linalg.inv(affine[:3, :3]).T
        # Each outline's points lie between voxels of the label and others: within a voxel of both.
        near = np.rint(v).astype(int)
        for p in near[::7]:
            low, high = np.clip(p - 1, 0, None), p + 2
            part = labels[low[0]:high[0], low[1]:high[1], low[2]:high[2]] == 7
            assert part.any() and not (part.all() and (p > 0).all() and (p < np.array(labels.shape) - 1).all()), p
        p = points - points[0]
        volume += 0.5 * np.cross(p, np.roll(p, -1, 0)).sum(0) @ normal * 1.25
    assert volume > 0


def read_nrrd(path):
    """Fields and keys of the head, and the values, first axis fastest."""
    head, _, body = open(path, "rb").read().partition(b"\n\n")
    fields, keys = {}, {}
    for line in head.decode().splitlines()[1:]:
        if ":=" in line:
            key, _, value = line.partition(":=")
            keys[key] = value
        elif not line.startswith("#"):
            key, _, value = line.partition(": ")
            fields[key] = value
    kinds = {"uint8": "u1", "uint16": "<u2"}
    sizes = [int(n) for n in fields["sizes"].split()]
    return fields, keys, np.frombuffer(gzip.decompress(body), kinds[fields["type"]]).reshape(sizes, order="F")


def case_slicer_segmentation():
    """.seg.nrrd: labels with name, colour, label, layer and extent, as 3D Slicer's segmentations have them."""
    labels, affine = write_study()
    run("convert", "labels.nii.gz", "-o", "x.seg.nrrd", "--names", "7=Ring: a\\b")
    fields, keys, values = read_nrrd("x.seg.nrrd")
    assert fields["space"] == "left-posterior-superior" and fields["kinds"] == "domain domain domain"
    assert np.array_equal(values, labels)
    for n, label in enumerate((3, 7, 250)):
        at = np.argwhere(labels == label)
        extent = np.c_[at.min(0), at.max(0)].ravel()
        assert keys["Segment%d_Extent" % n] == " ".join(map(str, extent)), keys["Segment%d_Extent" % n]
        assert keys["Segment%d_LabelValue" % n] == str(label) and keys["Segment%d_Layer" % n] == "0"
        assert len([float(c) for c in keys["Segment%d_Color" % n].split()]) == 3 and keys["Segment%d_ID" % n]
    assert keys["Segment1_Name"] == "Ring: a\\\\b"  # NRRD's spelling of one backslash


def case_names_are_carried():
    """Names and colours of the labels of a segmentation or .seg.nrrd go to what is converted and reconstructed of it, unless
    --names says else."""
    labels, affine = write_study()
    run("convert", "labels.nii.gz", "-o", "a.seg.nrrd", "--names", "3=Heart,7=Ring: a,250=Dust")
    colors = {"Heart": (230, 20, 60), "Ring: a": (1, 254, 128), "Dust": (90, 90, 91)}
    # As another program would have coloured them.
    head, _, body = open("a.seg.nrrd", "rb").read().partition(b"\n\n")
    lines = head.decode().splitlines()
    for n, color in enumerate(colors.values()):
        at = next(i for i, line in enumerate(lines) if line.startswith("Segment%d_Color:=" % n))
        lines[at] = "Segment%d_Color:=%s" % (n, " ".join("%.6f" % (c / 255) for c in color))
    open("a.seg.nrrd", "wb").write("\n".join(lines).encode() + b"\n\n" + body)

    def of_nrrd(path):
        keys = read_nrrd(path)[1]
        count = sum(key.endswith("_ID") for key in keys)
        return {keys["Segment%d_Name" % n]: tuple(round(255 * float(c)) for c in keys["Segment%d_Color" % n].split())
                for n in range(count)}

    def of_seg(path):
        return {s.SegmentLabel: list(s.RecommendedDisplayCIELabValue) for s in pydicom.dcmread(path).SegmentSequence}

    def of_set(path):
        d = pydicom.dcmread(path)
        shown = {c.ReferencedROINumber: tuple(map(int, c.ROIDisplayColor)) for c in d.ROIContourSequence}
        return {s.ROIName: shown[s.ROINumber] for s in d.StructureSetROISequence}

    run("convert", "a.seg.nrrd", "-o", "b.seg.nrrd"), run("convert", "a.seg.nrrd", "-o", "b.rt.dcm"), run("convert", "a.seg.nrrd", "-o", "b.seg.dcm")
    assert of_nrrd("b.seg.nrrd") == colors and of_set("b.rt.dcm") == {**colors}, (of_nrrd("b.seg.nrrd"), of_set("b.rt.dcm"))
    assert set(of_seg("b.seg.dcm")) == set(colors)
    # From DICOM: skimage's CIELab of white D50 is the oracle of the colours.
    try:
        from skimage.color import lab2rgb
        for name, stored in of_seg("b.seg.dcm").items():
            lab = np.array([stored[0] / 65535 * 100, stored[1] / 65535 * 255 - 128, stored[2] / 65535 * 255 - 128])
            assert np.abs(255 * lab2rgb(lab[None, None], illuminant="D50")[0, 0] - colors[name]).max() < 30, (name, lab)
    except ImportError:
        pass
    run("convert", "b.seg.dcm", "-o", "c.seg.nrrd"), run("convert", "b.seg.dcm", "-o", "c.rt.dcm"), run("convert", "b.seg.dcm", "-o", "c.seg.dcm")
    assert of_nrrd("c.seg.nrrd") == colors and of_set("c.rt.dcm") == colors and of_seg("c.seg.dcm") == of_seg("b.seg.dcm")
    run("convert", "b.seg.dcm", "-o", "d.seg.nrrd", "--names", "2=Other")
    assert of_nrrd("d.seg.nrrd") == {name.replace("Ring: a", "Other"): color for name, color in colors.items()}
    # One segment alone, and slices filled in.
    run("convert", "b.seg.dcm:@Heart", "-o", "e.seg.nrrd")
    assert of_nrrd("e.seg.nrrd") == {"Heart": colors["Heart"]}
    run("reconstruct", "b.seg.dcm", "-o", "f.seg.dcm", "--between", 1), run("reconstruct", "a.seg.nrrd", "-o", "f.rt.dcm", "--between", 1)
    assert of_seg("f.seg.dcm") == of_seg("b.seg.dcm") and of_set("f.rt.dcm") == colors
    # A later layer has names of its own.
    dcm_labels = np.stack([labels == 3, labels == 7]).astype("u1")
    head = [line for line in lines if not line.startswith(("Segment", "type", "dimension", "sizes", "kinds", "space directions"))]
    directions = next(line for line in lines if line.startswith("space directions")).split(":")[1]
    head[1:1] = ["type: uint8", "dimension: 4", "sizes: 2 %d %d %d" % labels.shape, "kinds: list domain domain domain"]
    head += ["space directions: none" + directions]
    for n, name in enumerate(("One", "Two")):
        head += ["Segment%d_ID:=s%d" % (n, n), "Segment%d_LabelValue:=1" % n, "Segment%d_Layer:=%d" % (n, n), "Segment%d_Name:=%s" % (n, name)]
    open("layers.seg.nrrd", "wb").write("\n".join(head).encode() + b"\n\n" + gzip.compress(dcm_labels.tobytes(order="F")))
    for n, name in enumerate(("One", "Two")):
        run("convert", "layers.seg.nrrd:%d" % n, "-o", "g.seg.nrrd")
        assert set(of_nrrd("g.seg.nrrd")) == {name} and np.array_equal(read_nrrd("g.seg.nrrd")[2], dcm_labels[n]), name


def case_names_in_character_sets():
    """Names of regions in the file's own character set, as pydicom writes them, are UTF-8 here and in what is written."""
    write_study()
    run("convert", "labels.nii.gz", "-o", "x.rt.dcm", "--source", "ct", "--names", "3=shell")
    for characters, name in (("ISO_IR 100", "Hörgänge"), ("ISO_IR 101", "Wątroba"), ("ISO_IR 144", "Печень"), ("ISO_IR 192", "肝臓")):
        d = pydicom.dcmread("x.rt.dcm")
        d.SpecificCharacterSet, d.StructureSetROISequence[0].ROIName = characters, name
        d.save_as("y.dcm")
        assert name in [s["name"] for s in json.loads(run("info", "y.dcm", "--json").stdout)["structures"]], characters
        run("reconstruct", "y.dcm:" + name, "-o", "y.seg.dcm", "--source", "ct")
        assert [s.SegmentLabel for s in pydicom.dcmread("y.seg.dcm").SegmentSequence] == [name], characters


def case_layers_not_told():
    """Segments of a .seg.nrrd with labels but no layers are of the one layer that there is."""
    labels, _ = write_study()
    run("convert", "labels.nii.gz", "-o", "a.seg.nrrd", "--names", "3=Heart,7=Ring,250=Dust")
    data = open("a.seg.nrrd", "rb").read()
    head, _, body = data.partition(b"\n\n")
    lines = [line for line in head.split(b"\n") if b"_Layer:=" not in line]
    assert len(lines) == head.count(b"\n") + 1 - 3
    open("b.seg.nrrd", "wb").write(b"\n".join(lines) + b"\n\n" + body)
    run("convert", "b.seg.nrrd", "-o", "c.seg.dcm")
    assert {s.SegmentLabel for s in pydicom.dcmread("c.seg.dcm").SegmentSequence} == {"Heart", "Ring", "Dust"}


def case_turning_source():
    """--force takes a source whose slices turn a little on their way, as its refusal says."""
    write_study((1, 0, 0, 0, 1, 0))
    for n, path in enumerate(sorted(glob.glob("ct/*.dcm"))):
        if n >= 6:
            d = pydicom.dcmread(path)
            a = np.radians(2)
            d.ImageOrientationPatient = ["%.10g" % v for v in (np.cos(a), np.sin(a), 0, -np.sin(a), np.cos(a), 0)]
            d.save_as(path)
    for output in ("x.rt.dcm", "x.seg.dcm"):
        refused("convert", "labels.nii.gz", "-o", output, "--source", "ct", says=["ct", "--force"])
        said = run("convert", "labels.nii.gz", "-o", output, "--source", "ct", "--force").stderr
        assert "--force: the directions" in said and "2 degrees" in said, said
        assert not errors_of(output), errors_of(output)


def case_space_of_contours():
    """A map of contours on the voxels of --like is in the space of its code."""
    labels, affine = write_study()
    like = nib.Nifti1Image(labels, LPS @ affine)
    like.set_sform(LPS @ affine, 4), like.set_qform(LPS @ affine, 2)
    nib.save(like, "like.nii")
    run("convert", "labels.nii.gz", "-o", "x.rt.dcm", "--source", "ct")
    run("reconstruct", "x.rt.dcm", "-o", "y.nii", "--like", "like.nii"), run("reconstruct", "x.rt.dcm", "-o", "m.#.nii", "--like", "like.nii")
    for name in ("y.nii", "m.3.nii"):
        header = nib.load(name).header
        assert (int(header["sform_code"]), int(header["qform_code"])) == (4, 2), (name, header)


def case_frames_of_one_type():
    """All frames of a morph of label maps into a file each have one type, that of the inputs."""
    labels, affine = write_study()
    wide = np.where(labels == 250, 9, labels).astype(np.int16)
    nib.save(nib.Nifti1Image(wide, LPS @ affine), "wide.nii"), nib.save(nib.Nifti1Image(np.roll(wide, 2, 1), LPS @ affine), "later.nii")
    run("morph", "wide.nii", "later.nii", "--align", "none", "--like", "wide.nii", "--frames", 3, "-o", "m.#.nii")
    assert [nib.load("m.%d.nii" % n).get_data_dtype() for n in (1, 2, 3)] == [np.int16] * 3
    # Grey scans of unlike types: the type that holds both, in one file as in several.
    grey = np.where(labels > 0, 700, 20) + labels
    nib.save(nib.Nifti1Image(grey.astype(np.int16), LPS @ affine), "int.nii"), nib.save(nib.Nifti1Image(grey * np.float32(1.5), LPS @ affine), "float.nii")
    for output in ("g.#.nii", "g.nii"):
        run("morph", "int.nii", "float.nii", "--align", "none", "--image", "grey", "--like", "int.nii", "--frames", 3, "-o", output)
    assert [nib.load(name).get_data_dtype() for name in ("g.1.nii", "g.2.nii", "g.3.nii", "g.nii")] == [np.float64] * 4
    assert np.array_equal(np.asanyarray(nib.load("g.1.nii").dataobj), grey)


def case_overlaps_are_kept():
    """Structures that overlap stay whole: in a segmentation, and in layers of .seg.nrrd."""
    box = lambda x, y, size: [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]
    with open("two.csl", "w") as file:
        pass
    write_ct("ct", [(0, 0, 2.0 * k) for k in range(10)], (40, 40), (1, 1))
    d = pydicom.dcmread("ct/000.dcm")
    structures = {"outer": box(5.5, 5.5, 20), "inner": box(10.5, 10.5, 8)}
    from pydicom.dataset import Dataset
    from pydicom.sequence import Sequence
    d.SOPClassUID = d.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.481.3"
    d.Modality = "RTSTRUCT"
    del d.PixelData
    regions, contours, observations = [], [], []
    for n, (name, points) in enumerate(structures.items(), 1):
        region, contour, observation = Dataset(), Dataset(), Dataset()
        region.ROINumber, region.ROIName, region.ReferencedFrameOfReferenceUID = n, name, d.FrameOfReferenceUID
        contour.ReferencedROINumber, items = n, []
        for k in range(2, 8):
            item = Dataset()
            item.ContourGeometricType, item.NumberOfContourPoints = "CLOSED_PLANAR", 4
            item.ContourData = ["%g" % v for p in points for v in (*p, 2.0 * k)]
            items.append(item)
        contour.ContourSequence = Sequence(items)
        observation.ObservationNumber, observation.ReferencedROINumber = n, n
        regions.append(region), contours.append(contour), observations.append(observation)
    d.StructureSetROISequence, d.ROIContourSequence = Sequence(regions), Sequence(contours)
    d.RTROIObservationsSequence, d.ApprovalStatus = Sequence(observations), "UNAPPROVED"
    d.save_as("two.dcm")
    for extra in ((), ("--source", "ct")):
        run("reconstruct", "two.dcm", "-o", "two.seg.dcm", *extra)
        assert not errors_of("two.seg.dcm")
        masks, seg = segment_masks("two.seg.dcm")
        x, y = steps_of(seg)
        rows, columns = np.meshgrid(np.arange(seg.Rows), np.arange(seg.Columns), indexing="ij")
        for name, points in structures.items():
            for position, mask in masks[name]:
                if not 4 <= position[2] <= 14:
                    continue
                place = position + columns[..., None] * x + rows[..., None] * y
                low, high = np.array(points).min(0), np.array(points).max(0)
                depth = np.minimum(place[..., :2] - low, high - place[..., :2]).min(-1)
                # Half of a pixel around the outline, and its rounded corners, may be either.
                assert mask[depth > 0.8].all() and not mask[depth < -0.8].any(), name
    run("reconstruct", "two.dcm", "-o", "two.seg.nrrd", "--source", "ct")
    fields, keys, values = read_nrrd("two.seg.nrrd")
    assert fields["kinds"] == "list domain domain domain" and values.shape == (2, 40, 40, 10), values.shape
    assert [keys["Segment%d_Layer" % n] for n in (0, 1)] == ["0", "1"]
    assert (values[0, 12:16, 12:16, 4] == 1).all() and (values[1, 12:16, 12:16, 4] == 2).all()


def case_reconstruct_labels():
    """A label map with empty slices becomes a dense segmentation of the same names' structures."""
    labels, affine = write_study()
    sparse = labels.copy()
    sparse[:, :, 1::2] = 0
    nib.save(nib.Nifti1Image(sparse, LPS @ affine), "sparse.nii.gz")
    run("reconstruct", "sparse.nii.gz", "-o", "dense.nii.gz", "--every", 2)
    dense = np.asanyarray(nib.load("dense.nii.gz").dataobj)
    run("reconstruct", "sparse.nii.gz", "-o", "dense.seg.dcm", "--every", 2, "--source", "ct")
    assert not errors_of("dense.seg.dcm")
    assert_masks("dense.seg.dcm", {n: "label_%d" % n for n in np.unique(dense) if n}, dense, affine)


def stl_points(path):
    raw = open(path, "rb").read()
    count = struct.unpack("<I", raw[80:84])[0]
    facets = np.frombuffer(raw[84:], np.dtype([("n", "<f4", 3), ("p", "<f4", (3, 3)), ("a", "<u2")]), count)
    return raw[:80], facets["p"].reshape(-1, 3)


def ply_points(path):
    head, _, body = open(path, "rb").read().partition(b"end_header\n")
    count = int([line for line in head.split(b"\n") if line.startswith(b"element vertex")][0].split()[-1])
    return head, np.frombuffer(body, "<f4", 3 * count).reshape(-1, 3)


def obj_points(path):
    text = open(path).read()
    return text.splitlines()[0].encode(), np.array([line.split()[1:4] for line in text.splitlines() if line.startswith("v ")], float)


def vtp_points(path):
    """Points of VTK XML PolyData with appended raw data (VTK's file formats, XML), and its field SPACE."""
    raw = open(path, "rb").read()
    head, _, body = raw.partition(b'<AppendedData encoding="raw">\n_')
    root = ElementTree.fromstring(head + b"</VTKFile>")
    assert root.get("type") == "PolyData" and root.get("header_type") == "UInt64"

    def block(array, kind):
        at = int(array.get("offset"))
        size = struct.unpack("<Q", body[at:at + 8])[0]
        return np.frombuffer(body[at + 8:at + 8 + size], kind)

    piece = root.find("PolyData/Piece")
    polys = {a.get("Name"): block(a, "<i8") for a in piece.findall("Polys/DataArray")}
    points = block(piece.find("Points/DataArray"), "<f4").reshape(-1, 3)
    triangles = polys["connectivity"].reshape(-1, 3)
    assert len(points) == int(piece.get("NumberOfPoints")) and len(triangles) == int(piece.get("NumberOfPolys"))
    assert np.array_equal(polys["offsets"], 3 * np.arange(1, len(triangles) + 1)) and triangles.max() < len(points)
    field = root.find("PolyData/FieldData/Array")
    said = bytes(int(c) for c in field.text.split() if int(c)) if field is not None else b""
    # The volume is positive: triangles are counter-clockwise seen from outside.
    a, b, c = (points[triangles[:, n]].astype(float) for n in range(3))
    assert np.einsum("ij,ij", a, np.cross(b, c)) > 0
    return b"SPACE=" + said if said else b"", points


def case_space_of_meshes():
    """Meshes of scans say that they are in LPS, and lie there; --space RAS turns them and says so; other meshes say nothing."""
    labels, affine = write_study()
    labels[labels == 250] = 0  # single voxels are no surface at every voxel size
    nib.save(nib.Nifti1Image(labels, LPS @ affine), "labels.nii.gz")
    readers = {"stl": stl_points, "ply": ply_points, "obj": obj_points, "vtp": vtp_points}
    write_obj("ball.obj", *icosphere(5, np.array([20, -7, 3])))
    true = np.argwhere(labels > 0) @ affine[:3, :3].T + affine[:3, 3]
    middle = (true.min(0) + true.max(0)) / 2
    for extension, points_of in readers.items():
        said, points = points_of(run("convert", "labels.nii.gz", "-o", "l." + extension) and "l." + extension)
        assert b"SPACE=LPS" in said, said
        # Surfaces run half way between voxels.
        assert (np.abs((points.min(0) + points.max(0)) / 2 - middle) < 1.3).all(), (extension, points.min(0), points.max(0))
        said, turned = points_of(run("convert", "labels.nii.gz", "-o", "r." + extension, "--space", "RAS") and "r." + extension)
        assert b"SPACE=RAS" in said and np.allclose(turned, points * [-1, -1, 1]), extension
        said, points = points_of(run("convert", "ball.obj", "-o", "b." + extension, "--resolution", 32) and "b." + extension)
        assert b"SPACE" not in said and np.abs((points.min(0) + points.max(0)) / 2 - [20, -7, 3]).max() < 0.2
    run("reconstruct", "labels.nii.gz", "-o", "x.####.stl", "--between", 1)
    assert b"SPACE=LPS" in stl_points("x.0003.stl")[0]
    refused("convert", "labels.nii.gz", "-o", "x.nii.gz", "--space", "RAS", says=["--space RAS", ".stl"])


def case_volumes_in_time():
    """A morph of images into one NIfTI file: its volumes are the frames, on their voxels, with the time from one to the next."""
    labels, affine = write_study()
    nib.save(nib.Nifti1Image(np.roll(labels, 2, 1), LPS @ affine), "later.nii.gz")
    pair = ("morph", "labels.nii.gz", "later.nii.gz", "--align", "none", "--like", "labels.nii.gz", "--fps", 4, "--frames", 3)
    run(*pair, "-o", "one.nii.gz")
    run(*pair, "-o", "each.#.nii.gz")
    image = nib.load("one.nii.gz")
    assert image.shape == (*labels.shape, 3) and np.allclose(image.affine, LPS @ affine, atol=1e-4)
    assert image.header.get_zooms()[3] == 0.25 and image.header.get_xyzt_units() == ("mm", "sec")
    for n in range(3):
        assert np.array_equal(np.asanyarray(image.dataobj)[..., n], np.asanyarray(nib.load("each.%d.nii.gz" % (n + 1)).dataobj)), n
    run(*pair, "-o", "part.nii", "--range", "2-3")
    assert np.array_equal(np.asanyarray(nib.load("part.nii").dataobj), np.asanyarray(image.dataobj)[..., 1:])
    run("convert", "one.nii.gz:2", "-o", "last.nii")
    assert np.array_equal(np.asanyarray(nib.load("last.nii").dataobj), np.asanyarray(image.dataobj)[..., 2])


def case_volumes_of_one_type():
    """Frames of one file have the type of the inputs, also where labels would fit a smaller one; other types and voxels in one
    file are refused."""
    labels, affine = write_study()
    wide = np.where(labels == 250, 9, labels).astype(np.int16)
    nib.save(nib.Nifti1Image(wide, LPS @ affine), "wide.nii"), nib.save(nib.Nifti1Image(np.roll(wide, 2, 1), LPS @ affine), "later.nii")
    run("morph", "wide.nii", "later.nii", "--align", "none", "--like", "wide.nii", "--frames", 3, "-o", "one.nii")
    image = nib.load("one.nii")
    assert image.get_data_dtype() == np.int16 and image.shape == (*labels.shape, 3)
    found = np.asanyarray(image.dataobj)
    assert np.array_equal(found[..., 0], wide) and set(np.unique(found)) <= set(np.unique(wide))
    # Float labels are as many structures as whole ones.
    nib.save(nib.Nifti1Image((labels - 0.0005 * (labels > 0)).astype(np.float32), LPS @ affine), "float.nii")
    run("convert", "float.nii", "-o", "float.seg.dcm"), run("convert", "labels.nii.gz", "-o", "whole.seg.dcm")
    one, other = segment_masks("float.seg.dcm")[0], segment_masks("whole.seg.dcm")[0]
    assert len(one) == 3 and one.keys() == other.keys()
    for name in one:
        assert all(np.array_equal(a, b) for (_, a), (_, b) in zip(one[name], other[name])) and len(one[name]) == len(other[name])
    refused("convert", "labels.nii.gz", "-o", "x.nii", "--names", "3=Heart", says=["--names", ".seg.dcm"])


def case_info_of_structures():
    """`info` tells structures' names, numbers, planes and volumes, as slabs between the planes."""
    labels, affine = write_study()
    run("convert", "labels.nii.gz", "-o", "x.rt.dcm", "--source", "ct", "--names", "3=shell")
    found = {s["name"]: s for s in json.loads(run("info", "x.rt.dcm", "--json").stdout)["structures"]}
    contours, _ = contours_of("x.rt.dcm")
    normal = np.cross(OBLIQUE[:3], OBLIQUE[3:])
    assert set(found) == set(contours)
    for label, name in ((3, "shell"), (7, "label_7")):
        one = found[name]
        planes = len(np.unique(np.argwhere(labels == label)[:, 2]))
        assert (one["number"], one["planes"], one["contours"]) == (label, planes, len(contours[name])), one
        area = sum(0.5 * np.cross(p - p[0], np.roll(p - p[0], -1, 0)).sum(0) @ normal for p, _ in contours[name])
        # Coordinates are written to 1e-4 mm.
        assert abs(one["volumeMl"] / (area * GAP / 1000) - 1) < 1e-3, one
        assert abs(one["gapMm"]["usual"] - GAP) < 1e-3
    assert "shell" in run("info", "x.rt.dcm").stdout
    with open("box.csl", "w") as file:
        file.write("CSLC\n3 2\n")
        for n, z in enumerate((0, 2, 5), 1):
            file.write("%d 4 1 0 0 1 %g\n0 0 %g\n10 0 %g\n10 20 %g\n0 20 %g\n4 1 0 1 2 3\n" % (n, -z, z, z, z, z))
    box = json.loads(run("info", "box.csl", "--json").stdout)["structures"]
    # The slabs: half a usual gap (3: the middle one of 2 and 3, the larger) beyond the outermost planes.
    assert len(box) == 1 and box[0]["planes"] == 3 and abs(box[0]["volumeMl"] - 0.2 * (5 + 3)) < 1e-6, box


def case_approval():
    """The approval of structures is optional, and not yet given mostly: only a rejection is a warning."""
    write_study()
    run("convert", "labels.nii.gz", "-o", "x.rt.dcm", "--source", "ct")
    d = pydicom.dcmread("x.rt.dcm")
    for status in (None, "APPROVED", "UNAPPROVED", "REJECTED"):
        if "ApprovalStatus" in d:
            del d.ApprovalStatus
        if status:
            d.ApprovalStatus = status
        d.save_as("y.dcm")
        for options in ((), ("--verbose",)):
            said = run("reconstruct", "y.dcm:label_3", "-o", "y.ply", *options).stderr
            assert ("warning" in said) == (status == "REJECTED"), (status, said)
            assert ("REJECTED" in said) == (status == "REJECTED") and ("UNAPPROVED" in said) == (status == "UNAPPROVED" and bool(options)), (status, said)


def case_refused():
    """Wrong sources and names are said as such."""
    write_study()
    away = affine_of((1, 0, 0, 0, 1, 0), FIRST + [500, 0, 0])
    write_ct("away", [away[:3, 3] + k * away[:3, 2] for k in range(COUNT)], SIZE, SPACING)
    refused("convert", "labels.nii.gz", "-o", "x.seg.dcm", "--source", "away", says=["--source away", "elsewhere"])
    refused("convert", "labels.nii.gz", "-o", "x.seg.dcm", "--source", "labels.nii.gz", says=["--source", "no DICOM series"])
    refused("convert", "labels.nii.gz", "-o", "x.seg.dcm", "--names", "4=four", says=["--names", "3, 7, 250"])
    refused("convert", "labels.nii.gz", "-o", "x.seg.dcm", "--names", "four", says=["NUMBER=NAME"])
    refused("reconstruct", "labels.nii.gz", "-o", "x.####.seg.dcm", "--between", 1, says=["####", "one file"])
    refused("morph", "labels.nii.gz", "labels.nii.gz", "-o", "x.seg.dcm", "--at", 0.5, says=["x.seg.dcm", "convert"])
    refused("convert", "labels.nii.gz", "-o", "x.dcm", says=[".seg.dcm", ".rt.dcm"])
    assert not [name for name in os.listdir(".") if name.startswith("x.")]


sys.exit(run_within(globals(), ONLY))
