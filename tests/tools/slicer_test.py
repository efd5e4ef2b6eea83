#!/usr/bin/env python3
"""The command-line modules of 3D Slicer, driven from their own descriptions as Slicer drives them.

usage: slicer_test.py FOLDER_OF_MODULES PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)

Needs Debian's python3-lxml, python3-nibabel and python3-pydicom.
"""
import glob
import gzip
import os
import re
import signal
import subprocess
import sys
import time

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
import pydicom
from lxml import etree
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.join(HERE, "..", "support"))
from cases import run_within
from program import Program
from slicer import Module
from vtp import is_closed, read_vtp, volume_of

if len(sys.argv) < 3:
    sys.exit(__doc__)
FOLDER, PROGRAM, ONLY = os.path.abspath(sys.argv[1]), Program(sys.argv[2]), sys.argv[3:]
MORPH, FILL, SURFACE = (Module(os.path.join(FOLDER, "Slicemorph" + name)) for name in ("Morph", "FillBetweenSlices", "Surface"))
MODULES = (MORPH, FILL, SURFACE)

# Voxels of an oblique scan: steps in LPS millimetres, the columns of STEPS, from ORIGIN.
SPACING = np.array([1.0, 1.25, 1.5])
TURN = 0.3
STEPS = np.array([[np.cos(TURN), -np.sin(TURN), 0], [np.sin(TURN), np.cos(TURN), 0], [0, 0, 1]]) * SPACING
ORIGIN = np.array([-40.0, 25.0, 110.0])
SHAPE = (48, 40, 32)
QUICK = {"resolution": "24", "slices": "12", "samples": "16"}  # of meshes whose shape does not matter


# -- files as Slicer writes them --------------------------------------------------------------------------------------
def write_nrrd(path, values):
    """As Slicer writes a volume (i, j, k): in LPS, packed."""
    kind = {"int16": "short", "uint8": "unsigned char", "float32": "float"}[values.dtype.name]
    vector = lambda v: "(%s)" % ",".join("%.17g" % x for x in v)
    lines = ["NRRD0004", "# Complete NRRD file format specification at:", "# http://teem.sourceforge.net/nrrd/format.html",
             "type: " + kind, "dimension: 3", "space: left-posterior-superior", "sizes: %d %d %d" % values.shape,
             "space directions: " + " ".join(vector(STEPS[:, a]) for a in range(3)), "kinds: domain domain domain", "endian: little",
             "encoding: gzip", "space origin: " + vector(ORIGIN), "", ""]
    open(path, "wb").write("\n".join(lines).encode() + gzip.compress(values.tobytes(order="F")))
    return path


def read_nrrd(path):
    """Values (i, j, k), steps as columns and origin in LPS, of the NRRDs that are tried here."""
    head, body = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines() if ": " in line)
    assert fields["space"] in ("left-posterior-superior", "LPS"), fields
    kind = {"short": "<i2", "int16": "<i2", "uchar": "u1", "unsigned char": "u1", "uint8": "u1", "float": "<f4"}[fields["type"]]
    vectors = lambda text: np.array([[float(x) for x in part.split(",")] for part in re.findall(r"\((.*?)\)", text)])
    data = gzip.decompress(body) if fields["encoding"] in ("gzip", "gz") else body
    size = [int(n) for n in fields["sizes"].split()]
    return (np.frombuffer(data, kind).reshape(size, order="F"), vectors(fields["space directions"]).T, vectors(fields["space origin"])[0])


def check_place(path):
    """Whether an image lies where the scan does; returns its values."""
    values, steps, origin = read_nrrd(path)
    assert values.shape == SHAPE and np.allclose(steps, STEPS, atol=1e-6) and np.allclose(origin, ORIGIN, atol=1e-4), (steps, origin)
    return values


