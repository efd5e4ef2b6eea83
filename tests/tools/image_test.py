#!/usr/bin/env python3
"""Medical images through the program, against nibabel, pydicom and pyopenvdb.

usage: image_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-nibabel, python3-pydicom, python3-openvdb; cases that read ../shared/data/medical are
skipped, with a message, where it does not exist. Positions are LPS millimetres; nibabel's are RAS.
"""
import gzip
import json
import math
import os
import shutil
import subprocess
import sys
import zlib

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
import pydicom
import pyopenvdb as vdb
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data/medical")
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])


def data(name):
    path = os.path.join(DATA, name)
    if not os.path.exists(path):
        raise Skip(name + " is not there")
    return path


program = Program(sys.argv[1])
run = program.run
refused = program.refused


def lps(path):
    """Values and LPS affine of a NIfTI file."""
    image = nib.load(path)
    return np.asanyarray(image.dataobj), LPS @ image.affine


def at_points(values, affine, points):
    """Nearest voxel's value at world points, and how far its centre is; -1 index where outside."""
    v = (np.linalg.inv(affine) @ np.c_[points, np.ones(len(points))].T).T[:, :3]
    i = np.rint(v).astype(int)
    inside = ((i >= 0) & (i < values.shape)).all(1)
    return inside, values[tuple(np.clip(i, 0, np.array(values.shape) - 1).T)], np.abs(v - i).max(1)


def save_nifti(name, values, affine_lps, **header):
    image = nib.Nifti1Image(values, LPS @ affine_lps)
    for key, value in header.items():
        image.header[key] = value
    nib.save(image, name)


def write_slice(path, pixels, position, *, uid, orientation=(1, 0, 0, 0, 1, 0), spacing=(1, 1), number=1, slope=1, intercept=-1024,
                series="1"):
    """One CT slice; spacing as DICOM has it: between rows, between columns."""
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = CTImageStorage
    meta.MediaStorageSOPInstanceUID = generate_uid()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, False
    d.SOPClassUID, d.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
    d.StudyInstanceUID, d.SeriesInstanceUID, d.FrameOfReferenceUID = "1.2.3", uid, "1.2.3.4"
    d.Modality, d.SeriesNumber, d.InstanceNumber, d.SeriesDescription = "CT", series, str(number), "phantom"
    d.PatientName, d.PatientID = "none", "none"
    d.ImagePositionPatient = ["%.10g" % v for v in position]
    d.ImageOrientationPatient = ["%.10g" % v for v in orientation]
    d.PixelSpacing = ["%.10g" % v for v in spacing]
    d.SliceThickness = "1"
    d.Rows, d.Columns = pixels.shape
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.BitsAllocated = d.BitsStored = 16
    d.HighBit, d.PixelRepresentation = 15, 0
    d.RescaleSlope, d.RescaleIntercept = str(slope), str(intercept)
    d.PixelData = pixels.astype("<u2").tobytes()
    d.save_as(path)


def ramp(p):
    """HU that are linear in space: linear interpolation of them is exact."""
    return 40 + 3 * p[..., 0] - 2 * p[..., 1] + 5 * p[..., 2]


def write_series(folder, positions, size=(12, 16), spacing=(1.5, 0.75), orientation=(1, 0, 0, 0, 1, 0), uid="1.2.3.9", value=ramp,
                 order=None):
    """Slices of `value` (HU, a function of LPS positions) with their first pixels at `positions`."""
    os.makedirs(folder, exist_ok=True)
    x, y = np.array(orientation[:3]), np.array(orientation[3:])
    rows, columns = np.meshgrid(np.arange(size[0]), np.arange(size[1]), indexing="ij")
    for n, position in enumerate(positions):
        world = np.asarray(position) + columns[..., None] * x * spacing[1] + rows[..., None] * y * spacing[0]
        name = "%03d.dcm" % (n if order is None else order[n])
        write_slice(os.path.join(folder, name), np.rint(value(world)) + 1024, position, uid=uid, orientation=orientation,
                    spacing=spacing, number=n + 1)


# ---------------------------------------------------------------------------------------------------------------------

def case_orientation():
    """One image stored in four orders: the same values at the same positions, in different layouts."""
    data("orientation")
    images = {}
    for name in ("RAS", "LPS", "ASL", "PIR"):
        run("convert", data("orientation/%s.nii.gz" % name), "-o", name + ".nii.gz")
        images[name] = lps(name + ".nii.gz")
        own, affine = lps(data("orientation/%s.nii.gz" % name))
        assert np.array_equal(images[name][1], affine), name
        assert np.abs(images[name][0] - own).max() <= 1e-5 * own.max(), name  # float against float64
        run("convert", data("orientation/%s.nii.gz" % name), "-o", name + ".vdb")
        grid = vdb.read(name + ".vdb", "image")
        for i in ((0, 0, 0), (3, 5, 7), tuple(n - 1 for n in own.shape)):
            assert abs(grid.getConstAccessor().getValue(i) - own[i]) <= 1e-5 * own.max(), (name, i)
            assert np.allclose(grid.transform.indexToWorld(i), (affine @ [*i, 1])[:3], atol=1e-4), (name, i)
    values, affine = images["RAS"]
    index = np.stack(np.meshgrid(*[np.arange(n) for n in values.shape], indexing="ij"), -1).reshape(-1, 3)
    points = (affine @ np.c_[index, np.ones(len(index))].T).T[:, :3]
    for name in ("LPS", "ASL", "PIR"):
        inside, found, off = at_points(*images[name], points)
        assert inside.all() and off.max() < 1e-3, (name, off.max())
        assert np.array_equal(found, values.reshape(-1)), name


