#!/usr/bin/env python3
"""NRRD, NIfTI, Analyze, MetaImage, TIFF and EXR stacks: places, units, types and layouts, against nibabel, Teem,
tifffile, oiiotool and numpy.

usage: image_formats_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-nibabel, python3-tifffile, openimageio-tools; teem-apps for some NRRD cases. Positions are LPS
millimetres. Places are compared to 1e-4 mm: NIfTI's affines are 32-bit floats, good to 3e-5 mm at 500 mm.
"""
import bz2
import gzip
import json
import os
import shutil
import struct
import subprocess
import sys
import zlib

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import dicom_files as dcm
from cases import Skip, run_within
from dicom_files import item
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
FAULTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data/faults/image")
OBLIQUE = np.array([[0.4, -0.3, 0.1, 10], [0.3, 0.4, 0.2, -20], [0, 0.1, -2, 30], [0, 0, 0, 1.0]])


program = Program(sys.argv[1])


def run(*arguments, code=0):
    return program.run(*arguments, code=code).stderr


def refused(*arguments, says=()):
    """As Program.refused, and the message names the file, and holds no address in memory nor a library's name."""
    said = program.refused(*arguments, says=(os.path.basename(str(arguments[1]).split(":")[0].split("@")[0]), *says))
    assert "0x" not in said and "itk" not in said, said
    return said


def converted(name, *options, out="out.nii"):
    """Values and LPS affine of an input as convert writes them, and what was said."""
    said = run("convert", name, "-o", out, *options)
    image = nib.load(out)
    return np.asanyarray(image.dataobj), LPS @ image.affine, said


def check(name, values, affine, *options, says=()):
    found, place, said = converted(name, *options)
    assert found.shape == values.shape, (name, found.shape, values.shape)
    assert np.array_equal(found, values), "%s: values differ" % name
    assert np.abs(place - affine).max() < 1e-4, "%s: %s, not %s" % (name, place, affine)
    for part in says:
        assert part in said, "%s: %r is not in: %s" % (name, part, said)
    return said


def numbers(shape=(5, 4, 3), dtype=np.int16, seed=1):
    return np.random.RandomState(seed).randint(0, 200, shape).astype(dtype)


NRRD_TYPES = {"i1": "int8", "u1": "uint8", "i2": "int16", "u2": "uint16", "i4": "int32", "u4": "uint32", "i8": "int64",
              "u8": "uint64", "f4": "float", "f8": "double"}


def vector(v):
    return "(" + ",".join("%.17g" % c for c in v) + ")"


def nrrd(name, values, *fields, encoding="raw", order="<"):
    """Written by hand after http://teem.sourceforge.net/nrrd/format.html; the first axis is the fastest."""
    raw = values.astype(values.dtype.newbyteorder(order)).tobytes(order="F")
    packed = {"raw": bytes, "gzip": gzip.compress, "bzip2": bz2.compress, "hex": lambda b: b.hex().encode(),
              "text": lambda b: " ".join(map(str, values.ravel(order="F"))).encode()}[encoding](raw)
    head = ["NRRD0005", "# a comment", "type: " + NRRD_TYPES[values.dtype.str[1:]], "dimension: %d" % values.ndim,
            "sizes: " + " ".join(map(str, values.shape)), "endian: " + ("little" if order == "<" else "big"), "encoding: " + encoding, *fields]
    open(name, "wb").write("\n".join(head).encode() + b"\n\n" + packed)


def directions(affine, none_first=0, none_last=0):
    return "space directions: " + " ".join(["none"] * none_first + [vector(affine[:3, d]) for d in range(3)] + ["none"] * none_last)


def origin(affine):
    return "space origin: " + vector(affine[:3, 3])


# Signs that make a space's coordinates LPS, from the meaning of its name: a direction named is that in which the
# coordinate grows.
SPACES = {(-1, -1, 1): ("right-anterior-superior", "RAS"), (1, -1, 1): ("left-anterior-superior", "LAS"), (1, 1, 1): ("left-posterior-superior", "LPS")}


def case_nrrd_spaces():
    """Each name, abbreviation and -time form of a space; spaces without a patient are told."""
    values = numbers()
    for sign, names in SPACES.items():
        expected = np.diag([*sign, 1.0]) @ OBLIQUE
        for space in (*names, names[0].upper()):
            nrrd("in.nrrd", values, "space: " + space, directions(OBLIQUE), origin(OBLIQUE))
            assert "warning" not in check("in.nrrd", values, expected).lower()
        for space in (names[0] + "-time", names[1] + "T"):
            four = numbers((5, 4, 3, 2))
            steps = [vector((*OBLIQUE[:3, d], 0)) for d in range(3)] + ["(0,0,0,2.5)"]
            nrrd("in.nrrd", four, "space: " + space, "space directions: " + " ".join(steps), "space origin: " + vector((*OBLIQUE[:3, 3], 7)))
            check("in.nrrd", four[..., 0], expected, says=["volume 0 of 2"])
            check("in.nrrd:1", four[..., 1], expected)
    for space, sign in (("scanner-xyz", (1, 1, 1)), ("3D-right-handed", (1, 1, 1)), ("3D-left-handed", (1, 1, -1))):
        nrrd("in.nrrd", values, "space: " + space, directions(OBLIQUE), origin(OBLIQUE))
        check("in.nrrd", values, np.diag([*sign, 1.0]) @ OBLIQUE, says=["its space '%s'" % space])
    nrrd("in.nrrd", values, "space dimension: 3", directions(OBLIQUE), origin(OBLIQUE))
    check("in.nrrd", values, OBLIQUE, says=["space has no name"])
    nrrd("in.nrrd", values, "space: LPS", "spacings: 1 2 3", "space directions: none none none")
    check("in.nrrd", values, np.diag([1, 2, 3, 1]), says=["spacings alone"])
    nrrd("in.nrrd", values, "space: up-up-up", directions(OBLIQUE), origin(OBLIQUE))
    refused("convert", "in.nrrd", "-o", "x.nii", says=["up-up-up"])
    steps = [vector((*OBLIQUE[:3, d], 0.1)) for d in range(3)] + ["(0,0,0,2.5)"]
    nrrd("in.nrrd", numbers((5, 4, 3, 2)), "space: LPST", "space directions: " + " ".join(steps))
    refused("convert", "in.nrrd", "-o", "x.nii", says=["space and time at once"])


def case_nrrd_units():
    """Micrometres and others become millimetres, with a note; what is unknown is told."""
    values = numbers()
    for unit, factor in (("mm", 1), ("um", 1e-3), ("\u00b5m", 1e-3), ("micron", 1e-3), ("micrometers", 1e-3), ("cm", 10), ("m", 1000)):
        nrrd("in.nrrd", values, "space: LPS", directions(OBLIQUE), origin(OBLIQUE), "space units: " + " ".join(['"%s"' % unit] * 3))
        said = check("in.nrrd", values, np.diag([factor, factor, factor, 1]) @ OBLIQUE)
        assert ("became millimetres" in said) == (factor != 1), said
        nrrd("in.nrrd", values, "spacings: 1 2 3", "units: " + " ".join(['"%s"' % unit] * 3))
        check("in.nrrd", values, np.diag([factor, 2 * factor, 3 * factor, 1]), says=["taken from its spacings"])
        # An origin beside spacings is in the space's units, or in those of the axes; spacings without units are in the space's.
        expected = np.diag([factor, 2 * factor, 3 * factor, 1.0])
        expected[:3, 3] = np.array([10, -20, 30]) * factor
        for key in ("units", "space units"):
            nrrd("in.nrrd", values, "space: LPS", "spacings: 1 2 3", "space origin: (10,-20,30)", key + ": " + " ".join(['"%s"' % unit] * 3))
            check("in.nrrd", values, expected, says=["spacings alone"])
    nrrd("in.nrrd", values, "space: LPS", directions(OBLIQUE), origin(OBLIQUE), 'space units: "furlong" "mm" "mm"')
    check("in.nrrd", values, OBLIQUE, says=["furlong"])
    nrrd("in.nrrd", values, "space: LPS", directions(OBLIQUE), origin(OBLIQUE), "spacings: 1 1 1")
    check("in.nrrd", values, OBLIQUE, says=["'spacings'"])