def write_ply(path, radius, middle, n=20):
    """A ball as Slicer's VTK writes a model: binary, its coordinate system in a comment."""
    u, v = np.meshgrid(np.linspace(0, np.pi, n + 1)[1:-1], np.linspace(0, 2 * np.pi, 2 * n, endpoint=False), indexing="ij")
    rings = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], -1).reshape(-1, 3)
    points = np.concatenate([[[0, 0, 1]], rings, [[0, 0, -1]]]) * radius + middle
    at = lambda i, j: 0 if i == 0 else len(points) - 1 if i == n else 1 + (i - 1) * 2 * n + j % (2 * n)
    faces = [(at(i, j), at(i + 1, j), at(i + 1, j + 1)) for i in range(n - 1) for j in range(2 * n)]
    faces += [(at(i, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(1, n) for j in range(2 * n)]
    head = "\n".join(["ply", "format binary_little_endian 1.0", "comment 3D Slicer output. SPACE=LPS",
                      "obj_info vtkPolyData points and polygons: vtk4.0", "element vertex %d" % len(points), "property float x",
                      "property float y", "property float z", "element face %d" % len(faces),
                      "property list uchar int vertex_indices", "end_header", ""])
    table = np.zeros(len(faces), [("n", "u1"), ("at", "<i4", 3)])
    table["n"], table["at"] = 3, faces
    open(path, "wb").write(head.encode() + points.astype("<f4").tobytes() + table.tobytes())
    return path


# -- phantoms ---------------------------------------------------------------------------------------------------------
def distances(middle):
    """From each voxel to a point, which is given in voxels from the middle of the scan; millimetres."""
    index = np.stack(np.meshgrid(*map(np.arange, SHAPE), indexing="ij"), -1) - (np.array(SHAPE) - 1) / 2 - middle
    return np.sqrt(((index * SPACING)**2).sum(-1))


def ball_volume(radius):
    return 4 / 3 * np.pi * radius**3


def radius_of(volume):
    return (3 * volume / (4 * np.pi))**(1 / 3)


def drawn(labels, every=4):
    """Only each n-th slice along k."""
    sparse = np.zeros_like(labels)
    sparse[:, :, ::every] = labels[:, :, ::every]
    return sparse


def two_labels():
    labels = np.zeros(SHAPE, np.int16)
    labels[distances((-9, 0, 0)) < 11] = 3
    labels[distances((13, 4, 2)) < 8] = 7
    return labels


def place(index):
    """Of a voxel from the scan's middle, LPS."""
    return STEPS @ (np.array(index, float) + (np.array(SHAPE) - 1) / 2) + ORIGIN


def write_structure_set(path):
    """Two cylinders along z, of radius 10 and 6, by name, on planes 3 apart."""
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = "1.2.840.10008.5.1.4.1.1.481.3", generate_uid()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, False
    d.SOPClassUID, d.SOPInstanceUID, d.Modality = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID, "RTSTRUCT"
    d.StudyInstanceUID = d.SeriesInstanceUID = d.FrameOfReferenceUID = "1.2.3"
    d.PatientName, d.PatientID, d.StructureSetLabel = "none", "none", "set"
    d.StructureSetROISequence, d.ROIContourSequence, d.RTROIObservationsSequence = Sequence(), Sequence(), Sequence()
    angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    for number, (name, x, radius) in enumerate((("Heart", 0, 10), ("Left lung", 40, 6)), 1):
        region, contours, observation = Dataset(), Dataset(), Dataset()
        region.ROINumber, region.ROIName, region.ReferencedFrameOfReferenceUID, region.ROIGenerationAlgorithm = number, name, "1.2.3", ""
        contours.ReferencedROINumber, contours.ContourSequence = number, Sequence()
        for z in np.arange(0, 31, 3):
            ring, points = Dataset(), np.stack([x + radius * np.cos(angles), radius * np.sin(angles), np.full(96, z)], -1)
            ring.ContourGeometricType, ring.NumberOfContourPoints = "CLOSED_PLANAR", len(points)
            ring.ContourData = ["%.5f" % v for v in points.ravel()]
            contours.ContourSequence.append(ring)
        d.StructureSetROISequence.append(region)
        d.ROIContourSequence.append(contours)
        observation.ObservationNumber = observation.ReferencedROINumber = number
        observation.RTROIInterpretedType, observation.ROIInterpreter = "ORGAN", ""
        d.RTROIObservationsSequence.append(observation)
    d.save_as(path, write_like_original=False)
    return path


def heard(result, title):
    """Progress goes from 0 to 1 and never back, in the tags that Slicer looks for; nothing is taken for an error."""
    assert result.progress[0] == 0 and result.progress[-1] == 1 and result.progress == sorted(result.progress), result.progress
    assert result.names == ["Slicemorph: " + title] * 2 and result.comments and result.ended and result.time[0] >= 0
    assert result.errors == "" and "<" not in result.text, (result.errors, result.text)
    return result


# -- descriptions -----------------------------------------------------------------------------------------------------
def case_descriptions():
    """Each is as the schema says, and as Slicer needs it beyond that."""
    schema = etree.RelaxNG(etree.parse(os.path.join(HERE, "slicer_module.rng")))
    for module in MODULES:
        tree = etree.fromstring(module.xml.encode())
        assert schema.validate(tree), (module.name, schema.error_log)
        names = [e.findtext("name") for e in module.parameters()]
        assert len(set(names)) == len(names) and not set(names) & {"xml", "help", "version", "returnparameterfile"}, names
        for e in module.parameters():
            name, default = e.findtext("name"), e.findtext("default")
            choices = [choice.text for choice in e.findall("element")]
            assert not choices or (default in choices and len(set(choices)) == len(choices)), (name, default, choices)
            limits = e.find("constraints")
            if limits is not None:
                assert float(limits.findtext("minimum")) <= float(default) <= float(limits.findtext("maximum")), (name, default)
            assert e.get("reference") is None or module.parameter(e.get("reference")).findtext("channel") == "input", name
        assert module.answers() == ["remarks"]
        assert module.root.findtext("version") in PROGRAM.run("--version").stdout


def case_schema_refuses():
    """What Slicer's reader would not take is against the schema: it is no schema that lets all through."""
    schema = etree.RelaxNG(etree.parse(os.path.join(HERE, "slicer_module.rng")))
    for old, new in (("<name>voxelSize</name>", "<name>voxel-size</name>"), ("--voxelSize<", "--voxel-size<"),
                     ("<category>Slicemorph</category>", ""), ('type="label"', 'type="labels"'), ("<default>0.5</default>", ""),
                     ("<channel>input</channel>", "<channel>in</channel>"), ("<longflag>--time</longflag>", ""),
                     ("<longflag>--time</longflag>", "<longflag>--time</longflag><index>0</index>"), ("<step>", "<steps>0</steps><step>"),
                     ('advanced="true"', 'advanced="yes"'), ('fileExtensions=".ply,.stl,.obj"', 'fileExtensions="ply"')):
        assert old in MORPH.xml, old
        assert not schema.validate(etree.fromstring(MORPH.xml.replace(old, new, 1).encode())), (old, new)


def case_options_of_the_program():
    """Parameters that are options of the program have its choices and defaults, whatever these are."""
    for module, command in ((MORPH, "morph"), (FILL, "reconstruct"), (SURFACE, "reconstruct")):
        lines = PROGRAM.run(command, "--help-all").stdout
        told = " ".join(lines.split())
        options = 0
        for e in module.parameters():
            option = re.sub("[A-Z]", lambda c: "-" + c.group().lower(), e.findtext("name"))
            found = re.search(r" --%s (\S+)? ?(.*?)(?= --[a-z]|$)" % option, told)
            if e.tag == "string-enumeration":
                choices = [c.text for c in e.findall("element")]
                if found and "{" in found.group(1):  # values with parameters have a section of the help to themselves
                    section = re.search(r"^%ss:\n((?:  .*\n)+)" % option.capitalize(), lines, re.M).group(1)
                    assert choices == re.findall(r"^  (\S+)", section, re.M), (option, section)
                else:
                    assert found and found.group(1) == "|".join(choices), (option, found)
            help_text = e.findtext("description").split("; 0 stands for the default")[0]
            options += " --" + option + " " in told and help_text in told
        assert options >= 5, (module.name, options)


# -- fill between slices ----------------------------------------------------------------------------------------------
def case_fill_labels():
    labels = two_labels()
    given = write_nrrd(FILL.file_for("inputLabels", "vtkMRMLLabelMapVolumeNode1"), drawn(labels))
    output = FILL.file_for("outputLabels", "vtkMRMLLabelMapVolumeNode2")
    result = heard(FILL.run({"inputLabels": given, "outputLabels": output}), "Fill between slices")
    dense = check_place(output)
    assert np.array_equal(dense[:, :, ::4], labels[:, :, ::4])
    # A ball is wrong by up to half a voxel at its surface and where it ends between two slices, four apart.
    for label, radius in ((3, 11), (7, 8)):
        share = 2 * ((dense == label) & (labels == label)).sum() / ((dense == label).sum() + (labels == label).sum())
        assert share > 1 - 0.5 * 3 / radius, (label, share)
    assert set(np.unique(dense)) == {0, 3, 7}
    assert output in result.text and "slices" in result.answers["remarks"] and result.answers["remarks"] in result.text.replace("\n", "; ")
    PROGRAM.run("reconstruct", given, "-o", "same.nrrd", "--image", "labels")
    assert np.array_equal(read_nrrd("same.nrrd")[0], dense)


def case_segmentations():
    """A segmentation of Slicer is a label map with its names in the header; one of two layers is refused, not taken in part."""
    layers = np.stack([drawn(np.where(two_labels() == label, value, 0).astype(np.uint8)) for label, value in ((3, 1), (7, 2))])
    for count, path in ((1, "one.nrrd"), (2, "two.nrrd")):
        segments = "".join("Segment{0}_ID:=Segment_{1}\nSegment{0}_LabelValue:={1}\nSegment{0}_Layer:={2}\n".format(n, n + 1, n * (count - 1))
                           for n in range(2))
        write_nrrd("plain.nrrd", layers.sum(0).astype(np.uint8))
        head, body = open("plain.nrrd", "rb").read().split(b"\n\n", 1)
        if count == 2:
            for old, new in (("dimension: 3", "dimension: 4"), ("sizes: ", "sizes: 2 "), ("directions: ", "directions: none "),
                             ("kinds: ", "kinds: list ")):
                head = head.replace(old.encode(), new.encode())
            body = gzip.compress(layers.tobytes(order="F"))
        open(path, "wb").write(head + b"\n" + segments.encode() + b"\n" + body)
    FILL.run({"inputLabels": "one.nrrd", "outputLabels": "out.nrrd"})
    FILL.run({"inputLabels": "plain.nrrd", "outputLabels": "same.nrrd"})
    assert np.array_equal(check_place("out.nrrd"), check_place("same.nrrd"))
    for module, given in ((FILL, {"inputLabels": "two.nrrd", "outputLabels": "x.nrrd"}),
                          (SURFACE, {"inputLabels": "two.nrrd", "outputModel": "x.vtp"}),
                          (MORPH, {"firstLabels": "one.nrrd", "secondLabels": "two.nrrd", "outputLabels": "x.nrrd"})):
        told = module.run(given, code=2).errors
        assert "two.nrrd" in told and "several volumes" in told and not glob.glob("x.*"), told


def case_fill_volume():
    """A ramp between given slices is a ramp."""
    k = np.arange(SHAPE[2], dtype=np.float32)
    ramp = np.broadcast_to(100 + 10 * k, SHAPE).astype(np.float32) + 5 * np.arange(SHAPE[0], dtype=np.float32)[:, None, None]
    given = write_nrrd(FILL.file_for("inputVolume", "vtkMRMLScalarVolumeNode1"), drawn(ramp.astype(np.float32), 3))
    output = FILL.file_for("outputVolume", "vtkMRMLScalarVolumeNode2")
    heard(FILL.run({"inputVolume": given, "outputVolume": output, "every": 3}), "Fill between slices")
    dense = check_place(output)
    assert np.array_equal(dense[:, :, ::3], ramp[:, :, ::3])
    PROGRAM.run("reconstruct", given, "-o", "same.nrrd", "--image", "grey", "--every", 3)
    assert np.array_equal(read_nrrd("same.nrrd")[0], dense)
    # What moves is looked for within a slice, where the ramp has a slope of 5 a voxel; it is found to a voxel.
    inside = (slice(4, -4), slice(4, -4), slice(0, 31))
    assert np.abs(dense - ramp)[inside].max() < 5, np.abs(dense - ramp)[inside].max()


def case_formats_of_images():
    """All formats that the description names are read and written, and say the same."""
    labels = drawn(two_labels())
    first = write_nrrd("in.nrrd", labels)
    dense = None
    for extension in FILL.extensions("outputLabels"):
        FILL.run({"inputLabels": first, "outputLabels": "out" + extension})
        if extension.startswith(".nii"):
            image = nib.load("out" + extension)
            values = np.asanyarray(image.dataobj)
            assert np.allclose(np.diag([-1, -1, 1]) @ image.affine[:3, :3], STEPS, atol=1e-5)
        elif extension == ".nrrd":
            values = check_place("out" + extension)
        else:
            assert extension == ".mha", "no reader here for " + extension
            head, body = open("out.mha", "rb").read().split(b"ElementDataFile = LOCAL\n", 1)
            packed = b"CompressedData = True" in head
            kind = {b"SHORT": "<i2", b"UCHAR": "u1"}[re.search(rb"ElementType = MET_(\w+)", head).group(1)]
            import zlib
            values = np.frombuffer(zlib.decompress(body) if packed else body, kind).reshape(SHAPE, order="F")
        dense = values if dense is None else dense
        assert np.array_equal(values, dense), extension
    for extension in FILL.extensions("inputLabels"):
        PROGRAM.run("convert", first, "-o", "in" + extension) if extension != ".nrrd" else None
        FILL.run({"inputLabels": "in" + extension, "outputLabels": "again.nrrd"})
        assert np.array_equal(read_nrrd("again.nrrd")[0], dense), extension


# -- morph ------------------------------------------------------------------------------------------------------------
def case_morph_labels():
    """Half way between balls of radius 11 and 7 is one of radius 9, with their label and on their voxels."""
    files = []
    for n, radius in enumerate((11, 7), 1):
        labels = np.where(distances((0, 0, 0)) < radius, 5, 0).astype(np.int16)
        files.append(write_nrrd(MORPH.file_for("firstLabels", "vtkMRMLLabelMapVolumeNode%d" % n), labels))
    output = MORPH.file_for("outputLabels", "vtkMRMLLabelMapVolumeNode3")
    heard(MORPH.run({"firstLabels": files[0], "secondLabels": files[1], "outputLabels": output, "align": "none",
                     "folder": os.getcwd()}), "Morph")
    assert not glob.glob("morph.*")  # Slicer names a folder always; files are wanted where there are frames
    between = check_place(output)
    assert set(np.unique(between)) == {0, 5}
    # Half a voxel of the smallest spacing: the surface is between voxels.
    assert abs(radius_of((between == 5).sum() * SPACING.prod()) - 9) < 0.5, radius_of((between == 5).sum() * SPACING.prod())
    PROGRAM.run("morph", *files, "-o", "same.nrrd", "--at", 0.5, "--image", "labels", "--align", "none")
    assert np.array_equal(read_nrrd("same.nrrd")[0], between)


def case_morph_volumes():
    """Frames in a folder and one time as a volume, of scans with soft edges."""
    files = []
    for n, radius in enumerate((12, 8), 1):
        values = (100 * np.clip((radius - distances((0, 0, 0))) / 6 + 0.5, 0, 1)).astype(np.float32)
        files.append(write_nrrd(MORPH.file_for("firstVolume", "vtkMRMLScalarVolumeNode%d" % n), values))
    output = MORPH.file_for("outputVolume", "vtkMRMLScalarVolumeNode3")
    os.mkdir("frames")
    heard(MORPH.run({"firstVolume": files[0], "secondVolume": files[1], "outputVolume": output, "time": "0.25", "frames": "3",
                     "folder": os.path.abspath("frames"), "align": "none", "iso": "50"}), "Morph")
    assert sorted(os.listdir("frames")) == ["morph.000%d.nrrd" % n for n in (1, 2, 3)]
    for path, radius in ((output, 11), ("frames/morph.0001.nrrd", 12), ("frames/morph.0002.nrrd", 10), ("frames/morph.0003.nrrd", 8)):
        found = radius_of((check_place(path) > 50).sum() * SPACING.prod())
        assert abs(found - radius) < 0.5, (path, found)
    assert np.array_equal(read_nrrd("frames/morph.0001.nrrd")[0], read_nrrd(files[0])[0])


def case_morph_models():
    """Half way between balls of radius 20 and 10 is one of radius 15, where they lie; all formats of the description go in and out."""
    files = [write_ply(MORPH.file_for("firstModel", "vtkMRMLModelNode%d" % n), radius, (-30, 50, 7)) for n, radius in ((1, 20), (2, 10))]
    output = MORPH.file_for("outputModel", "vtkMRMLModelNode3")
    given = {"firstModel": files[0], "secondModel": files[1], "outputModel": output, **QUICK}
    heard(MORPH.run(given), "Morph")
    points, triangles, said = read_vtp(output)
    assert is_closed(triangles) and said in ("", "LPS"), said
    # A tenth of a voxel, as in the example of the library (install_test.py); a voxel is 40 / 24 long at the first ball.
    assert abs(radius_of(volume_of(points, triangles)) - 15) < 0.1 * 40 / 24, radius_of(volume_of(points, triangles))
    assert np.abs(points.mean(0) - (-30, 50, 7)).max() < 0.1 * 40 / 24, points.mean(0)
    # From format to format, each time the middle of a ball and itself.
    before = files[0]
    for extension in MORPH.extensions("outputModel")[1:] + [".vtp"]:
        MORPH.run({"firstModel": before, "secondModel": before, "outputModel": "x" + extension, **QUICK, "method": "sdf"})
        before = "x" + extension
    points, triangles, _ = read_vtp("x.vtp")
    # A tenth of a voxel for each of the four.
    assert abs(radius_of(volume_of(points, triangles)) - 20) < 0.4 * 40 / 24, radius_of(volume_of(points, triangles))
    assert np.abs(points.mean(0) - (-30, 50, 7)).max() < 0.4 * 40 / 24, points.mean(0)
    assert set(MORPH.extensions("firstModel")) <= set(MORPH.extensions("outputModel"))


def case_landmarks():
    """Control points say what belongs together: of a ball without features which of its points is which."""
    middle = np.array((-30.0, 50, 7))
    files = [write_ply("%d.ply" % radius, radius, middle) for radius in (20, 16)]
    first = middle + 20 * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0]])
    second = middle + 16 * np.array([[0.96, 0.28, 0], [-0.28, 0.96, 0], [0, 0, 1], [-0.96, -0.28, 0]])
    given = {"firstModel": files[0], "secondModel": files[1], "outputModel": "out.vtp", **QUICK}
    heard(MORPH.run({**given, "firstLandmarks": first, "secondLandmarks": second}), "Morph")
    for name, points in (("1.txt", first), ("2.txt", second)):
        np.savetxt(name, points, "%.8g")
    words = [word for option, value in QUICK.items() for word in ("--" + option, value)]
    PROGRAM.run("morph", *files, "-o", "same.vtp", "--at", 0.5, *words, "--landmarks", "1.txt,2.txt")
    PROGRAM.run("morph", *files, "-o", "without.vtp", "--at", 0.5, *words)
    read = lambda path: open(path, "rb").read()
    assert read("out.vtp") == read("same.vtp") and read("out.vtp") != read("without.vtp")
    told = MORPH.run({**given, "firstLandmarks": first, "secondLandmarks": second[:3]}, code=2).errors
    assert "4 landmarks on the first" in told and "3 on the second" in told, told