def case_chest_ct():
    """Slice order, HU and geometry of a CT agree with pydicom at a thousand points."""
    folder = data("dicom_chest_ct")
    result = run("convert", folder, "-o", "ct.nii.gz")
    values, affine = lps("ct.nii.gz")
    assert values.dtype == np.int16 and values.shape == (512, 512, 24), (values.dtype, values.shape)
    slices = [pydicom.dcmread(os.path.join(folder, f)) for f in os.listdir(folder)]
    random = np.random.RandomState(5)
    for _ in range(1000):
        d = slices[random.randint(len(slices))]
        r, c = random.randint(d.Rows), random.randint(d.Columns)
        o = np.array(d.ImageOrientationPatient, float)
        point = np.array(d.ImagePositionPatient, float) + o[:3] * float(d.PixelSpacing[1]) * c + o[3:] * float(d.PixelSpacing[0]) * r
        inside, found, off = at_points(values, affine, point[None])
        assert inside[0] and off[0] < 1e-3, (point, off)
        assert found[0] == d.pixel_array[r, c] * float(d.RescaleSlope) + float(d.RescaleIntercept)
    # A series with flipped axes, 17 slices.
    run("convert", data("dicom_small_ct"), "-o", "small.nii.gz")
    values, affine = lps("small.nii.gz")
    for f in sorted(os.listdir(data("dicom_small_ct"))):
        d = pydicom.dcmread(os.path.join(data("dicom_small_ct"), f))
        o = np.array(d.ImageOrientationPatient, float)
        point = np.array(d.ImagePositionPatient, float) + o[:3] * float(d.PixelSpacing[1]) * 20 + o[3:] * float(d.PixelSpacing[0]) * 50
        inside, found, off = at_points(values, affine, point[None])
        assert inside[0] and off[0] < 1e-3 and found[0] == d.pixel_array[50, 20] * float(d.RescaleSlope) + float(d.RescaleIntercept), f


def case_round_trip():
    """NIfTI -> VDB -> NIfTI, NRRD, MetaImage and back: values, types and affines to the last bit."""
    random = np.random.RandomState(1)
    affine = np.array([[0.7, 0.1, 0.02, -81.3], [-0.11, 0.8, 0.3, 12.7], [0.03, -0.2, 2.5, 1000.9], [0, 0, 0, 1]])
    for dtype in (np.uint8, np.int16, np.uint16, np.int32, np.float32, np.float64):
        whole = np.issubdtype(dtype, np.integer)
        top = min(np.iinfo(dtype).max, 60000) if whole else 1
        low = 0 if not whole or np.iinfo(dtype).min == 0 else -5000
        values = random.randint(low, top, (9, 12, 11)).astype(dtype) if whole else random.randn(9, 12, 11).astype(dtype)
        save_nifti("in.nii", values, affine)
        stored = nib.load("in.nii").affine
        # From each to the next, so that a loss anywhere is seen in what comes back.
        way = ["in.nii", "way.vdb", "way.nrrd", "way.mha", "way.nii", "back.nii.gz"]
        for source, target in zip(way, way[1:]):
            run("convert", source, "-o", target, "--image", "grey")
        back = nib.load("back.nii.gz")
        assert back.get_data_dtype() == dtype, (dtype, back.get_data_dtype())
        assert np.array_equal(np.asanyarray(back.dataobj), values), dtype
        assert np.array_equal(back.affine, stored), (dtype, back.affine - stored)
    labels = np.zeros((8, 9, 10), np.uint16)
    labels[2:5, 3:6, 4:8], labels[5:7, 3:6, 4:8] = 7, 60001
    save_nifti("labels.nii.gz", labels, affine)
    run("convert", "labels.nii.gz", "-o", "labels.vdb")
    assert subprocess.run(["vdb_print", "labels.vdb"], capture_output=True, text=True).stdout.count("int32") == 1
    run("convert", "labels.vdb", "-o", "back.nii.gz")
    assert np.array_equal(np.asanyarray(nib.load("back.nii.gz").dataobj), labels)
    # The writers, by readers that are not ours.
    run("convert", "in.nii", "-o", "x.nrrd")
    head, body = open("x.nrrd", "rb").read().split(b"\n\n", 1)
    fields = dict(l.split(": ", 1) for l in head.decode().splitlines() if ": " in l)
    assert fields["space"] == "left-posterior-superior" and fields["type"] == "double"
    assert np.array_equal(np.frombuffer(gzip.decompress(body), "<f8").reshape(values.shape, order="F"), values)
    directions = np.array([[float(v) for v in t.strip("()").split(",")] for t in fields["space directions"].split()]).T
    assert np.allclose(directions, (LPS @ stored)[:3, :3], atol=1e-12)
    run("convert", "in.nii", "-o", "x.mha")
    raw = open("x.mha", "rb").read()
    head, body = raw.split(b"ElementDataFile = LOCAL\n", 1)
    fields = dict(l.split(" = ", 1) for l in head.decode().splitlines())
    assert np.array_equal(np.frombuffer(zlib.decompress(body), "<f8").reshape(values.shape, order="F"), values)
    assert np.allclose([float(v) for v in fields["Offset"].split()], (LPS @ stored)[:3, 3], atol=1e-9)


def case_gantry_tilt():
    """Slices of a gantry tilted by 17 degrees are straightened, exactly for values linear in space."""
    tilt = np.radians(17)
    orientation = (1, 0, 0, 0, np.cos(tilt), np.sin(tilt))
    positions = [(-5, 8, -30 + 2.5 * n) for n in range(9)]
    order = np.random.RandomState(2).permutation(9)
    write_series("tilt", positions, orientation=orientation, order=order)
    result = run("convert", "tilt", "-o", "tilt.nii")
    assert "17 degrees" in result.stderr, result.stderr
    values, affine = lps("tilt.nii")
    axes = affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0)
    assert np.abs(axes.T @ axes - np.eye(3)).max() < 1e-5, axes
    index = np.stack(np.meshgrid(*[np.arange(n) for n in values.shape], indexing="ij"), -1)
    world = (index @ affine[:3, :3].T) + affine[:3, 3]
    # At least one pixel inside a slice, where nothing is missing. HU are whole numbers: half of one.
    local = (world - np.array(positions[0])) @ np.array([orientation[:3], orientation[3:]]).T / [0.75, 1.5]
    step = 2.5 * np.sin(tilt) / 1.5
    column, row = local[..., 0], local[..., 1] - index[..., 2] * step
    inside = (column > -0.1) & (column < 15.1) & (row >= 0) & (row <= 11)
    assert inside.mean() > 0.6
    assert np.abs(values - ramp(world))[inside].max() <= 1.001, np.abs(values - ramp(world))[inside].max()