def case_nrrd_axes():
    """Times, vectors and other kinds are no axes of space, wherever they stand; colours are luminance."""
    for kind, where, shape in (("time", 3, (5, 4, 3, 2)), ("list", 0, (6, 5, 4, 3)), ("3-vector", 0, (3, 5, 4, 3)), ("vector", 3, (5, 4, 3, 3)), ("list", 1, (5, 6, 4, 3))):
        values = numbers(shape)
        kinds = ["domain"] * 3
        kinds.insert(where, kind)
        steps = [vector(OBLIQUE[:3, d]) for d in range(3)]
        steps.insert(where, "none")
        nrrd("in.nrrd", values, "space: LPS", "space directions: " + " ".join(steps), origin(OBLIQUE), "kinds: " + " ".join(kinds))
        for n in range(shape[where]):
            check("in.nrrd:%d" % n, np.take(values, n, where), OBLIQUE)
        check("in.nrrd", np.take(values, 0, where), OBLIQUE, says=["volume 0 of %d" % shape[where], kind])
        nrrd("in.nrrd", values, "kinds: " + " ".join(kinds))
        check("in.nrrd:1", np.take(values, 1, where), np.eye(4))
    rgb = numbers((3, 5, 4, 3), np.uint8)
    nrrd("in.nrrd", rgb, "space: LPS", directions(OBLIQUE, none_first=1), origin(OBLIQUE), "kinds: RGB-color domain domain domain")
    grey = np.rint(np.tensordot([0.2126, 0.7152, 0.0722], rgb.astype(float), 1)).astype(np.uint8)
    check("in.nrrd", grey, OBLIQUE, says=["luminance"])
    check("in.nrrd:1", rgb[1], OBLIQUE)
    nrrd("in.nrrd", numbers((3, 2, 5, 4, 3)), "space: LPS", "space directions: none none " + " ".join(vector(OBLIQUE[:3, d]) for d in range(3)), "kinds: vector list domain domain domain")
    check("in.nrrd:4", numbers((3, 2, 5, 4, 3))[1, 1], np.c_[OBLIQUE[:, :3], [0, 0, 0, 1]])