# -- surfaces ---------------------------------------------------------------------------------------------------------
def case_surface_of_labels():
    labels = two_labels()
    given = write_nrrd(SURFACE.file_for("inputLabels", "vtkMRMLLabelMapVolumeNode1"), drawn(labels))
    output = SURFACE.file_for("outputModel", "vtkMRMLModelNode1")
    os.mkdir("each")
    heard(SURFACE.run({"inputLabels": given, "outputModel": output, "each": "true", "folder": os.path.abspath("each")}),
          "Surface from contours")
    points, triangles, said = read_vtp(output)
    assert said == "LPS" and is_closed(triangles)
    # Slices lie 6 mm apart: where a ball ends between them is known to half of that, at both ends.
    parts = {}
    for name, index, radius in (("label_3", (-9, 0, 0), 11), ("label_7", (13, 4, 2), 8)):
        p, t, said = read_vtp("each/%s.vtp" % name)
        parts[name] = volume_of(p, t)
        assert is_closed(t) and said == "LPS" and abs(radius_of(parts[name]) - radius) < 1, (name, radius_of(parts[name]))
        assert (np.abs((p.min(0) + p.max(0)) / 2 - place(index)) < (1, 1, 3)).all(), (name, p.min(0), p.max(0), place(index))
    assert abs(volume_of(points, triangles) - sum(parts.values())) < 1e-3 * sum(parts.values())
    SURFACE.run({"inputLabels": given, "outputModel": "one.stl", "structure": "7"})
    raw = open("one.stl", "rb").read()
    assert b"SPACE=LPS" in raw[:80]
    corners = np.frombuffer(raw[84:], [("n", "<f4", 3), ("p", "<f4", (3, 3)), ("a", "<u2")])["p"].astype(float)
    volume = np.einsum("ij,ij", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert abs(volume - parts["label_7"]) < 1e-3 * volume


def case_surface_of_structures():
    """Cylinders of a structure set, between their outermost contours and half a gap further."""
    path = write_structure_set("set.dcm")
    os.mkdir("each")
    heard(SURFACE.run({"contours": path, "each": "true", "folder": "each", "voxelSize": "1"}), "Surface from contours")
    assert sorted(os.listdir("each")) == ["Heart.vtp", "Left lung.vtp"]
    for name, x, radius in (("Heart", 0, 10), ("Left lung", 40, 6)):
        p, t, said = read_vtp("each/%s.vtp" % name)
        # Half a voxel around, and as a cylinder is closed between 30 and 33 high.
        assert is_closed(t) and np.pi * (radius - 0.5)**2 * 29 < volume_of(p, t) < np.pi * (radius + 0.5)**2 * 34, volume_of(p, t)
        assert np.abs((p.min(0) + p.max(0)) / 2 - (x, 0, 15)).max() < 0.5, (p.min(0), p.max(0))
    SURFACE.run({"contours": path, "structure": "Left lung", "outputModel": "lung.vtp", "voxelSize": "1"})
    assert np.array_equal(read_vtp("lung.vtp")[0], read_vtp("each/Left lung.vtp")[0])
    with open("box.csl", "w") as file:
        file.write("CSLC\n3 2\n")
        for n, z in enumerate((0, 2, 5), 1):
            file.write("%d 4 1 0 0 1 %g\n0 0 %g\n10 0 %g\n10 20 %g\n0 20 %g\n4 1 0 1 2 3\n" % (n, -z, z, z, z, z))
    assert ".csl" in SURFACE.extensions("contours") and ".dcm" in SURFACE.extensions("contours")
    SURFACE.run({"contours": "box.csl", "outputModel": "box.vtp"})
    assert read_vtp("box.vtp")[2] == "LPS"


# -- what goes wrong --------------------------------------------------------------------------------------------------
def case_wrong_input():
    """A message on standard error that says what is wrong, a code that is not 0, no file, and no end of the run."""
    labels = write_nrrd("labels.nrrd", drawn(two_labels()))
    ball = write_ply("ball.ply", 20, (0, 0, 0))
    open("cut.nrrd", "wb").write(open("labels.nrrd", "rb").read()[:-400])
    open("empty.nrrd", "wb").close()
    pair = {"firstModel": ball, "secondModel": ball}
    before = set(os.listdir("."))
    for module, given, says in (
            (MORPH, {}, ["nothing is given to morph"]),
            (MORPH, {"firstModel": ball, "outputModel": "x.vtp"}, ["second model is missing"]),
            (MORPH, pair, ["no output"]),
            (MORPH, {**pair, "outputVolume": "x.nrrd"}, ["volume", "model", "one kind"]),
            (MORPH, {**pair, "frames": 3}, ["--frames 3", "folder"]),
            (MORPH, {**pair, "frames": 3, "folder": "missing"}, ["missing"]),
            (MORPH, {**pair, "outputModel": "missing/x.vtp"}, ["missing"]),
            (MORPH, {**pair, "outputModel": "x.vtp", "time": 2}, ["--time 2", "0 to 1"]),
            (MORPH, {**pair, "outputModel": "x.vtp", "firstLandmarks": [(1, 2)]}, ["firstLandmarks 1,2", "x,y,z"]),
            (MORPH, {**pair, "outputModel": "x.vtp", "time": "soon"}, ["--time soon", "not a number"]),
            (MORPH, {**pair, "outputModel": "x.vtp", "method": "magic"}, ["method magic", "slices"]),
            (MORPH, {**pair, "outputModel": "x.vtp", "resolution": 32, "voxelSize": 1}, ["resolution", "voxel-size", "exclude"]),
            (MORPH, {**pair, "outputModel": "x.vtp", "firstLandmarks": [(0, 0, 0)]}, ["1 landmarks on the first", "0 on the second"]),
            (FILL, {}, ["nothing is given to fill"]),
            (FILL, {"inputLabels": labels}, ["result is missing"]),
            (FILL, {"inputLabels": labels, "outputVolume": "x.nrrd"}, ["label map and a volume"]),
            (FILL, {"inputLabels": "cut.nrrd", "outputLabels": "x.nrrd"}, ["cut.nrrd"]),
            (FILL, {"inputLabels": "empty.nrrd", "outputLabels": "x.nrrd"}, ["empty.nrrd"]),
            (FILL, {"inputLabels": "none.nrrd", "outputLabels": "x.nrrd"}, ["none.nrrd"]),
            (FILL, {"inputLabels": labels, "outputLabels": "x.txt"}, ["x.txt"]),
            (FILL, {"inputLabels": labels, "outputLabels": "x.nrrd", "given": "0,90"}, ["--given", "32 along axis k"]),
            (FILL, {"inputLabels": labels, "outputLabels": "x.nrrd", "every": 2, "between": 1}, ["every", "between"]),
            (SURFACE, {"outputModel": "x.vtp"}, ["nothing is given"]),
            (SURFACE, {"inputLabels": labels}, ["no output"]),
            (SURFACE, {"inputLabels": labels, "each": "true"}, ["folder"]),
            (SURFACE, {"inputLabels": labels, "contours": labels, "outputModel": "x.vtp"}, ["one of them"]),
            (SURFACE, {"inputLabels": labels, "outputModel": "x.vtp", "structure": "9"}, ["structure 9", "label_3", "label_7"]),
            (SURFACE, {"inputLabels": labels, "outputModel": "x.nrrd"}, ["x.nrrd"])):
        process = module.start(given)
        output, errors = process.communicate(timeout=60)
        assert process.returncode in (1, 2), (given, process.returncode, errors)
        for part in says:
            assert part in errors, "%r of %s is not in: %s" % (part, given, errors)
        assert errors.startswith(module.name + ": ") and "<filter-end>" not in output, (given, errors, output)
        assert set(os.listdir(".")) == before, (given, set(os.listdir(".")) ^ before)
    for words, part in ((["--voxel-size", "1"], "voxelSize"), (["here.ply"], "here.ply"), (["--time"], "needs a value")):
        told = subprocess.run([MORPH.path, *words], capture_output=True, text=True)
        assert told.returncode == 2 and part in told.stderr, told
    assert subprocess.run([MORPH.path, "--processinformationaddress", "0", "--version"], capture_output=True, text=True).returncode == 0
    assert "voxelSize" in subprocess.run([MORPH.path, "--help"], capture_output=True, text=True).stdout


def until(process, fraction):
    """Reads progress until it passes a fraction."""
    for line in process.stdout:
        found = re.match("<filter-progress>(.*)</filter-progress>", line)
        if found and fraction <= float(found.group(1)) < 1:
            return
    raise AssertionError("the run ended before it could be stopped: " + process.stderr.read())


def case_stopped():
    """Slicer kills what is cancelled: there is no file then; what ends by a gentler signal leaves nothing at all."""
    files = [write_ply("%d.ply" % radius, radius, (0, 0, 0)) for radius in (20, 10)]
    given = {"firstModel": files[0], "secondModel": files[1], "outputModel": "out.vtp", "frames": 1000, "folder": os.getcwd(),
             **QUICK}
    for number, codes in ((signal.SIGKILL, {-9}), (signal.SIGTERM, {1})):
        process = MORPH.start(given)
        until(process, 0.1)
        process.send_signal(number)
        output, errors = process.communicate(timeout=60)
        assert process.returncode in codes, (process.returncode, errors)
        left = set(os.listdir(".")) - {"20.ply", "10.ply"}
        for frame in {name for name in left if name.startswith("morph.")}:
            points, triangles, _ = read_vtp(frame)  # frames that were done are whole
            assert is_closed(triangles)
            os.remove(frame)
        left = {name for name in left if not name.startswith("morph.")}
        assert "out.vtp" not in left and all(name.startswith(".") for name in left), left
        assert number == signal.SIGKILL or not left, left
        assert "<filter-end>" not in output and not os.path.exists("answers.params")
        for name in left:
            os.remove(name)


def case_readme():
    """The commands of the modules' guide."""
    repository = os.path.join(HERE, "..", "..")
    os.symlink(os.path.abspath(os.path.join(repository, "assets")), "assets")
    os.symlink(os.path.dirname(FOLDER), "build")
    text = open(os.path.join(repository, "tools/slicer/README.md")).read()
    commands = re.findall(r"^build/cli-modules/.*$", text, re.M)
    assert len(commands) == 2, commands
    for command in commands:
        more = "" if "--xml" in command else "".join(" --%s %s" % pair for pair in QUICK.items())
        done = subprocess.run(command + more, shell=True, capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr, (command, done)
    assert is_closed(read_vtp("half.vtp")[1])


def case_libraries_of_slicer():
    """Slicer's launcher puts its own libraries first, which this program must not load."""
    os.mkdir("lib")
    needed = subprocess.run(["ldd", os.path.join(FOLDER, "../slicemorph_slicer")], capture_output=True, text=True).stdout
    for library in re.findall(r"(lib(?:tbb|openvdb|png|z)\S*\.so\S*) =>", needed):
        open("lib/" + library, "w").write("no library")
    assert os.listdir("lib"), needed
    module = Module(SURFACE.path, env={"LD_LIBRARY_PATH": os.path.abspath("lib"), "ITK_AUTOLOAD_PATH": os.path.abspath("lib")})
    given = write_nrrd("labels.nrrd", drawn(two_labels()))
    heard(module.run({"inputLabels": given, "outputModel": "x.vtp"}), "Surface from contours")


def case_other_names():
    """A module works through links, and from any folder, whatever is in names."""
    os.makedirs("a folder, with @ 1:2/modules")
    link = os.path.abspath("a folder, with @ 1:2/modules/SlicemorphSurface")
    os.symlink(SURFACE.path, link)
    os.chdir("a folder, with @ 1:2")
    given = write_nrrd(SURFACE.file_for("inputLabels", "vtkMRMLSegmentationNode1"), drawn(two_labels()))
    Module(link).run({"inputLabels": given, "outputModel": SURFACE.file_for("outputModel", "vtkMRMLModelNode1")})
    assert len(glob.glob("*vtkMRMLModelNodeB.vtp")) == 1, os.listdir(".")


sys.exit(run_within(globals(), ONLY))