def case_missing_slices():
    """Missing slices and uneven gaps are noted and interpolated; duplicates are dropped or refused."""
    def positions(zs):
        return [(-4, 3, z) for z in zs]
    write_series("whole", positions([10, 12, 14, 16, 18, 20, 22]))
    assert "missing" not in run("convert", "whole", "-o", "whole.nii").stderr
    whole, affine = lps("whole.nii")
    write_series("gap", positions([10, 12, 16, 18, 20, 22]))
    assert "1 slice is missing" in run("convert", "gap", "-o", "gap.nii").stderr
    values, gap_affine = lps("gap.nii")
    assert np.array_equal(values, whole) and np.allclose(affine, gap_affine)  # linear in space, so linear filling is exact
    write_series("uneven", positions([10, 12, 14.5, 16, 18.25, 20, 22]))
    assert "uneven" in run("convert", "uneven", "-o", "uneven.nii").stderr
    values, uneven_affine = lps("uneven.nii")
    index = np.stack(np.meshgrid(*[np.arange(n) for n in values.shape], indexing="ij"), -1)
    world = (index @ uneven_affine[:3, :3].T) + uneven_affine[:3, 3]
    assert np.abs(values - ramp(world)).max() <= 1.001  # both slices and result are whole HU
    write_series("double", positions([10, 12, 14, 16]))
    shutil.copy("double/001.dcm", "double/9.dcm")
    assert "double" in run("convert", "double", "-o", "double.nii").stderr
    assert lps("double.nii")[0].shape[2] == 4
    write_series("mixed", positions([10, 12, 14, 16]))
    write_series("mixed", positions([12]), value=lambda p: ramp(p) + 50, order=[77])
    refused("convert", "mixed", "-o", "mixed.nii", says=["077.dcm", "same place"])


def case_two_series():
    """Two series in a folder: listed, chosen, never mixed."""
    write_series("two", [(0, 0, 2 * n) for n in range(5)], uid="1.2.3.10")
    write_series("two", [(0, 0, 2 * n) for n in range(7)], uid="1.2.3.11", order=[20 + n for n in range(7)])
    open("two/readme.txt", "w").write("not a slice\n")
    refused("convert", "two", "-o", "two.nii", says=["2 series", "two:1", "two:2", "1.2.3.11"])
    info = json.loads(run("info", "two", "--json").stdout)
    assert [i["size"] for i in info["images"]] == [[16, 12, 5], [16, 12, 7]], info
    run("convert", "two:2", "-o", "second.nii")
    assert lps("second.nii")[0].shape == (16, 12, 7)
    run("convert", "two:1.2.3.10", "-o", "first.nii")
    assert lps("first.nii")[0].shape == (16, 12, 5)
    refused("convert", "two:3", "-o", "third.nii", says=["two:1"])
    # One file stands for its series.
    run("convert", "two/022.dcm", "-o", "of_file.nii")
    assert lps("of_file.nii")[0].shape == (16, 12, 7)


def case_pixels_not_square():
    """Spacings between rows and between columns differ and are not swapped."""
    write_series("tall", [(1, 2, 3 + n) for n in range(4)], size=(10, 20), spacing=(2.0, 0.5))
    run("convert", "tall", "-o", "tall.nii")
    values, affine = lps("tall.nii")
    assert values.shape == (20, 10, 4) and np.allclose(np.diag(affine)[:3], [0.5, 2.0, 1.0]), (values.shape, affine)
    index = np.stack(np.meshgrid(*[np.arange(n) for n in values.shape], indexing="ij"), -1)
    assert np.abs(values - ramp(index @ affine[:3, :3].T + affine[:3, 3])).max() <= 0.5001