def case_nrrd_encodings():
    """All types in all encodings and byte orders; data apart, in several files, behind other bytes."""
    place = ["space: LPS", directions(OBLIQUE), origin(OBLIQUE)]
    for n, dtype in enumerate(NRRD_TYPES):
        for e, encoding in enumerate(("raw", "gzip", "bzip2", "hex", "text")):
            values = numbers(dtype=np.dtype(dtype))
            if dtype[0] == "f":
                values = values / np.dtype(dtype).type(7)
            nrrd("in.nrrd", values, *place, encoding=encoding, order="<>"[(n // 2 + e) % 2])
            check("in.nrrd", values, OBLIQUE)
    values = numbers((5, 4, 6))
    raw = values.astype("<i2").tobytes(order="F")
    head = "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 4 6\nendian: little\nspace: LPS\n%s\n%s\n" % (place[1], place[2])
    for n in range(6):
        open("s.%02d" % n, "wb").write(raw[40 * n:40 * n + 40])
    open("ab.raw", "wb").write(b"one\ntwo\nxyz" + raw)
    open("a.raw.gz", "wb").write(gzip.compress(b"xyz" + raw))
    for fields in ("encoding: raw\ndata file: s.%02d 0 5 1\n", "encoding: raw\ndatafile: LIST\n" + "".join("s.%02d\n" % n for n in range(6)),
                   "encoding: raw\nline skip: 2\nbyte skip: 3\ndata file: ab.raw\n", "encoding: raw\nbyteskip: -1\ndata file: ./ab.raw\n",
                   "encoding: gzip\nbyte skip: 3\ndata file: a.raw.gz\n"):
        open("in.nhdr", "w").write(head + fields)
        check("in.nhdr", values, OBLIQUE)
    open("in.nhdr", "w").write(head.replace("\n", "\r\n") + "encoding: raw\r\nline skip: 2\r\nbyte skip: 3\r\ndata file: ab.raw\r\n")
    check("in.nhdr", values, OBLIQUE)
    open("in.nhdr", "w").write(head + "encoding: raw\ndata file: none.raw\n")
    refused("convert", "in.nhdr", "-o", "x.nii", says=["none.raw"])
    for encoding in ("raw", "gzip", "bzip2", "hex", "text"):
        nrrd("cut.nrrd", values, *place, encoding=encoding)
        whole = open("cut.nrrd", "rb").read()
        open("cut.nrrd", "wb").write(whole[:-30])
        refused("convert", "cut.nrrd", "-o", "x.nii", says=["truncated"])
    nrrd("in.nrrd", values, *place)
    open("in.nrrd", "ab").write(b"")
    text = open("in.nrrd", "rb").read()
    open("odd.nrrd", "wb").write(text.replace(b"encoding: raw", b"encoding: zstd"))
    refused("convert", "odd.nrrd", "-o", "x.nii", says=["zstd", "bzip2"])


def case_nrrd_teem():
    """What Teem's own program writes."""
    unu = shutil.which("teem-unu") or shutil.which("unu")
    if not unu:
        raise Skip("teem-apps is not installed")
    values = numbers((7, 6, 5), np.uint16)
    nrrd("in.nrrd", values, "space: LAS", directions(OBLIQUE), origin(OBLIQUE))
    expected = np.diag([1, -1, 1, 1]) @ OBLIQUE
    for encoding in ("raw", "ascii", "hex", "gzip", "bzip2"):
        subprocess.run([unu, "save", "-f", "nrrd", "-e", encoding, "-i", "in.nrrd", "-o", "out.nrrd"], check=True)
        check("out.nrrd", values, expected)
    subprocess.run([unu, "save", "-f", "nrrd", "-e", "gzip", "-i", "in.nrrd", "-o", "out.nhdr"], check=True)
    check("out.nhdr", values, expected)


def case_metaimage():
    """Slope and offset, units of length, byte skips, channels."""
    values = numbers((5, 4, 3))
    raw = values.astype("<i2").tobytes(order="F")
    step = np.linalg.norm(OBLIQUE[:3, :3], axis=0)
    head = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n" \
           "TransformMatrix = %s\nOffset = %s\nElementSpacing = %s\nDimSize = 5 4 3\n%sElementType = MET_SHORT\nElementDataFile = %s\n"
    matrix = " ".join("%.17g" % v for d in range(3) for v in OBLIQUE[:3, d] / step[d])

    def write(fields="", data="LOCAL", body=raw):
        text = head % (matrix, " ".join("%.17g" % v for v in OBLIQUE[:3, 3]), " ".join("%.17g" % v for v in step), fields, data)
        open("in.mhd", "wb").write(text.encode() + (body if data == "LOCAL" else b""))

    write()
    check("in.mhd", values, OBLIQUE)
    write("ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1000\n")
    check("in.mhd", values * 2 - 1000, OBLIQUE, says=["multiplied by 2"])
    write("ElementToIntensityFunctionSlope = 0.5\n")
    check("in.mhd", (values * 0.5).astype(np.float32), OBLIQUE)
    write("DistanceUnits = um\n")
    check("in.mhd", values, np.diag([1e-3, 1e-3, 1e-3, 1]) @ OBLIQUE, says=["'um'"])
    open("skip.raw", "wb").write(b"abcdefg" + raw)
    for skip in (7, -1):
        write("HeaderSize = %d\n" % skip, "skip.raw")
        check("in.mhd", values, OBLIQUE)
    open("skip.zraw", "wb").write(b"abcdefg" + zlib.compress(raw))
    for skip in (7, -1, "seven"):
        write("HeaderSize = %s\n" % skip, "skip.zraw")
        text = open("in.mhd", "rb").read()
        open("in.mhd", "wb").write(text.replace(b"CompressedData = False", b"CompressedData = True"))
        if skip == 7:
            check("in.mhd", values, OBLIQUE)
        else:
            refused("convert", "in.mhd", "-o", "x.nii", says=["HeaderSize", str(skip)])
    for k in range(3):
        open("s%02d.raw" % k, "wb").write(raw[40 * k:40 * k + 40])
    write(data="s%02d.raw 0 2 1")
    check("in.mhd", values, OBLIQUE)
    write(data="LIST\ns00.raw\ns01.raw\ns02.raw")
    check("in.mhd", values, OBLIQUE)
    write(data="LIST\ns00.raw\ns01.raw\nnone.raw")
    refused("convert", "in.mhd", "-o", "x.nii", says=["none.raw"])
    write(body=" ".join(map(str, values.ravel(order="F"))).encode())
    text = open("in.mhd", "rb").read()
    open("in.mhd", "wb").write(text.replace(b"BinaryData = True", b"BinaryData = False"))
    check("in.mhd", values, OBLIQUE)
    vectors = numbers((2, 5, 4, 3))
    write("ElementNumberOfChannels = 2\n", body=vectors.astype("<i2").tobytes(order="F"))
    check("in.mhd", vectors[0], OBLIQUE, says=["volume 0 of 2", "component"])
    check("in.mhd:1", vectors[1], OBLIQUE)
    write(body=raw[:-1])
    refused("convert", "in.mhd", "-o", "x.nii", says=["truncated"])
    for channels in (0, -1, "two"):
        write("ElementNumberOfChannels = %s\n" % channels)
        refused("convert", "in.mhd", "-o", "x.nii", says=["ElementNumberOfChannels '%s'" % channels])
    text = open("in.mhd", "rb").read()
    open("in.mhd", "wb").write(text.replace(b"ElementNumberOfChannels = two", b"ElementNumberOfChannels : 0"))
    refused("convert", "in.mhd", "-o", "x.nii")
    write("ElementToIntensityFunctionSlope = two\n")
    refused("convert", "in.mhd", "-o", "x.nii", says=["ElementToIntensityFunctionSlope", "two"])


def case_flat_axes():
    """Axes that are 0, that run along others or lie in one plane place nothing."""
    values = numbers()
    for steps in ("(1,0,0) (0,1,0) (0,0,0)", "(1,0,0) (1,0,0) (0,0,1)", "(1,0,0) (0,1,0) (1,1,0)"):
        nrrd("in.nrrd", values, "space: LPS", "space directions: " + steps)
        refused("convert", "in.nrrd", "-o", "x.nii", says=["flatten space"])
        refused("info", "in.nrrd", says=["flatten space"])
    nrrd("in.nrrd", values, "space dimension: 2", "space directions: (1,0) (0,1) (1,1)")
    refused("convert", "in.nrrd", "-o", "x.nii", says=["flatten space"])
    for steps in ("(1,0,0) (2,0,0)", "(0,0,0) (0,1,0)"):
        nrrd("in.nrrd", values[..., 0], "space: LPS", "space directions: " + steps)
        refused("convert", "in.nrrd", "-o", "x.nii", says=["flatten space"])
    nrrd("in.nrrd", values[:, 0, 0], "space: LPS", "space directions: (0,0,0)")
    refused("convert", "in.nrrd", "-o", "x.nii", says=["flatten space"])
    head = "ObjectType = Image\nNDims = %d\nBinaryData = True\nTransformMatrix = %s\nElementSpacing = %s\nDimSize = %s\n" \
           "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
    for fields in ((3, "1 0 0 1 0 0 0 0 1", "1 1 1", "2 2 2"), (3, "1 0 0 0 1 0 0 0 1", "1 0 1", "2 2 2"), (2, "1 0 1 0", "1 1", "2 2")):
        open("in.mha", "wb").write((head % fields).encode() + b"12345678")
        refused("convert", "in.mha", "-o", "x.nii")


def case_missing_data():
    """Also of a large image, whose values nobody reads, `info` sees that its data are missing or cut."""
    head = "NRRD0004\ntype: short\ndimension: 3\nsizes: 512 512 512\nendian: little\nspace: LPS\n%s\nencoding: raw\n" % directions(np.eye(4))
    meta = "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 512 512 512\nElementType = MET_SHORT\nElementDataFile = "
    for name, text, data in (("in.nrrd", head + "\n", b"ab"), ("in.nhdr", head + "data file: cut.raw\n", b""), ("in.mha", meta + "LOCAL\n", b"ab"),
                             ("in.mhd", meta + "cut.raw\n", b"")):
        open("cut.raw", "wb").write(b"ab")
        open(name, "wb").write(text.encode() + data)
        refused("info", name, says=["truncated", "2 bytes", str(2 * 512 ** 3)])
        if not data:
            os.remove("cut.raw")
            refused("info", name, says=["cut.raw does not exist"])


def case_long_first_axis():
    """A first axis that tells volumes apart is passed over in parts, however long it is said to be."""
    nrrd("in.nrrd", numbers((1, 1, 1, 1), np.float64), "kinds: list domain domain domain", encoding="gzip")
    text = open("in.nrrd", "rb").read()
    open("in.nrrd", "wb").write(text.replace(b"sizes: 1 1 1 1", b"sizes: %d 1 1 1" % 2 ** 30))
    with open("told.txt", "w") as told:
        process = subprocess.Popen([program.path, "convert", "in.nrrd:5", "-o", "x.nii"], stderr=told)
        _, status, used = os.wait4(process.pid, 0)
    assert os.WEXITSTATUS(status) == 1 and "truncated" in open("told.txt").read(), (status, open("told.txt").read())
    assert used.ru_maxrss < 1 << 20, used.ru_maxrss
    # The parts that are read at once, of 2^20 bytes, end within its rows.
    values = numbers((200003, 2, 3, 1), np.uint16)
    nrrd("in.nrrd", values, "kinds: list domain domain domain")
    for volume in (0, 131071, 131072, 200002):
        check("in.nrrd:%d" % volume, values[volume], np.eye(4))
    values = numbers((200003, 2, 3, 2), np.float32)
    nrrd("in.nrrd", values, "kinds: domain domain list domain")
    for volume in range(3):
        check("in.nrrd:%d" % volume, values[:, :, volume], np.eye(4))


def case_nifti():
    """NIfTI-1 and -2, in one file and two, of either byte order, of all types, of 3 to 5 dimensions."""
    for k, kind in enumerate((nib.Nifti1Image, nib.Nifti2Image, nib.Nifti1Pair, nib.Nifti2Pair)):
        for n, dtype in enumerate(("u1", "i1", "u2", "i2", "u4", "i4", "i8", "u8", "f4", "f8")):
            order = "<>"[(n // 2 + k) % 2]
            values = numbers(dtype=np.dtype(dtype))
            image = kind(values, LPS @ OBLIQUE, header=kind.header_class(endianness=order))
            image.set_data_dtype(np.dtype(dtype).newbyteorder(order))
            name = "in.img" if "Pair" in kind.__name__ else "in.nii" + (".gz" if n % 3 == 0 else "")
            nib.save(image, name)
            check(name, values, OBLIQUE)
    check("in.hdr", values, OBLIQUE)
    values = numbers((5, 4, 3, 2, 3), np.float32)
    for kind in (nib.Nifti1Image, nib.Nifti2Image):
        nib.save(kind(values, LPS @ OBLIQUE), "in.nii.gz")
        for n in range(6):
            check("in.nii.gz:%d" % n, values[..., n % 2, n // 2], OBLIQUE)
        check("in.nii.gz", values[..., 0, 0], OBLIQUE, says=["volume 0 of 6", "time"])
    open("in.nii", "wb").write(b"\0" * 400)
    refused("convert", "in.nii", "-o", "x.nii", says=["is no NIfTI"])


def case_nifti_of_others():
    """Files of Debian's packages, as nibabel reads them: the first and the last volume; CIFTI is no image."""
    folder = os.path.join(os.path.dirname(nib.__file__), "tests/data")
    names = [os.path.join(folder, name) for name in ("anatomical.nii", "functional.nii", "example4d.nii.gz", "example_nifti2.nii.gz",
                                                     "reoriented_anat_moved.nii", "resampled_anat_moved.nii", "standard.nii.gz")]
    names += ["/usr/share/mricron/templates/" + name for name in ("aal.nii.gz", "inia19-NeuroMaps.nii.gz", "jhu189.nii.gz")]
    names = [name for name in names if os.path.exists(name)]
    if not names:
        raise Skip("neither nibabel's test data nor mricron-data are there")
    for name in names:
        image = nib.load(name)
        volumes = int(np.prod(image.shape[3:]))
        for volume in sorted({0, volumes - 1}):
            at = np.unravel_index(volume, image.shape[3:], order="F") if volumes > 1 else ()
            expected = np.asanyarray(image.dataobj[(slice(None),) * 3 + tuple(at)])
            found, place, _ = converted(name + (":%d" % volume if volumes > 1 else ""))
            # Rescaled values are 32-bit floats: half a unit in their last place, of the largest.
            assert np.array_equal(np.isnan(found), np.isnan(expected)), name
            off = np.nanmax(np.abs(found - expected.astype(float)))
            assert off == 0 or (found.dtype == np.float32 and off <= 2.0 ** -24 * np.nanmax(np.abs(expected))), (name, off)
            assert np.abs(place - LPS @ image.affine).max() < 1e-4, (name, place)
    matrix = os.path.join(folder, "row_major.dconn.nii")
    if os.path.exists(matrix):
        refused("convert", matrix, "-o", "x.nii", says=["CIFTI"])


def case_nifti_places():
    """Units, and forms that disagree, are told."""
    values = numbers()
    for unit, factor in ((1, 1000), (2, 1), (3, 1e-3)):
        image = nib.Nifti1Image(values, LPS @ OBLIQUE)
        image.header["xyzt_units"] = unit
        nib.save(image, "in.nii")
        said = check("in.nii", values, np.diag([factor, factor, factor, 1]) @ OBLIQUE)
        assert ("became millimetres" in said) == (factor != 1), said
    moved = LPS @ OBLIQUE
    right = np.diag([1, 2, 3, 1.0])
    image = nib.Nifti1Image(values, right)
    image.set_qform(np.diag([1, 2, 3, 1.0]), 1), image.set_sform(moved, 4)
    nib.save(image, "in.nii")
    check("in.nii", values, OBLIQUE, says=["sform (code 4)", "qform (code 1)", "apart"])
    image.set_sform(right, 2)
    nib.save(image, "in.nii")
    assert "apart" not in check("in.nii", values, LPS @ right)
    image.set_sform(None, 0)
    for sign in (1, -1):
        turned = np.eye(4)
        turned[:3, :3] = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]]) @ np.diag([1, 2, 3 * sign])
        turned[:3, 3] = 5, -6, 7
        image.set_qform(turned, 1)
        nib.save(image, "in.nii")
        check("in.nii", values, LPS @ turned)


def forms_of(name):
    """Codes and transforms of a NIfTI header, as nibabel has them."""
    header = nib.load(name).header
    return [int(header[key]) for key in ("sform_code", "qform_code")] + [header.get_sform(), header.get_qform()]


def case_nifti_forms():
    """Codes and both transforms go from the input to what is written on its voxels; elsewhere the code of the space does."""
    values = numbers()
    values[1:4, 1:3, 1:] += 30000
    turned = np.eye(4)
    turned[:3, :3] = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]]) @ np.diag([1, 2, 3])
    turned[:3, 3] = 5, -6, 7
    for kind in (nib.Nifti1Image, nib.Nifti2Image):
        for sign in (1, -1):
            for s_code, q_code in ((1, 1), (4, 1), (2, 3), (3, 0), (0, 2), (5, 5)):
                image = kind(values, None)
                image.header.set_zooms((1, 2, 3))
                if s_code:
                    image.set_sform(LPS @ OBLIQUE, s_code)
                image.set_qform(turned @ np.diag([1, 1, sign, 1.0]), q_code)
                nib.save(image, "in.nii")
                run("convert", "in.nii", "-o", "out.nii.gz")
                before, after = forms_of("in.nii"), forms_of("out.nii.gz")
                assert before[:2] == after[:2] == [s_code, q_code], (s_code, q_code, after)
                for code, a, b in zip((s_code, q_code), before[2:], after[2:]):
                    assert code == 0 or np.allclose(a, b, atol=1e-5), (s_code, q_code, a, b)
                assert np.allclose(nib.load("out.nii.gz").affine, nib.load("in.nii").affine, atol=1e-5)
    # Other voxels: both transforms are those of the place that was taken, of its space.
    image = nib.Nifti1Image(values, None)
    image.set_qform(turned, 1), image.set_sform(turned, 4)
    nib.save(image, "in.nii")
    run("convert", "in.nii", "-o", "out.nii", "--voxel-size", 1)
    found = forms_of("out.nii")
    assert found[:2] == [4, 4] and np.allclose(found[2], found[3], atol=1e-5), found
    run("convert", "in.nii", "-o", "flat.nrrd"), run("convert", "flat.nrrd", "-o", "out.nii", "--like", "in.nii")
    assert forms_of("out.nii")[:2] == [4, 1], forms_of("out.nii")
    # A morph's frames have those of the first input.
    other = nib.Nifti1Image(np.roll(values, 1, 0), turned)
    other.set_sform(turned, 2)
    nib.save(other, "other.nii")
    # Placed elsewhere they are in no space that a code names.
    run("convert", "in.nii{scale=2}", "-o", "out.nii")
    assert forms_of("out.nii")[:2] == [1, 1], forms_of("out.nii")
    run("morph", "in.nii{scale=2}", "other.nii{scale=2}", "-o", "scaled.#.nii", "--frames", 3, "--align", "none", "--image", "grey")
    assert forms_of("scaled.2.nii")[:2] == [1, 1], forms_of("scaled.2.nii")
    for output, first in (("m.#.nii", "m.2.nii"), ("m.nii.gz", "m.nii.gz")):
        run("morph", "in.nii", "other.nii", "-o", output, "--frames", 3, "--align", "none", "--image", "grey", "--like", "in.nii")
        assert forms_of(first)[:2] == [4, 1], forms_of(first)


def case_time_steps():
    """The time from volume to volume goes through all formats that have one, in seconds where a unit is told."""
    values = numbers((5, 4, 3, 6))
    for unit, step, seconds in (("sec", 2.5, 2.5), ("msec", 720, 0.72), ("usec", 5e5, 0.5), ("unknown", 3, None)):
        image = nib.Nifti1Image(values, LPS @ OBLIQUE)
        image.header.set_xyzt_units("mm", unit)
        image.header["pixdim"][4] = step
        nib.save(image, "in.nii")
        for middle in ("a.nii", "a.nrrd", "a.mha"):
            run("convert", "in.nii@0-5", "-o", middle), run("convert", middle + "@1-5x2", "-o", "out.nii.gz")
            header = nib.load("out.nii.gz").header
            assert np.isclose(header.get_zooms()[3], 2 * (seconds or step)), (unit, middle, header.get_zooms())
            # MetaImage has no units of time.
            assert header.get_xyzt_units()[1] == ("unknown" if seconds is None or middle == "a.mha" else "sec"), (unit, middle)
            assert np.array_equal(np.asanyarray(nib.load("out.nii.gz").dataobj), values[..., 1::2])
    run("convert", "in.nii@0,1,3", "-o", "out.nii")
    assert nib.load("out.nii").header.get_zooms()[3] == 1  # not even: not told
    nrrd("in.nrrd", values, "space: LPS", directions(OBLIQUE, none_last=1), origin(OBLIQUE), "kinds: domain domain domain time",
         'spacings: nan nan nan 40', 'units: "" "" "" "ms"')
    # The format forbids a spacing for axes that have a direction alone.
    assert "forbids" not in run("convert", "in.nrrd@0-5", "-o", "out.nii")
    assert np.isclose(nib.load("out.nii").header.get_zooms()[3], 0.04) and nib.load("out.nii").header.get_xyzt_units()[1] == "sec"


def case_forbidden_fields():
    """Of axes with directions NRRD has no spacings, units, mins and maxs: told where there are such, never of other axes."""
    values = numbers((5, 4, 3, 2))
    place = "space: LPS", directions(OBLIQUE, none_last=1), origin(OBLIQUE), "kinds: domain domain domain time"
    for fields, named in ((("spacings: nan NaN nan 2", 'units: "" "" "" "s"', "axis mins: nan nan nan 0"), ()),
                          (("spacings: 1 nan nan 2", 'units: "" "" "" "s"'), ("spacings",)),
                          (("spacings: nan nan nan 2", 'units: "" "mm" "" "s"', "axis maxs: nan nan 5 nan"), ("units", "axis maxs"))):
        nrrd("in.nrrd", values, *place, *fields)
        said = run("convert", "in.nrrd@0-1", "-o", "out.nii")
        assert ("forbids" in said) == bool(named), (fields, said)
        for name in ("spacings", "units", "axis mins", "axis maxs"):
            assert ("'%s'" % name in said) == (name in named), (name, said)
        assert nib.load("out.nii").header.get_zooms()[3] == 2 and np.allclose(nib.load("out.nii").affine, LPS @ OBLIQUE, atol=1e-5)


def case_times_of_components():
    """Where volumes are times and components at once, no one time leads from each to the next."""
    values = numbers((5, 4, 3, 2, 3))
    image = nib.Nifti1Image(values, LPS @ OBLIQUE)
    image.header.set_xyzt_units("mm", "sec")
    image.header["pixdim"][4] = 2.5
    nib.save(image, "in.nii")
    nrrd("in.nrrd", values, "space: LPS", directions(OBLIQUE, none_last=2), origin(OBLIQUE), "kinds: domain domain domain time list",
         "spacings: nan nan nan 2.5 nan")
    raw = np.ascontiguousarray(values[..., 0].transpose(3, 2, 1, 0)).repeat(3, -1).tobytes()
    open("in.mha", "wb").write(b"ObjectType = Image\nNDims = 4\nBinaryData = True\nElementSpacing = 1 1 1 2.5\nDimSize = 5 4 3 2\n"
                               b"ElementNumberOfChannels = 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" + raw)
    for name in ("in.nii", "in.nrrd", "in.mha"):
        run("convert", name + "@0-5", "-o", "out.nii")
        header = nib.load("out.nii").header
        assert header.get_data_shape() == (5, 4, 3, 6) and header.get_zooms()[3] == 1 and header.get_xyzt_units()[1] == "unknown", (name, header)


def case_forced():
    """--force reads what no other option places, with a warning; the refusals name it."""
    values = numbers()

    def forced(name, affine, *says):
        refused("convert", name, "-o", "x.nii", says=["--force"])
        check(name, values, affine, "--force", says=["--force", *says])

    image = nib.Nifti1Image(values, None)
    image.header["sform_code"], image.header["srow_x"] = 1, (1, 0, 0, 0)
    image.header["pixdim"][1:4] = 2, 3, 4
    nib.save(image, "in.nii")
    forced("in.nii", np.diag([-2, -3, 4, 1]), "2 x 3 x 4 mm")
    nrrd("in.nrrd", values, "space: LPS", "space directions: (2,0,0) (0,3,0) (0,3,0)", "space origin: (1,2,3)")
    place = np.diag([2.0, 3, 3, 1])
    place[:3, 3] = 1, 2, 3
    forced("in.nrrd", place, "flatten space")
    with open("in.mha", "wb") as file:
        file.write(b"ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 1 0\nElementSpacing = 2 3 4\nDimSize = 5 4 3\n"
                   b"ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + values.astype("<i2").tobytes(order="F"))
    forced("in.mha", np.diag([2, 3, 4, 1]), "flatten space")
    pages = numbers((3, 4, 5), np.uint8)
    values = pages.T
    tiff("in.tif", pages, photometric="minisblack", metadata=None)
    forced("in.tif", np.eye(4), "1 x 1 x 1 mm")


def case_nifti_colours():
    """RGB and RGBA are luminance, or one of the colours; complex numbers have two parts."""
    rgb = numbers((5, 4, 3, 3), np.uint8)
    weights = [0.2126, 0.7152, 0.0722]
    grey = np.rint(rgb.astype(float) @ weights).astype(np.uint8)
    record = np.ascontiguousarray(rgb).view([("R", "u1"), ("G", "u1"), ("B", "u1")])[..., 0]
    nib.save(nib.Nifti1Image(record, LPS @ OBLIQUE), "in.nii")
    check("in.nii", grey, OBLIQUE, says=["luminance"])
    check("in.nii:2", rgb[..., 2], OBLIQUE)
    values = (numbers() + 1j * numbers(seed=2)).astype(np.complex64)
    nib.save(nib.Nifti1Image(values, LPS @ OBLIQUE), "in.nii")
    check("in.nii", values.real, OBLIQUE, says=["real and imaginary"])
    check("in.nii:1", values.imag, OBLIQUE)
    raw = bytearray(open("in.nii", "rb").read())
    raw[70:74] = b"\0\6\x80\0"  # datatype 1536, 128 bits
    open("in.nii", "wb").write(raw)
    refused("convert", "in.nii", "-o", "x.nii", says=["FLOAT128"])


def case_analyze():
    """Analyze 7.5: as nibabel places it, with a warning; SPM's origin and scale."""
    values = numbers((6, 5, 4))
    for kind in (nib.AnalyzeImage, nib.Spm99AnalyzeImage, nib.Spm2AnalyzeImage):
        for order in "<>":
            header = kind.header_class(endianness=order)
            header.set_data_dtype(np.int16), header.set_data_shape(values.shape), header.set_zooms((1, 2, 3))
            if kind is not nib.AnalyzeImage:
                header["origin"][:3] = 3, 2, 2
            image = kind(values, None, header)
            nib.save(image, "in.img")
            if os.path.exists("in.mat"):
                os.remove("in.mat")
            check("in.img", values, LPS @ nib.load("in.img").affine, says=["Analyze 7.5", "left from right"])
    raw = bytearray(open("in.hdr", "rb").read())
    raw[252] = 9
    open("in.hdr", "wb").write(raw)
    refused("convert", "in.img", "-o", "x.nii", says=["orientation 9"])


def tiff(name, pages, **options):
    try:
        import tifffile
    except ImportError:
        raise Skip("python3-tifffile is not installed")
    tifffile.imwrite(name, pages, **options)


def png(name, grey, bits):
    """A grey PNG of 1, 2 or 4 bits a pixel, of whole bytes in a row."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b""
    for row in grey:
        spread = np.unpackbits(row[:, None], axis=1)[:, 8 - bits:].ravel()
        rows += b"\0" + np.packbits(spread).tobytes()
    head = struct.pack(">IIBBBBB", grey.shape[1], grey.shape[0], bits, 0, 0, 0, 0)
    open(name, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def case_tiff_types():
    """Whole numbers of 8 to 32 bits are themselves, also where 0 is white or fewer bits are stored."""
    for dtype in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        pages = np.random.RandomState(2).randint(0, 120, (3, 4, 5)).astype(dtype)
        if dtype in ("u4", "i4"):
            pages[0, 0, 0] = 2000000000
        if dtype[0] == "i":
            pages[1, 1, 1] = -100
        tiff("in.tif", pages, byteorder=">" if dtype[1] == "2" else "<", photometric="minisblack", metadata=None)
        check("in.tif", pages.T, np.diag([1, 2, 3, 1]), "--spacing", "1,2,3")
    pages = numbers((3, 4, 5), np.uint32)
    pages[0, 0, 0] = 4000000000
    tiff("in.tif", pages, photometric="minisblack", metadata=None)
    check("in.tif", pages.T.astype(float), np.diag([1, 2, 3, 1]), "--spacing", "1,2,3")
    for dtype in (np.uint8, np.uint16):
        tiff("in.tif", numbers((3, 4, 5), dtype), photometric="miniswhite", metadata=None)
        check("in.tif", numbers((3, 4, 5), dtype).T, np.diag([1, 2, 3, 1]), "--spacing", "1,2,3", says=["as stored"])
    os.mkdir("split")
    for n in range(3):
        tiff("split/p.%d.tif" % n, numbers((3, 4, 5), np.uint32)[n], photometric="minisblack")
    check("split/p.#.tif", numbers((3, 4, 5), np.uint32).T, np.diag([1, 2, 3, 1]), "--spacing", "1,2,3")
    for bits in (1, 2, 4):
        grey = np.random.RandomState(bits).randint(0, 1 << bits, (4, 8)).astype(np.uint8)
        png("p.0.png", grey, bits)
        check("p.#.png", grey.T[..., None], np.diag([1, 2, 3, 1]), "--spacing", "1,2,3")
    tiff("in.tif", numbers((3, 4, 5), np.uint64), photometric="minisblack", metadata=None)
    assert refused("convert", "in.tif", "-o", "x.nii", "--spacing", "1,2,3").count("in.tif") == 1


def one_page(name, pages, description, order=">", short=0):
    """A TIFF of one page, with more pictures behind the first as ImageJ keeps large stacks."""
    body = pages.astype(pages.dtype.newbyteorder(order)).tobytes()
    text = description.encode() + b"\0"
    entries = [(256, 3, 1, pages.shape[2]), (257, 3, 1, pages.shape[1]), (258, 3, 1, 8 * pages.itemsize), (259, 3, 1, 1), (262, 3, 1, 1),
               (270, 2, len(text), None), (273, 4, 1, None), (277, 3, 1, 1), (278, 3, 1, pages.shape[1]),
               (279, 4, 1, pages.shape[1] * pages.shape[2] * pages.itemsize), (282, 5, 1, None), (283, 5, 1, None), (296, 3, 1, 1),
               (339, 3, 1, 3 if pages.dtype.kind == "f" else 1)]
    after = 8 + 2 + 12 * len(entries) + 4
    places = {270: after, 282: after + len(text), 283: after + len(text) + 8, 273: after + len(text) + 16}
    head = (b"MM" if order == ">" else b"II") + struct.pack(order + "HI", 42, 8) + struct.pack(order + "H", len(entries))
    for tag, kind, count, value in entries:
        value = places.get(tag, value)
        small = kind == 3
        head += struct.pack(order + "HHI", tag, kind, count) + (struct.pack(order + "HH", value, 0) if small else struct.pack(order + "I", value))
    head += struct.pack(order + "I", 0) + text + struct.pack(order + "IIII", 4, 1, 2, 1)
    data = head + body
    open(name, "wb").write(data[:len(data) - short])


def case_tiff_imagej():
    """ImageJ: all pictures behind one page, spacing, channels and times."""
    for dtype, order in ((np.uint8, "<"), (np.uint16, ">"), (np.float32, "<")):
        pages = numbers((6, 4, 5), dtype)
        one_page("in.tif", pages, "ImageJ=1.53t\nimages=6\nslices=6\nunit=mm\nspacing=2.5\n", order)
        check("in.tif", pages.T, np.diag([0.25, 0.5, 2.5, 1]), says=["ImageJ"])
    check("in.tif", pages.T, np.diag([1, 2, 3, 1]), "--spacing", "1,2,3")
    one_page("in.tif", pages, "ImageJ=1.53t\nimages=6\nslices=6\nunit=\\u00B5m\nspacing=2.5\n")
    check("in.tif", pages.T, np.diag([0.25e-3, 0.5e-3, 2.5e-3, 1]))
    one_page("in.tif", pages, "ImageJ=1.53t\nimages=6\nslices=6\nunit=pixel\n")
    refused("convert", "in.tif", "-o", "x.nii", says=["--spacing"])
    one_page("in.tif", pages, "ImageJ=1.53t\nimages=6\nslices=6\nunit=mm\n", short=5)
    refused("convert", "in.tif", "-o", "x.nii", says=["6 pictures"])
    one_page("in.tif", pages, "ImageJ=1.53t\nimages=6\nslices=4\nunit=mm\n")
    refused("convert", "in.tif", "-o", "x.nii", says=["6 images"])
    hyper = numbers((2, 3, 4, 5, 6), np.uint16)  # times, slices, channels, rows, columns
    tiff("hyper.tif", hyper, imagej=True, resolution=(4, 2), metadata={"spacing": 3, "unit": "mm", "axes": "TZCYX"})
    one_page("one.tif", hyper.reshape(-1, 5, 6), "ImageJ=1.53t\nimages=24\nchannels=4\nslices=3\nframes=2\nunit=mm\nspacing=3\n")
    for name in ("hyper.tif", "one.tif"):
        check(name, hyper[0, :, 0].T, np.diag([0.25, 0.5, 3, 1]), says=["volume 0 of 8", "channel, time"])
        check(name + ":6", hyper[1, :, 2].T, np.diag([0.25, 0.5, 3, 1]))
        refused("convert", name + ":8", "-o", "x.nii", says=["no volume 8"])


def case_tiff_ome():
    """OME-TIFF: spacing in micrometres, channels and times in the order it tells."""
    values = numbers((2, 3, 4, 5, 6), np.uint16)  # times, channels, slices, rows, columns
    tiff("in.ome.tif", values, photometric="minisblack",
         metadata={"axes": "TCZYX", "PhysicalSizeX": 250.0, "PhysicalSizeY": 500.0, "PhysicalSizeZ": 2000.0})
    check("in.ome.tif", values[0, 0].T, np.diag([0.25, 0.5, 2, 1]), says=["volume 0 of 6"])
    check("in.ome.tif:5", values[1, 2].T, np.diag([0.25, 0.5, 2, 1]))
    # Colours of a page count as its channels.
    rgb = numbers((2, 4, 5, 6, 3), np.uint8)
    grey = np.rint(rgb.astype(float) @ [0.2126, 0.7152, 0.0722]).astype(np.uint8)
    for axes, pages, expected in (("TZYXS", rgb, grey[0]), ("ZYXS", rgb[0], grey[0]), ("YXS", rgb[0, 0], grey[0, :1])):
        tiff("in.ome.tif", pages, photometric="rgb", metadata={"axes": axes, "PhysicalSizeX": 250.0, "PhysicalSizeY": 500.0, "PhysicalSizeZ": 2000.0})
        check("in.ome.tif", expected.T, np.diag([0.25, 0.5, 2, 1]), says=["luminance"])
        if axes[0] == "T":
            check("in.ome.tif:1", grey[1].T, np.diag([0.25, 0.5, 2, 1]))
    sizes = '<OME><Image><Pixels DimensionOrder="%s" SizeZ="%d" SizeC="%d" SizeT="%d"/></Image></OME>'
    most = 10 ** 7
    for fields in (("XYZCT", most, most, most), ("XYZCT", 1 << 16, 1 << 16, 1), ("XYZZZ", 6, 1, 1), ("XY", 6, 1, 1)):
        one_page("in.tif", numbers((6, 4, 5), np.uint8), sizes % fields)
        refused("convert", "in.tif", "-o", "x.nii", "--spacing", "1,2,3", says=["makes no sense" if fields[1] > 6 else "DimensionOrder"])
    one_page("in.tif", numbers((6, 4, 5), np.uint8), "ImageJ=1.53t\nimages=6\nchannels=%d\nframes=%d\n" % (1 << 16, 1 << 16))
    refused("convert", "in.tif", "-o", "x.nii", "--spacing", "1,2,3", says=["6 images"])


def exr(name, picture, x, y, width, height):
    """A picture at x, y of a display window."""
    from OpenImageIO import FLOAT, ImageOutput, ImageSpec
    spec = ImageSpec(picture.shape[1], picture.shape[0], 1, FLOAT)
    spec.channelnames = ("Y",)
    spec.x, spec.y, spec.full_width, spec.full_height = x, y, width, height
    out = ImageOutput.create(name)
    assert out.open(name, spec), out.geterror()
    out.write_image(picture[..., None].astype(np.float32))
    out.close()


def case_exr_windows():
    """Pixels lie by the data window in the display window, 0 outside; what is beyond is left out with a warning."""
    random = np.random.RandomState(3)
    expected = np.zeros((6, 5, 4), np.float32)
    for k, (x, y, w, h) in enumerate(((0, 0, 6, 5), (1, 2, 3, 2), (5, 4, 1, 1), (2, 0, 4, 5))):
        picture = random.rand(h, w).astype(np.float32)
        exr("s.%d.exr" % k, picture, x, y, 6, 5)
        expected[x:x + w, y:y + h, k] = picture.T
    from OpenImageIO import ImageBuf
    for k in range(4):
        subprocess.run(["oiiotool", "s.%d.exr" % k, "--crop", "6x5+0+0", "-o", "whole.%d.tif" % k], check=True, capture_output=True)
        assert np.array_equal(ImageBuf("whole.%d.tif" % k).get_pixels()[..., 0].T, expected[..., k]), k
    check("s.#.exr", expected, np.diag([1, 1, 2, 1]), "--spacing", "1,1,2")
    exr("b.0.exr", np.arange(63, dtype=np.float32).reshape(7, 9), -1, -2, 6, 5)
    check("b.#.exr", np.arange(63, dtype=np.float32).reshape(7, 9)[2:, 1:7].T[..., None], np.diag([1, 1, 2, 1]), "--spacing", "1,1,2", says=["outside the display window"])


def case_exr_found_stacks():
    """Stacks whose windows move or are cropped from picture to picture, once read wrongly, against OpenImageIO."""
    from OpenImageIO import ROI, ImageBuf, ImageBufAlgo
    for stack in ("09_exr_moving", "09_exr_autocrop"):
        folder = os.path.join(FAULTS, stack)
        if not os.path.isdir(folder):
            raise Skip(stack + " is not there")
        pictures = []
        for name in sorted(os.listdir(folder)):
            whole = ImageBufAlgo.crop(ImageBuf(os.path.join(folder, name)), ROI(0, 40, 0, 36))
            pictures.append(whole.get_pixels()[..., 0].T)
        expected = np.stack(pictures, -1)
        assert expected.any() and expected.shape == (40, 36, 24)
        check(os.path.join(folder, "s.####.exr"), expected, np.diag([1, 1, 2, 1]), "--spacing", "1,1,2")


def case_not_finite():
    """NaN and infinity are kept by formats that hold them, and info tells how many there are."""
    values = numbers(dtype=np.float32)
    values[0, 0, 0], values[1, 0, 0], values[2, 0, 0] = np.nan, np.inf, -np.inf
    nib.save(nib.Nifti1Image(values, LPS @ OBLIQUE), "in.nii")
    for name in ("a.nii.gz", "a.nrrd", "a.mha"):
        said = run("convert", "in.nii", "-o", name)
        run("convert", name, "-o", "back.nii")
        assert np.array_equal(np.asanyarray(nib.load("back.nii").dataobj), values, equal_nan=True), name
    assert "3 of its 60 values are not finite" in said, said


def case_float_labels():
    """Labels stored as floats within 1e-3 of whole numbers are labels; others are refused as such, and told to be taken as grey."""
    labels = np.zeros((20, 20, 20), np.float32)
    labels[5:15, 5:15, [4, 8, 12]] = 2.9995
    labels[7:12, 7:12, [4, 8, 12]] = 5.0004
    nib.save(nib.Nifti1Image(labels, LPS), "in.nii")
    said = run("reconstruct", "in.nii", "-o", "out.nii")
    found = np.asanyarray(nib.load("out.nii").dataobj)
    assert set(np.unique(found)) == {0, 3, 5} and found[9, 9, 6] == 5 and found[6, 6, 6] == 3, np.unique(found)
    assert "whole numbers" in said, said
    told = json.loads(program.run("info", "in.nii", "--json").stdout)
    assert told["images"][0]["labels"] == 2, told
    labels[labels > 4] = 5.01
    nib.save(nib.Nifti1Image(labels, LPS), "in.nii")
    refused("reconstruct", "in.nii", "-o", "x.nii", "--image", "labels", says=["whole numbers"])
    assert "taken as grey" in run("reconstruct", "in.nii", "-o", "x.nii")


def case_info():
    """`info` names what was found, as JSON."""
    nrrd("in.nrrd", numbers((5, 4, 3, 2)), "space: RAS", directions(OBLIQUE, none_last=1), origin(OBLIQUE), "kinds: domain domain domain time", encoding="bzip2")
    told = json.loads(program.run("info", "in.nrrd", "--json").stdout)
    image = told["images"][0]
    assert image["volumes"] == 2 and image["size"] == [5, 4, 3], image
    assert np.allclose(image["origin"], [-10, 20, 30]), image


def large_dicom(path, k=None):
    """A file of 512 x 512 x 512 voxels of 1 mm that are not on the disk, or its slice k."""
    frames = [item(**plane) for plane in ({"PlanePositionSequence": [item(ImagePositionPatient=[0, 0, n])]} for n in range(512 if k is None else 0))]
    d = dcm.data_set(path, dcm.ENHANCED_CT if k is None else dcm.CT, np.zeros((2, 512, 512) if k is None else (512, 512), np.int16), signed=True,
                     RescaleSlope="1", RescaleIntercept="0")
    if k is None:
        d.NumberOfFrames = "512"
        d.PerFrameFunctionalGroupsSequence = frames
        d.SharedFunctionalGroupsSequence = [item(PlaneOrientationSequence=[item(ImageOrientationPatient=[1, 0, 0, 0, 1, 0])],
                                                 PixelMeasuresSequence=[item(PixelSpacing=[1, 1], SliceThickness=1)])]
    else:
        d.ImagePositionPatient, d.ImageOrientationPatient, d.PixelSpacing = [0, 0, k], [1, 0, 0, 0, 1, 0], [1, 1]
    dcm.save(d)
    if k is None:  # the length of the pixels stands before them, at the end
        size = os.path.getsize(path) - 2 * 2 * 512 ** 2
        with open(path, "r+b") as file:
            file.seek(size - 4)
            file.write(struct.pack("<I", 2 * 512 ** 3))
            file.truncate(size + 2 * 512 ** 3)


def case_info_refused():
    """What is refused, or has no spacing, has no place in `info`."""
    for k in range(3):
        d = dcm.data_set("series/%d.dcm" % k, dcm.CT, numbers((4, 5)), PixelSpacing=[1, 1], InstanceNumber=k)
        dcm.save(d)
        d.filename, d.SeriesInstanceUID = "series/other%d.dcm" % k, "1.2.3.10"
        d.ImagePositionPatient, d.ImageOrientationPatient = [0, 0, k], [1, 0, 0, 0, 1, 0]
        dcm.save(d)
    tiff("in.tif", numbers((3, 4, 5), np.uint8), photometric="minisblack", metadata=None)
    told = [json.loads(program.run("info", name, "--json").stdout)["images"] for name in ("series", "in.tif")]
    readings = sorted((image["reading"][:7], image["spacing"] is None, image["origin"] is None, image["axes"] is None) for image in sum(told, []))
    assert [reading[1:] for reading in readings if reading[0] in ("refused", "cannot ")] == [(True,) * 3] * 2 and len(readings) == 3, readings
    assert "spacing" not in program.run("info", "in.tif").stdout.split("read as")[0]


def case_info_large():
    """Of a large volume `info` reads the header only: less memory than its values would take."""
    def told(*arguments):
        with open("told.json", "w") as output:
            process = subprocess.Popen([program.path, "info", *arguments, "--json"], stdout=output)
            _, status, used = os.wait4(process.pid, 0)
        assert status == 0, arguments
        return json.load(open("told.json"))["images"][0], used.ru_maxrss  # kB

    dcm.save(dcm.data_set("small.dcm", dcm.CT, numbers((4, 5)), PixelSpacing=[1, 1]))
    tiff("small.tif", np.zeros((4, 512, 512), np.uint8), photometric="minisblack", metadata=None)
    least = [told("small.dcm")[1], told("small.tif", "--spacing", "1,1,1")[1]]
    for name, dtype in (("in.nii", np.int16), ("in.nrrd", np.int16), ("in.mhd", np.int16), ("in.dcm", np.int16), ("slices", np.int16),
                        ("in.tif", np.uint8)):
        options = []
        if name == "in.nii":
            header = nib.Nifti1Header()
            header.set_data_dtype(dtype), header.set_data_shape((512, 512, 512)), header.set_sform(LPS, 1)
            header["magic"], header["vox_offset"] = b"n+1", 352
            head = header.binaryblock + b"\0\0\0\0"
        elif name == "in.nrrd":
            nrrd(name, np.zeros((1, 1, 1), dtype), "space: LPS", directions(np.eye(4)), origin(np.eye(4)))
            head = open(name, "rb").read()[:-2].replace(b"sizes: 1 1 1", b"sizes: 512 512 512")
        elif name == "in.mhd":
            head = b"ObjectType = Image\nNDims = 3\nBinaryData = True\nElementSpacing = 1 1 1\nDimSize = 512 512 512\n" \
                   b"ElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        if name == "in.dcm":
            large_dicom(name)
        elif name == "slices":
            os.mkdir(name)
            for k in range(512):
                large_dicom("slices/%03d.dcm" % k, k)
        elif name == "in.tif":
            tiff(name, np.zeros((512, 512, 512), dtype), photometric="minisblack", metadata=None)
            options = ["--spacing", "1,1,1"]
        else:
            with open(name, "wb") as file:
                file.write(head)
                file.truncate(len(head) + 2 * 512 ** 3)
        image, memory = told(name, *options)
        assert image["size"] == [512] * 3 and image["minimum"] is None, (name, image)
        assert image["type"] == np.dtype(dtype).name and np.allclose(image["spacing"], 1), image
        # What the program takes with a small image of the format, and a share of the values' 128 or 256 MB.
        assert "header" in image["reading"] and memory < least[name == "in.tif"] + 2 ** 15, (name, memory, least, image)
        shutil.rmtree(name) if os.path.isdir(name) else os.remove(name)


def case_info_doubled():
    """A large series of which half are doubles is one whose header alone is read, though fewer voxels are left."""
    for k in range(260):
        large_dicom("twice/%03d.dcm" % k, k // 2)
    image = json.loads(program.run("info", "twice", "--json").stdout)["images"][0]
    assert image["size"] == [512, 512, 130] and np.allclose(image["spacing"], 1) and "header" in image["reading"], image
    shutil.rmtree("twice")


def case_times():
    """Volumes that are named by a range are one file of four dimensions; sizes beyond 16 bits become NIfTI-2."""
    values = numbers((5, 4, 3, 6))
    nib.save(nib.Nifti1Image(values, LPS @ OBLIQUE), "in.nii")
    run("convert", "in.nii@1-5x2", "-o", "out.nii.gz")
    image = nib.load("out.nii.gz")
    assert np.array_equal(np.asanyarray(image.dataobj), values[..., 1::2]) and np.allclose(image.affine, LPS @ OBLIQUE, atol=1e-4)
    run("convert", "in.nii@1-5x2", "-o", "out.nrrd")
    head, packed = open("out.nrrd", "rb").read().split(b"\n\n", 1)
    for field in (b"dimension: 4", b"sizes: 5 4 3 3", b"kinds: domain domain domain time", b") none\n"):
        assert field in head, head
    assert np.array_equal(np.frombuffer(gzip.decompress(packed), "<i2").reshape((5, 4, 3, 3), order="F"), values[..., 1::2])
    run("convert", "in.nii@1-5x2", "-o", "out.mha")
    head, packed = open("out.mha", "rb").read().split(b"LOCAL\n", 1)
    for field in (b"NDims = 4", b"DimSize = 5 4 3 3"):
        assert field in head, head
    assert np.array_equal(np.frombuffer(zlib.decompress(packed), "<i2").reshape((5, 4, 3, 3), order="F"), values[..., 1::2])
    for name in ("out.nrrd", "out.mha"):
        check(name + ":2", values[..., 5], OBLIQUE)
        check(name + "@2", values[..., 5], OBLIQUE)
    check("in.nii@4", values[..., 4], OBLIQUE)
    refused("convert", "in.nii@4-6", "-o", "x.nii", says=["no volume 6"])
    refused("convert", "in.nii@0-3:2", "-o", "x.nii", says=["'@0-3'", "':2'", "@0-8x2"])
    refused("convert", "in.nii@0-1", "-o", "x.ply", says=["2 volumes"])
    long = numbers((40000, 2, 1), np.uint8)
    nrrd("long.nrrd", long, "space: LPS", directions(np.eye(4)), origin(np.eye(4)))
    run("convert", "long.nrrd", "-o", "long.nii")
    image = nib.load("long.nii")
    assert type(image) is nib.Nifti2Image and np.array_equal(np.asanyarray(image.dataobj), long) and np.allclose(image.affine, LPS)


def case_times_of_one_type():
    """All volumes of a file become one type, whatever the values of each, as they are rescaled or too large for 32 bits."""
    values = numbers((5, 4, 3, 3), np.int16)
    values[..., 1] += 20000
    values[..., 2] -= 20000
    nib.save(nib.Nifti1Image(values, LPS), "in.nii")
    raw = bytearray(open("in.nii", "rb").read())
    for slope, intercept in ((3, 0), (1, -1024), (0.5, 1)):
        raw[112:120] = struct.pack("<ff", slope, intercept)
        open("in.nii", "wb").write(raw)
        expected = np.asanyarray(nib.load("in.nii").dataobj)
        run("convert", "in.nii@0-2", "-o", "out.nii")
        assert np.array_equal(np.asanyarray(nib.load("out.nii").dataobj), expected), (slope, intercept)
        for volume in range(3):
            check("in.nii:%d" % volume, expected[..., volume], np.eye(4))
    for dtype, large in ((np.uint32, 4 * 10 ** 9), (np.int64, -2 ** 40), (np.uint64, 2 ** 40)):
        values = numbers((5, 4, 3, 3), dtype)
        values[0, 0, 0, 1] = large
        nib.save(nib.Nifti1Image(values, LPS, dtype=dtype), "in.nii")
        nrrd("in.nrrd", values, "space: LPS", directions(np.eye(4), none_last=1), origin(np.eye(4)), "kinds: domain domain domain time")
        for name in ("in.nii", "in.nrrd"):
            run("convert", name + "@0-2", "-o", "out.nii")
            assert np.array_equal(np.asanyarray(nib.load("out.nii").dataobj), values.astype(float)), (name, dtype)


def case_times_morph():
    """A range of volumes is a sequence: each frame of a morph takes the next; its ends are the first and the last volume."""
    grid = np.stack(np.meshgrid(*map(np.arange, (30, 26, 20)), indexing="ij"), -1)
    for name, radius, centre in (("a.nii", 5, (14, 12, 9)), ("b.nii", 7, (10, 12, 9))):
        balls = [(np.linalg.norm(grid - centre - (t, 0, 0), axis=-1) < radius + t / 2).astype(np.uint8) for t in range(3)]
        nib.save(nib.Nifti1Image(np.stack(balls, -1), LPS), name)
    run("morph", "a.nii@0-2", "b.nii@0-2", "-o", "m.#.nii", "--frames", 3)
    for frame, name, volume in ((1, "a.nii", 0), (3, "b.nii", 2)):
        expected = np.asanyarray(nib.load(name).dataobj)[..., volume]
        assert np.array_equal(np.asanyarray(nib.load("m.%d.nii" % frame).dataobj), expected), (frame, name)


sys.exit(run_within(globals(), ONLY))