def case_damaged():
    """Truncated and damaged files: a message that names the file, and no output."""
    random = np.random.RandomState(3)
    values = random.randint(-900, 900, (20, 22, 24)).astype(np.int16)
    save_nifti("whole.nii", values, np.diag([1, 1, 2, 1]))
    save_nifti("whole.nii.gz", values, np.diag([1, 1, 2, 1]))
    run("convert", "whole.nii", "-o", "whole.nrrd")
    run("convert", "whole.nii", "-o", "whole.mha")
    for name in ("whole.nii", "whole.nii.gz", "whole.nrrd", "whole.mha"):
        raw = open(name, "rb").read()
        # A gzip file ends with eight bytes of checksums, without which no voxel is missing.
        for cut in (0, 1, 100, 340, 360, len(raw) // 3, len(raw) // 2, len(raw) - 13):
            part = "part_%d.%s" % (cut, name[6:])
            open(part, "wb").write(raw[:cut])
            refused("convert", part, "-o", "out.nii.gz", says=[part])
    write_series("cut", [(0, 0, n) for n in range(4)])
    raw = open("cut/002.dcm", "rb").read()
    # One that says of what series it is, and one that ends before that: it is left out, by name.
    of_series = raw.index(b"1.2.3.9") + 10
    for cut in (of_series, len(raw) // 2, len(raw) - 20, len(raw) - 300):
        open("cut/002.dcm", "wb").write(raw[:cut])
        refused("convert", "cut", "-o", "out.nii.gz", says=["002.dcm", "cut:1"])
    for cut in (140, 200, 400):
        open("cut/002.dcm", "wb").write(raw[:cut])
        said = run("convert", "cut", "-o", "rest.nii").stderr
        assert "002.dcm: is truncated or damaged" in said and "unevenly spaced" in said, said
    # A MetaImage of several files with wrong sizes: the whole stream is read, with a note.
    header = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = %s\nCompressedData = %s\n%s" \
             "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 1 1 2\nDimSize = 20 22 24\n" \
             "ElementType = MET_SHORT\nElementDataFile = %s\n"
    packed = zlib.compress(values.astype("<i2").tobytes(order="F"))
    open("packed.zraw", "wb").write(packed)
    open("wrong.mhd", "w").write(header % ("False", "True", "CompressedDataSize = %d\n" % (len(packed) - 99), "packed.zraw"))
    assert "CompressedDataSize" in (text := run("convert", "wrong.mhd", "-o", "wrong.nii").stderr) or str(len(packed) - 99) in text
    assert np.array_equal(lps("wrong.nii")[0], values)
    open("big.raw", "wb").write(values.astype(">i2").tobytes(order="F"))
    open("big.mhd", "w").write(header % ("True", "False", "", "big.raw"))
    run("convert", "big.mhd", "-o", "big.nii")
    assert np.array_equal(lps("big.nii")[0], values)
    open("short.raw", "wb").write(values.astype("<i2").tobytes(order="F")[:-2])
    open("short.mhd", "w").write(header % ("False", "False", "", "short.raw"))
    refused("convert", "short.mhd", "-o", "out.nii", says=["short.mhd"])
    open("none.mhd", "w").write(header % ("False", "False", "", "not_there.raw"))
    refused("convert", "none.mhd", "-o", "out.nii", says=["none"])


def case_frog():
    """frogtissue.mhd states a wrong compressed size; the whole stream is read."""
    path = data("frogtissue.mhd")
    result = run("convert", path, "-o", "frog.nii.gz")
    assert "260020" in result.stderr and "262087" in result.stderr, result.stderr
    whole = np.frombuffer(zlib.decompress(open(data("frogtissue.zraw"), "rb").read()), np.uint8).reshape((500, 470, 136), order="F")
    assert np.array_equal(lps("frog.nii.gz")[0], whole)


def case_affines():
    """NIfTI with no, a flat, or two affines."""
    values = np.arange(4 * 5 * 6, dtype=np.int16).reshape(4, 5, 6)
    image = nib.Nifti1Image(values, None)
    image.header.set_zooms((1, 2, 3))
    image.set_sform(None, 0), image.set_qform(None, 0)
    nib.save(image, "none.nii")
    result = run("convert", "none.nii", "-o", "none_out.nii")
    assert "does not say where it lies" in result.stderr, result.stderr
    assert np.allclose(nib.load("none_out.nii").header.get_zooms(), (1, 2, 3))
    raw = bytearray(open("none.nii", "rb").read())
    raw[252:256] = b"\0\0\1\0"  # qform 0, sform 1: all of its numbers are 0
    open("flat.nii", "wb").write(raw)
    refused("convert", "flat.nii", "-o", "out.nii", says=["flat.nii", "affine"])
    image = nib.Nifti1Image(values, np.diag([2, 2, 2, 1]))
    image.set_qform(np.diag([3, 3, 3, 1]), 1), image.set_sform(np.diag([2, 2, 2, 1]), 2)
    nib.save(image, "both.nii")
    run("convert", "both.nii", "-o", "both_out.nii")
    assert np.allclose(nib.load("both_out.nii").affine, np.diag([2, 2, 2, 1]))  # as nibabel: the sform first
    path = data("CT_pitch.nii.gz")
    run("convert", path, "-o", "pitch.mha"), run("convert", "pitch.mha", "-o", "pitch.nii.gz")
    assert np.allclose(nib.load("pitch.nii.gz").affine, nib.load(path).affine, atol=1e-4)
    assert np.array_equal(np.asanyarray(nib.load("pitch.nii.gz").dataobj), np.asanyarray(nib.load(path).dataobj))


def case_volumes():
    """4D files: the first volume with a note, or the selected one."""
    values = np.random.RandomState(4).randn(5, 6, 7, 3).astype(np.float32)
    save_nifti("four.nii.gz", values, np.eye(4))
    assert "volume 0 of 3" in run("convert", "four.nii.gz", "-o", "v0.nii").stderr
    assert np.array_equal(lps("v0.nii")[0], values[..., 0])
    run("convert", "four.nii.gz:2", "-o", "v2.nii")
    assert np.array_equal(lps("v2.nii")[0], values[..., 2])
    refused("convert", "four.nii.gz:3", "-o", "v3.nii", says=["four.nii.gz", "volume 3"])
    refused("convert", "four.nii.gz:last", "-o", "v3.nii", says=["last"])
    path = data("mpld_asl.nii.gz")
    run("convert", path + ":24", "-o", "asl.nii")
    assert np.array_equal(lps("asl.nii")[0], np.asanyarray(nib.load(path).dataobj)[..., 24].astype(np.float32))


def case_stacks():
    """Stacks of pictures, pages of a TIFF, a detached NRRD of 93 files."""
    em = data("em_png/image")
    refused("convert", em + "/##.png", "-o", "em.nii", says=["--spacing"])
    run("convert", em + "/##.png", "-o", "em.nii", "--spacing", "4,4,50")
    values, affine = lps("em.nii")
    assert values.shape == (512, 512, 10) and values.dtype == np.uint8
    assert np.allclose(affine, np.diag([4, 4, 50, 1])), affine
    os.mkdir("holes")
    for n in (0, 1, 3):
        shutil.copy(em + "/%02d.png" % n, "holes/%02d.png" % n)
    refused("convert", "holes/##.png", "-o", "x.nii", "--spacing", "1,1,1", says=["missing"])
    open("holes/02.png", "wb").write(open(em + "/02.png", "rb").read()[:30000])
    refused("convert", "holes/##.png", "-o", "x.nii", "--spacing", "1,1,1", says=["02.png"])
    run("convert", data("blobs_3d.tif"), "-o", "blobs.nii", "--spacing", "1,1,1")
    assert lps("blobs.nii")[0].shape == (32, 32, 30)
    run("convert", data("headsq/quarter.nhdr"), "-o", "head.nii")
    values, affine = lps("head.nii")
    for k in (0, 40, 92):
        slice_ = np.fromfile(data("headsq/quarter.%d" % (k + 1)), "<i2").reshape(64, 64).T
        assert np.array_equal(values[:, :, k], slice_) or np.array_equal(values[:, :, k], slice_.byteswap()), k


def ball(shape, affine, middle, radius, inside=900, outside=-1000, ramp=1.0):
    """HU of a ball with a ramp of `ramp` millimetres to either side of
    its surface, which has the mean value."""
    index = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), -1)
    world = index @ affine[:3, :3].T + affine[:3, 3]
    d = np.linalg.norm(world - middle, axis=-1) - radius
    return np.rint(outside + (inside - outside) * np.clip(0.5 - d / (2 * ramp), 0, 1)).astype(np.int16)


def case_grey_morph():
    """Two balls on different lattices: the in-between has mean size and position, the ends are the inputs."""
    a_affine = np.array([[-1, 0, 0, 60.0], [0, 1, 0, -40], [0, 0, 2.0, 10], [0, 0, 0, 1]])
    b_affine = np.array([[0, 1.5, 0, -70.0], [1.5, 0, 0, -50], [0, 0, 1.5, -20], [0, 0, 0, 1]])
    a = ball((90, 90, 40), a_affine, (15, 5, 50), 22, ramp=3)
    b = ball((70, 80, 80), b_affine, (-12, 15, 40), 30, ramp=3)
    save_nifti("a.nii", a, a_affine), save_nifti("b.nii", b, b_affine)
    run("morph", "a.nii", "b.nii", "-o", "m.##.nii.gz", "--frames", 3, "--iso", -50, "--report", "r.json", "--report", "r.csv")
    first, affine = lps("m.01.nii.gz")
    offset = np.rint((np.linalg.inv(affine) @ a_affine)[:3, 3]).astype(int)
    assert np.allclose(affine[:3, :3], a_affine[:3, :3]) and (offset >= 0).all()
    part = tuple(slice(o, o + n) for o, n in zip(offset, a.shape))
    assert np.array_equal(first[part], a)
    rest = np.ones(first.shape, bool)
    rest[part] = False
    assert (first[rest] == a.min()).all()
    rows = json.load(open("r.json"))["frames"]
    lines = open("r.csv").read().splitlines()
    assert len(lines) == 4 and lines[0].startswith("frame,t,file,label,voxels,volume_ml"), lines
    for n, row in enumerate(rows):
        t = n / 2
        values, affine = lps("m.%02d.nii.gz" % (n + 1))
        index = np.argwhere(values > -50)
        volume = len(index) * abs(np.linalg.det(affine[:3, :3]))
        radius, middle = (1 - t) * 22 + t * 30, (1 - t) * np.array([15, 5, 50]) + t * np.array([-12, 15, 40])
        # A voxel count is off by about the square root of the number of surface voxels; 1.5 % covers 2 mm
        # voxels.
        assert abs(volume / (4 / 3 * np.pi * radius ** 3) - 1) < 0.015, (t, volume)
        centroid = (affine[:3, :3] @ index.mean(0)) + affine[:3, 3]
        assert np.linalg.norm(centroid - middle) < 0.2, (t, centroid, middle)
        label = row["labels"][0]
        assert abs(label["volumeMl"] - volume / 1000) < 1e-6 * volume, (label, volume)
        # Crofton's area over 13 directions: within 3 % of a ball's.
        assert abs(label["areaMm2"] / (4 * np.pi * radius ** 2) - 1) < 0.03, (t, label)
        assert all(abs(e - 2 * radius) < 2 * max(np.linalg.norm(affine[:3, :3], axis=0)) for e in label["extentsMm"]), label
        # Deep inside and well outside values are kept: from a voxel's diagonal (2.6 mm at most) beyond the
        # edge's ramp of 3 mm on.
        d = np.linalg.norm((np.indices(values.shape).reshape(3, -1).T @ affine[:3, :3].T + affine[:3, 3]) - middle, axis=1) - radius
        assert (values.reshape(-1)[d < -6] == 900).all() and (values.reshape(-1)[d > 6] == -1000).all(), t
    # A lattice given by options.
    run("morph", "a.nii", "b.nii", "-o", "like.nii", "--at", 1, "--iso", -50, "--like", "b.nii")
    values, affine = lps("like.nii")
    assert np.array_equal(values, b) and np.allclose(affine, b_affine)
    # VDB: values and surface in one file, at the same position.
    run("morph", "a.nii", "b.nii", "-o", "half.vdb", "--at", 0.5, "--iso", -50)
    names = [g.name for g in vdb.readAllGridMetadata("half.vdb")]
    assert sorted(names) == ["image", "surface"], names
    image, surface = vdb.read("half.vdb", "image").getConstAccessor(), vdb.read("half.vdb", "surface")
    voxel = vdb.read("half.vdb", "image").transform
    middle = np.array([1.5, 10, 45])
    at = lambda p: image.getValue(tuple(int(round(v)) for v in voxel.worldToIndex(tuple(p))))
    assert at(middle) == 900 and at(middle + [40, 0, 0]) == -1000
    refused("morph", "a.nii", data("../mesh/spot.obj") if os.path.exists(os.path.join(DATA, "../mesh/spot.obj")) else "a.nii",
            "-o", "x.nii", "--at", 0.5, "--frames", 3)


def case_order_of_voxels():
    """The in-between is the same image in space for any voxel order and axes of the first image."""
    n, h = 56, 1.5
    affine = np.array([[h, 0, 0, -40], [0, h, 0, -35], [0, 0, h, 5], [0, 0, 0, 1.0]])
    p = np.stack(np.meshgrid(*[np.arange(n) * h] * 3, indexing="ij"), -1) + affine[:3, 3]
    def bar(middle, direction, half, radius):
        direction = np.array(direction) / np.linalg.norm(direction)
        along = np.clip((p - middle) @ direction, -half, half)
        d = np.linalg.norm(p - middle - along[..., None] * direction, axis=-1) - radius
        return d
    def grey(d):
        return np.rint(-1000 + 1900 * np.clip(0.5 - d / 6, 0, 1)).astype(np.int16)
    # A knob that slides along a bar and rises, which no rigid motion can do, only the matching's map.
    a = grey(np.minimum(bar((0, 5, 45), (1, 0, 0), 25, 6), bar((-12, 5, 53), (0, 0, 1), 4, 10)))
    b = grey(np.minimum(bar((0, 5, 45), (1, 0, 0), 25, 6), bar((-2, 5, 58), (0, 0, 1), 4, 10)))
    save_nifti("b.nii", b, affine)
    frames = {}
    for name, axes, flips in (("straight", (0, 1, 2), ()), ("mirrored", (0, 1, 2), (2,)), ("turned", (2, 0, 1), (0, 1, 2)), ("swapped", (1, 0, 2), ())):
        values, own = a.transpose(axes), affine[:, list(axes) + [3]].copy()
        for axis in flips:
            own[:3, 3] += own[:3, axis] * (values.shape[axis] - 1)
            own[:3, axis] *= -1
            values = np.flip(values, axis)
        save_nifti(name + ".nii", np.ascontiguousarray(values), own)
        run("morph", name + ".nii", "b.nii", "-o", name + "_half.nii", "--at", 0.5, "--iso", -50, "--align", "none",
            "--like", name + ".nii")
        frames[name] = lps(name + "_half.nii")
    values, own = frames["straight"]
    points = p.reshape(-1, 3)
    for name in ("mirrored", "turned", "swapped"):
        inside, found, off = at_points(*frames[name], points)
        # The level set is made from another mesh for each order: surfaces differ by hundredths of a voxel,
        # and values change by 475 per voxel there.
        differ = np.abs(found - values.reshape(-1).astype(int))
        assert inside.all() and off.max() < 1e-3 and differ.mean() < 3 and np.percentile(differ, 99.9) < 150, (name, differ.mean(), np.percentile(differ, 99.9), differ.max())


def case_label_morph():
    """A moved ball of two halves with a core: labels keep their numbers, no gaps, sizes in between."""
    def halves(shape, affine, middle, radius):
        index = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), -1)
        p = index @ affine[:3, :3].T + affine[:3, 3] - middle
        d = np.linalg.norm(p, axis=-1)
        labels = np.where(d < radius, np.where(p[..., 0] < 0, 3, 200), 0)
        labels[d < radius / 2.5] = 17
        return labels.astype(np.uint8)
    affine = np.diag([1.0, 1.0, 1.5, 1])
    a = halves((80, 80, 54), affine, (38, 36, 40), 20)
    b = halves((80, 80, 54), affine, (42, 44, 38), 26)
    save_nifti("a.nii.gz", a, affine), save_nifti("b.nii.gz", b, affine)
    run("morph", "a.nii.gz", "b.nii.gz", "-o", "l.##.nii.gz", "--frames", 4, "--report", "r.json")
    rows = json.load(open("r.json"))["frames"]
    counts = []
    for n in range(4):
        values, found = lps("l.%02d.nii.gz" % (n + 1))
        assert np.allclose(found, affine) and values.shape == a.shape and values.dtype == np.uint8
        assert sorted(np.unique(values)) == [0, 3, 17, 200], np.unique(values)
        if n in (0, 3):
            assert np.array_equal(values, a if n == 0 else b)
        t = n / 3
        radius, middle = 20 + 6 * t, np.array([38, 36, 40]) * (1 - t) + np.array([42, 44, 38]) * t
        index = np.stack(np.meshgrid(*[np.arange(k) for k in values.shape], indexing="ij"), -1) @ affine[:3, :3].T
        d = np.linalg.norm(index - middle, axis=-1)
        # Farther than half a voxel's diagonal from the border there is no hole inside and no label outside.
        assert (values[d < radius - 1.1] > 0).all() and (values[d > radius + 1.1] == 0).all(), t
        assert (values[d < radius / 2.5 - 1.1] == 17).all() and not (values[d > radius / 2.5 + 1.1] == 17).any(), t
        shell = (d > radius / 2.5 + 1.1) & (d < radius - 1.1)
        x = (index - middle)[..., 0]
        assert (values[shell & (x < -1.1)] == 3).all() and (values[shell & (x > 1.1)] == 200).all(), t
        counts.append([np.count_nonzero(values == v) for v in (3, 17, 200)])
        assert [l["voxels"] for l in rows[n]["labels"]] == counts[-1] and [l["label"] for l in rows[n]["labels"]] == [3, 17, 200]
    assert (np.diff(np.array(counts), axis=0) > 0).all(), counts
    # A label that only the second has grows from nothing.
    b2 = b.copy()
    b2[60:66, 60:66, 20:24] = 9
    save_nifti("b2.nii.gz", b2, affine)
    run("morph", "a.nii.gz", "b2.nii.gz", "-o", "g.#.nii.gz", "--at", "0.3,0.7,1", "--align", "none")
    nine = [np.count_nonzero(lps("g.%d.nii.gz" % n)[0] == 9) for n in (1, 2, 3)]
    assert nine[0] < nine[1] < nine[2] == 144, nine
    refused("morph", "a.nii.gz", "b.nii.gz", "-o", "x.nii", "--at", "0.5", "--image", "mesh", says=["--image"])


def case_memory_of_a_series():
    """What a series takes is known before it is taken."""
    write_series("large", [(0, 0, i) for i in range(60)], size=(512, 512), spacing=(1, 1), value=lambda p: 40 + 0 * p[..., 0])
    # Its numbers alone are 31 MB, the program some 70.
    refused("convert", "large", "-o", "large.nii", "--memory", "100M", says=["large", "512 x 512 x 60 voxels", "--memory"])


def case_lungs():
    """Lung masks at two times on different grids: volume is monotonic; prescribed landmarks arrive nearer."""
    a, b = data("lung/3DCT_lung_baseline_mask.mha"), data("lung/3DCT_lung_followup_mask.mha")
    points = data("lung/baseline_points.txt") + "," + data("lung/followup_points.txt")
    def landmarks(*options):
        run("morph", a, b, "-o", "lung.##.nii.gz", "--report", "r.json", *options)
        return json.load(open("r.json"))
    plain = landmarks("--frames", 3, "--check-landmarks", points)
    volumes = [f["labels"][0]["volumeMl"] for f in plain["frames"]]
    steps = np.diff(volumes)
    assert (steps > 0).all() or (steps < 0).all(), volumes
    guided = landmarks("--at", 0.5, "--landmarks", points, "--check-landmarks", points)
    volumes[1] = guided["frames"][0]["labels"][0]["volumeMl"]
    steps = np.diff(volumes)
    assert (steps > 0).all() or (steps < 0).all(), volumes
    before, without, with_ = plain["checkLandmarks"]["meanDistanceBefore"], plain["checkLandmarks"]["mean"], guided["landmarks"]["mean"]
    print("      landmarks off by %.1f mm as they are, %.1f without, %.2f with (largest %.1f, %.1f)" % (
        before, without, with_, plain["checkLandmarks"]["max"], guided["landmarks"]["max"]))
    # Half of the spacing of the displacement field, and far better than without.
    assert with_ < 1.366 and with_ < 0.5 * without < before, (before, without, with_)
    # With half of them prescribed the others improve, too.
    rows = [[l for l in open(p).read().split("\n")[2:] if l.strip()] for p in points.split(",")]
    for part in (0, 1):
        for k in (0, 1):
            open("part%d_%d.txt" % (part, k), "w").write("\n".join(rows[k][part::2]) + "\n")
    if os.environ.get("SLICEMORPH_ALL_TESTS"):
        half = landmarks("--at", 0.5, "--landmarks", "part0_0.txt,part0_1.txt", "--check-landmarks", "part1_0.txt,part1_1.txt")
        print("      told 26 of them the other 25 are off by %.1f" % half["checkLandmarks"]["mean"])
        assert half["checkLandmarks"]["mean"] < without, half["checkLandmarks"]
    # The same landmarks as lists in a job file.
    pairs = [[[float(v) for v in rows[k][i].split()] for k in (0, 1)] for i in range(0, 51, 10)]
    open("job.toml", "w").write("inputs = [%r, %r]\noutput = 'job.nii'\nat = 0.5\nresolution = 32\nlandmarks = %r\n" % (a, b, pairs))
    run("morph", "--config", "job.toml", "--quiet")
    refused("morph", a, b, "-o", "x.nii", "--at", "0.5", "--landmarks", "part0_0.txt,part1_1.txt", says=["26", "25"])
    refused("morph", a, b, "-o", "x.nii", "--at", "0.5", "--landmarks", "part0_0.txt", says=["one per input"])


def labels_py(*arguments):
    tool = os.path.join(DATA, "../../tools/labels.py")
    if not os.path.exists(tool):
        raise Skip("labels.py is not there")
    return subprocess.run(["/usr/bin/python3", tool, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def case_reconstruct_labels():
    """Thinned label maps: given slices are found and kept, all labels are
    kept, and the rest beats both baselines."""
    torso = data("torsoLabel.nii.gz")
    # Mean and weighted Dice on the missing slices: the larger of the two baselines of shared/baselines.md.
    for every, axis, mean, weighted in ((8, 2, .712, .838), (4, 2, .855, .923), (8, 0, .951, .974)):
        labels_py("thin", torso, "thin.nii.gz", "--axis", axis, "--every", every)
        result = run("reconstruct", "thin.nii.gz", "-o", "dense.nii.gz", "--report", "r.csv")
        assert "every %d" % every in result.stderr and "axis %s" % "ijk"[axis] in result.stderr, result.stderr
        found = labels_py("dice", torso, "dense.nii.gz", "--axis", axis, "--every", every)
        words = found.split()
        got = [float(words[words.index(k) + 1]) for k in ("mean", "weighted")]
        assert got[0] > mean and got[1] > weighted, (every, axis, got)
        assert "kept-voxels-changed 0" in found and "lost-between 0" in found, found
    full = nib.load(torso)
    assert np.allclose(nib.load("dense.nii.gz").affine, full.affine)
    # The same partition for other label numbers; the same bytes with one thread.
    thin = nib.load("thin.nii.gz")
    values = np.asanyarray(thin.dataobj)
    other = np.array([0] + [200 - 7 * v for v in range(1, 12)], np.uint8)
    nib.save(nib.Nifti1Image(other[values], thin.affine), "other.nii.gz")
    run("reconstruct", "other.nii.gz", "-o", "other_dense.nii.gz", "--threads", 1)
    assert np.array_equal(other[np.asanyarray(nib.load("dense.nii.gz").dataobj)], np.asanyarray(nib.load("other_dense.nii.gz").dataobj))
    # A stack of the given slices alone.
    labels_py("thin", torso, "compact.nii.gz", "--axis", 0, "--every", 8, "--compact")
    run("reconstruct", "compact.nii.gz", "-o", "between.nii.gz", "--axis", "i", "--between", 7)
    dense, between = np.asanyarray(nib.load("dense.nii.gz").dataobj), np.asanyarray(nib.load("between.nii.gz").dataobj)
    # Compared where a gap has the same four slices around it: beyond the labelled slices the thinned map has
    # no slices, the stack empty ones.
    labelled = np.flatnonzero(between[::8].any((1, 2))) * 8
    span = slice(labelled[1], labelled[-2] + 1)
    assert np.array_equal(dense[span], between[span])
    assert np.allclose(nib.load("between.nii.gz").affine, full.affine, atol=1e-5)
    # On the voxels of another image, turned and finer: the label of the nearest voxel of the dense map.
    c, n = math.cos(0.3), math.sin(0.3)
    middle = lps("dense.nii.gz")[1] @ np.array([*(np.array(dense.shape) / 2), 1])
    affine = np.array([[1.1 * c, -0.9 * n, 0, 0], [1.1 * n, 0.9 * c, 0, 0], [0, 0, 1.7, 0], [0, 0, 0, 1.0]])
    affine[:3, 3] = middle[:3] - affine[:3, :3] @ [30, 25, 20]
    save_nifti("like.nii", np.zeros((60, 50, 40), np.uint8), affine)
    run("reconstruct", "thin.nii.gz", "-o", "on.nii.gz", "--like", "like.nii")
    on, placed = lps("on.nii.gz")
    assert on.shape == (60, 50, 40) and np.allclose(placed, affine, atol=1e-5)
    ijk = np.stack(np.meshgrid(*map(np.arange, on.shape), indexing="ij"), -1).reshape(-1, 3)
    values, from_affine = lps("dense.nii.gz")
    inside, wanted, off = at_points(values, from_affine, (affine @ np.c_[ijk, np.ones(len(ijk))].T).T[:, :3])
    clear = inside & (off < 0.499)  # half way between two voxels either label is right
    assert clear.sum() > 50000 and np.array_equal(on.reshape(-1)[clear], wanted[clear]) and on.any()
    whole = np.zeros((9, 9, 9), np.uint8)
    whole[2:6, 2:6, 2:6] = 1
    save_nifti("whole.nii", whole, np.eye(4))
    refused("reconstruct", "whole.nii", "-o", "x.nii.gz", says=["whole.nii", "--between"])
    one = np.zeros((9, 9, 9), np.uint8)
    one[2:6, 2:6, 4] = 1
    save_nifti("one.nii", one, np.eye(4))
    refused("reconstruct", "one.nii", "-o", "x.nii.gz", says=["one.nii", "one"])
    save_nifti("none.nii", 0 * one, np.eye(4))
    refused("reconstruct", "none.nii", "-o", "x.nii.gz", says=["none.nii"])


def case_reconstruct_slabs():
    """A map that does not fit --memory is filled in slice by slice: the same bytes, from every format that is read so."""
    k = np.arange(401)
    i, j = np.meshgrid(np.arange(320), np.arange(256), indexing="ij")
    labels = np.zeros((320, 256, len(k)), np.uint16)
    for n in range(9, len(k) - 6, 4):  # three tubes that wind, a frame around them
        for label, phase in ((700, 0), (2, 2.1), (31, 4.2)):
            x, y = 160 + 90 * np.cos(phase + 0.02 * n), 128 + 70 * np.sin(phase + 0.02 * n)
            labels[np.hypot(i - x, j - y) < 25 + 10 * np.sin(0.05 * n), n] = label
        labels[:6, :, n] = labels[:, -9:, n] = 5
    affine = np.diag([-0.5, -0.6, 1.25, 1])
    save_nifti("map.nii.gz", labels, affine)
    save_nifti("map.nii", labels, affine)
    few = ("--memory", "130M")  # the map alone takes 65.7 MB, and there are two of them with --between
    for name, options, out in (("map.nii.gz", (), "gz.nii.gz"), ("map.nii", ("--every", 2), "two.nrrd")):
        whole = run("reconstruct", name, "-o", "whole_" + out, *options)
        assert "slice by slice" not in whole.stderr, whole.stderr
        slabs = run("reconstruct", name, "-o", out, *options, *few)
        assert "slice by slice" in slabs.stderr and "given slices along axis k" in slabs.stderr, slabs.stderr
        assert open("whole_" + out, "rb").read() == open(out, "rb").read(), out
    run("reconstruct", "two.nrrd", "-o", "between.mha", "--between", 1, "--axis", "k")
    slabs = run("reconstruct", "two.nrrd", "-o", "between_slabs.mha", "--between", 1, "--axis", "k", "--memory", "250M")
    assert "slice by slice" in slabs.stderr, slabs.stderr
    assert open("between.mha", "rb").read() == open("between_slabs.mha", "rb").read()
    # Slices along another axis need the whole; the message says so.
    save_nifti("along_i.nii", labels.transpose(2, 1, 0), affine)
    refused("reconstruct", "along_i.nii", "-o", "x.nii", *few, says=["along_i.nii", "axis i", "--memory"])
    assert not os.path.exists("x.nii")


def stl_points(path):
    raw = np.frombuffer(open(path, "rb").read()[84:], np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]))
    return raw["v"].astype(float)


def to_triangles(points, triangles):
    """Distance of each point to the nearest triangle, by brute force over those whose centroid is near."""
    from scipy.spatial import cKDTree
    middles = triangles.mean(1)
    radius = np.linalg.norm(triangles - middles[:, None], axis=2).max()
    _, near = cKDTree(middles).query(points, k=min(40, len(middles)))
    best = np.full(len(points), np.inf)
    for column in np.atleast_2d(near.T):
        t = triangles[column]
        a, b, c = t[:, 0], t[:, 1], t[:, 2]
        n = np.cross(b - a, c - a)
        n /= np.linalg.norm(n, axis=1)[:, None] + 1e-30
        foot = points - ((points - a) * n).sum(1)[:, None] * n
        inside = np.ones(len(points), bool)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= (np.cross(q - p, foot - p) * n).sum(1) >= 0
        best = np.where(inside, np.minimum(best, np.abs(((points - a) * n).sum(1))), best)
        for p, q in ((a, b), (b, c), (c, a)):
            s = np.clip(((points - p) * (q - p)).sum(1) / (((q - p) ** 2).sum(1) + 1e-30), 0, 1)
            best = np.minimum(best, np.linalg.norm(points - p - s[:, None] * (q - p), axis=1))
    assert radius < np.inf
    return best


def case_reconstruct_contours():
    """A DICOM structure set: closed surfaces through all points that pydicom reads, by name; dense labels."""
    path = data("contours/rtss.dcm")
    d = pydicom.dcmread(path)
    numbers = {r.ROIName: r.ROINumber for r in d.StructureSetROISequence}
    for name in ("Heart", "Tumor Bed"):
        run("reconstruct", path + ":" + name, "-o", "s.stl", "--report", "s.json")
        roi = [c for c in d.ROIContourSequence if c.ReferencedROINumber == numbers[name]][0]
        points = np.concatenate([np.array(c.ContourData, float).reshape(-1, 3) for c in roi.ContourSequence])
        triangles = stl_points("s.stl")
        off = to_triangles(points, triangles)
        assert off.max() <= 0.5, (name, off.max())
        row = json.load(open("s.json"))["structures"][0]
        volume = np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum() / 6
        assert row["label"] == numbers[name] and abs(row["volumeMl"] - volume / 1000) < 1e-3 * volume / 1000, (row, volume)
        # Every edge is used once in each direction: closed and consistently wound.
        keys = {}
        ids = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
        edges = np.concatenate([ids[:, [0, 1]], ids[:, [1, 2]], ids[:, [2, 0]]])
        forward, counts = np.unique(edges, axis=0, return_counts=True)
        assert (counts == 1).all() and np.array_equal(np.unique(edges[:, ::-1], axis=0), forward), name
    run("reconstruct", path + ":Heart", "-o", "heart.nii.gz")
    heart = nib.load("heart.nii.gz")
    assert sorted(np.unique(np.asanyarray(heart.dataobj))) == [0, numbers["Heart"]]
    middle = LPS @ heart.affine @ np.r_[np.argwhere(np.asanyarray(heart.dataobj)).mean(0), 1]
    roi = [c for c in d.ROIContourSequence if c.ReferencedROINumber == numbers["Heart"]][0]
    points = np.concatenate([np.array(c.ContourData, float).reshape(-1, 3) for c in roi.ContourSequence])
    assert (middle[:3] > points.min(0)).all() and (middle[:3] < points.max(0)).all(), middle
    refused("reconstruct", path + ":Liver", "-o", "x.stl", says=["Liver", "Heart"])
    refused("reconstruct", path, "-o", "x.stl", says=["####"])
    raw = open(path, "rb").read()
    open("cut.dcm", "wb").write(raw[:len(raw) // 2])
    refused("reconstruct", "cut.dcm", "-o", "x.stl", says=["cut.dcm"])
    run("reconstruct", data("contours/Horsers.csl"), "-o", "horse.ply", "--report", "h.json")
    assert json.load(open("h.json"))["structures"][0]["genus"] == 0


sys.exit(run_within(globals(), ONLY))
