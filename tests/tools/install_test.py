#!/usr/bin/env python3
"""The installed program, library and package, used from outside the tree after the installation was moved.

usage: install_test.py CMAKE BUILD REPOSITORY [NAME...]     (NAME: only the cases whose name contains it)

Installs BUILD to a temporary folder, which is then renamed. Needs Debian's python3-openvdb and python3-pydicom.
"""
import glob
import gzip
import json
import math
import multiprocessing.pool
import os
import re
import shlex
import struct
import subprocess
import sys
import tempfile

sys.path.append("/usr/lib/python3/dist-packages")
import numpy as np
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, named_cases, run_cases

if len(sys.argv) < 4:
    sys.exit(__doc__)
CMAKE, BUILD, REPOSITORY = sys.argv[1], os.path.abspath(sys.argv[2]), os.path.abspath(sys.argv[3])
ONLY = sys.argv[4:]
ROOT = tempfile.TemporaryDirectory(prefix="slicemorph-install-")
PREFIX = ROOT.name + "/moved"
EXAMPLES = ROOT.name + "/examples"
# Plug-ins and libraries must be found through the installation alone.
CLEAN = {name: value for name, value in os.environ.items() if name not in ("SLICEMORPH_PLUGINS", "LD_LIBRARY_PATH")}
VOXELS = np.arange(7 * 6 * 5, dtype=np.uint8).reshape(5, 6, 7)  # z, y, x: every value differs


def run(*command, folder=None, code=0, **environment):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, errors="replace", timeout=900,
                            cwd=folder, env={**CLEAN, **environment})
    assert result.returncode == code, "%s: exit %d\n%s" % (" ".join(map(str, command)), result.returncode,
                                                           (result.stderr + result.stdout)[-1500:])
    return result


def install():
    first = ROOT.name + "/installed"
    run(CMAKE, "--install", BUILD, "--prefix", first)
    os.rename(first, PREFIX)


def program(*arguments, folder, **more):
    return run(PREFIX + "/bin/slicemorph", *arguments, folder=folder, **more)


def read_nrrd(path):
    """Header fields and values (z, y, x) of a NRRD of bytes in one gzip-packed file."""
    head, data = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines() if ": " in line)
    assert fields["encoding"] == "gzip", fields
    types = {"uint8": "u1", "unsigned char": "u1", "uchar": "u1", "short": "<i2", "int16": "<i2"}
    sizes = [int(size) for size in fields["sizes"].split()]
    return fields, np.frombuffer(gzip.decompress(data), types[fields["type"]]).reshape(sizes[::-1])


def write_tiff(path, pixels):
    """A grey 8-bit picture, one strip, uncompressed (TIFF 6.0, baseline)."""
    rows, columns = pixels.shape
    start = 8 + 2 + 9 * 12 + 4
    tags = [(256, columns), (257, rows), (258, 8), (259, 1), (262, 1), (273, start), (277, 1), (278, rows), (279, pixels.size)]
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    open(path, "wb").write(b"II*\0" + struct.pack("<I", 8) + directory + struct.pack("<I", 0) + pixels.tobytes())


def write_dicom(path, pixels, z):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = CTImageStorage, generate_uid()
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, False
    d.SOPClassUID, d.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
    d.StudyInstanceUID = d.SeriesInstanceUID = d.FrameOfReferenceUID = "1.2.3"
    d.Modality, d.PatientID = "CT", "none"
    d.Rows, d.Columns = pixels.shape
    d.PixelSpacing, d.SliceThickness = [1, 1], 2
    d.ImageOrientationPatient, d.ImagePositionPatient = [1, 0, 0, 0, 1, 0], [0, 0, z]
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.BitsAllocated = d.BitsStored = 16
    d.HighBit, d.PixelRepresentation = 15, 1
    d.RescaleIntercept, d.RescaleSlope = 0, 1
    d.PixelData = pixels.astype("<i2").tobytes()
    d.save_as(path)


# ---------------------------------------------------------------------------------------------------------------------
def case_installed_program_reads_nrrd(folder):
    """The ITK plug-in is used from a folder unrelated to the installation."""
    head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 7 6 5\nspace: left-posterior-superior\n" \
           "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\n"
    open(folder + "/in.nrrd", "wb").write(head.encode() + VOXELS.tobytes())
    program("convert", "in.nrrd", "-o", "out.nrrd", folder=folder)
    fields, values = read_nrrd(folder + "/out.nrrd")
    assert np.array_equal(values, VOXELS), fields


def case_installed_program_reads_dicom(folder):
    os.mkdir(folder + "/series")
    for k, pixels in enumerate(VOXELS):
        write_dicom(folder + "/series/%d.dcm" % k, pixels, 2 * k)
    program("convert", "series", "-o", "out.nrrd", folder=folder)
    fields, values = read_nrrd(folder + "/out.nrrd")
    assert np.array_equal(values, VOXELS), fields


def write_stack(folder):
    for k, pixels in enumerate(VOXELS):
        write_tiff(folder + "/in.%d.tif" % k, pixels)


def case_installed_program_reads_pictures(folder):
    """The picture plug-in reads a stack of TIFFs; the program is called through a link in another folder."""
    write_stack(folder)
    os.symlink(PREFIX + "/bin/slicemorph", folder + "/linked")
    run("./linked", "convert", "in.#.tif", "-o", "out.nrrd", "--spacing", "1,1,2", folder=folder)
    fields, values = read_nrrd(folder + "/out.nrrd")
    assert np.array_equal(values, VOXELS), fields


def case_plugins_elsewhere(folder):
    """A missing plug-in is a clear message; the environment names the folder where it is."""
    write_stack(folder)
    plugins = PREFIX + "/lib/slicemorph"
    away = ROOT.name + "/plugins"
    convert = ["convert", "in.#.tif", "-o", "out.nrrd", "--spacing", "1,1,2"]
    os.rename(plugins, away)
    try:
        message = program(*convert, folder=folder, code=1).stderr
        for part in ("libslicemorph_pictures.so", plugins, "SLICEMORPH_PLUGINS"):
            assert part in message, message
        program(*convert, folder=folder, SLICEMORPH_PLUGINS=away)
    finally:
        os.rename(away, plugins)
    assert np.array_equal(read_nrrd(folder + "/out.nrrd")[1], VOXELS)


def configure_examples():
    if not os.path.exists(EXAMPLES + "/compile_commands.json"):
        run(CMAKE, "-S", REPOSITORY + "/tools/examples", "-B", EXAMPLES, "-DCMAKE_PREFIX_PATH=" + PREFIX,
            "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")


def volume_and_middle(path):
    """Volume of the inside of a level set: each voxel counts by its share inside a plane at its distance."""
    import pyopenvdb as vdb
    grid = vdb.read(path, "surface")
    low, high = grid.evalActiveVoxelBoundingBox()
    distances = np.empty([high[i] - low[i] + 1 for i in range(3)], np.float32)
    grid.copyToArray(distances, low)
    size = grid.transform.voxelSize()[0]
    inside = np.clip(0.5 - distances / size, 0, 1)
    index = np.stack(np.meshgrid(*[np.arange(low[i], high[i] + 1) for i in range(3)], indexing="ij"), -1)
    middle = (index * inside[..., None]).sum((0, 1, 2)) / inside.sum()
    return size, inside.sum() * size**3, np.array(grid.transform.indexToWorld(tuple(middle)))


def case_example(folder):
    """Half way between balls of radius 1 and 0.5, 3 apart, is a ball of radius 0.75 midway between them."""
    configure_examples()
    run(CMAKE, "--build", EXAMPLES)
    printed = float(run(EXAMPLES + "/morph_two_balls", folder=folder).stdout)
    size, volume, middle = volume_and_middle(folder + "/half_way.vdb")
    # The voxel size is interpolated linearly: half way between 1/25 and 0.5/25.
    assert abs(size - 0.03) < 1e-6, size
    # Facets of one voxel, and voxels counted by planes, ignore the sphere's curvature within them: (1/8)
    # size^2 / radius, a two-hundredth of a voxel. A tenth of a voxel is far above that, and far below the
    # voxel and a half by which a radius that changes by a constant factor (0.707) would be off.
    for name, value in (("printed", printed), ("in the file", volume)):
        radius = (3 * value / (4 * math.pi))**(1 / 3)
        assert abs(radius - 0.75) < 0.1 * size, "%s: radius %g" % (name, radius)
    assert np.abs(middle - [1.5, 0, 0]).max() < 0.1 * size, middle


def included_by(header):
    """All includes of a header, also through other headers of the package, as written; and itself."""
    found, queue = [], [header]
    while queue:
        name = queue.pop()
        if name not in found:
            found.append(name)
            if name.startswith("slicemorph/"):
                queue += re.findall(r'^#include ["<](.*?)[">]', open(PREFIX + "/include/" + name).read(), re.M)
    return found


def case_debian_packages(folder):
    """cpack puts every installed file into just one package, and these ask for the libraries that their programs load."""
    run(CMAKE.replace("cmake", "cpack"), "--config", BUILD + "/CPackConfig.cmake", "-B", folder + "/packages")
    owners, fields = {}, {}
    for package in glob.glob(folder + "/packages/*.deb"):
        name = os.path.basename(package).split("_")[0]
        fields[name] = dict(re.findall(r"^ ?([A-Z][A-Za-z-]+): (.*)$", run("dpkg-deb", "-f", package).stdout, re.M))
        for line in run("dpkg-deb", "-c", package).stdout.splitlines():
            if not line.startswith("d"):
                owners.setdefault(line.split()[5].removeprefix("./usr/"), []).append(name)
    installed = {os.path.relpath(os.path.join(where, name), PREFIX) for where, _, names in os.walk(PREFIX) for name in names}
    assert set(owners) == installed, sorted(set(owners) ^ installed)[:10]
    assert all(len(names) == 1 for names in owners.values()), [file for file, names in owners.items() if len(names) > 1]
    assert owners["bin/slicemorph"] == ["slicemorph"] and owners["share/man/man1/slicemorph.1"] == ["slicemorph"]
    assert owners["lib/slicemorph/cli-modules/SlicemorphMorph"] == ["slicemorph"]
    assert owners["include/slicemorph/slicemorph.h"] == ["libslicemorph-dev"]
    assert "libopenvdb10.0" in fields["slicemorph"]["Depends"] and "libinsighttoolkit5" in fields["slicemorph"]["Depends"]
    assert "libopenvdb-dev" in fields["libslicemorph-dev"]["Depends"]
    assert all(value["Version"] == fields["slicemorph"]["Version"] for value in fields.values())


def case_public_headers(folder):
    """Each header compiles alone with the package's include folders, and
    includes only OpenVDB and std headers."""
    configure_examples()
    words = shlex.split(json.load(open(EXAMPLES + "/compile_commands.json"))[0]["command"])
    # As a user's headers: those of the system would not be warned about.
    words[words.index(PREFIX + "/include") - 1] = "-I"
    words = words[:words.index("-o")] + ["-Wall", "-Wextra", "-Werror", "-Winvalid-pch"]
    headers = [os.path.relpath(path, PREFIX + "/include") for path in
               sorted(glob.glob(PREFIX + "/include/slicemorph/**/*.h", recursive=True))]
    of_tree = glob.glob(REPOSITORY + "/*/include/slicemorph/**/*.h", recursive=True)
    assert len(headers) == len(of_tree) > 10, headers
    # OpenVDB takes seconds to parse, so it is precompiled once. A compiler uses that only where it is
    # included first, which makes no difference to headers that include it anyway; the others are compiled
    # without.
    open(folder + "/first.h", "w").write("#include <openvdb/openvdb.h>\n")
    run(*words, "-x", "c++-header", folder + "/first.h", "-o", folder + "/first.h.gch")

    def alone(header):
        included = included_by(header)
        foreign = [name for name in included if "/" in name and not name.startswith(("slicemorph/", "openvdb/"))]
        assert not foreign, "%s includes %s" % (header, foreign)
        first = '#include "first.h"\n' if "openvdb/openvdb.h" in included else ""
        source = "%s/%s.cpp" % (folder, header.replace("/", "_"))
        open(source, "w").write(first + '#include "%s"\n' % header)
        run(*words, "-fsyntax-only", source)

    with multiprocessing.pool.ThreadPool(2) as pool:
        pool.map(alone, headers)


def case_python(folder):
    """The Python package is imported from where it was installed and moved to, without the program, and finds its plug-ins."""
    places = glob.glob(PREFIX + "/lib/python3*/dist-packages/slicemorph")
    if not places:
        raise Skip("the Python package was not built")
    write_stack(folder)
    script = """
import slicemorph
image = slicemorph.load("in.#.tif", spacing=(1, 1, 2))
assert image.to_numpy().shape == (7, 6, 5) and image.to_numpy()[1, 2, 3] == 3 * 42 + 2 * 7 + 1, image.to_numpy()
image.save("out.nrrd")
assert (slicemorph.load("out.nrrd").to_numpy() == image.to_numpy()).all()
print(slicemorph.__file__, slicemorph.__version__)
"""
    told = run("/usr/bin/python3", "-c", script, folder=folder, PYTHONPATH=os.path.dirname(places[0]), PATH="").stdout
    assert told.startswith(places[0]), told
    assert os.path.exists(places[0] + "/py.typed") and os.path.exists(places[0] + "/_option_types.py")


def case_slicer_modules(folder):
    """The modules of 3D Slicer are found, describe themselves, and read NRRD by the plug-in of the installation."""
    modules = PREFIX + "/lib/slicemorph/cli-modules"
    assert sorted(os.listdir(modules)) == ["SlicemorphFillBetweenSlices", "SlicemorphMorph", "SlicemorphSurface"]
    for name in os.listdir(modules):
        assert run(modules + "/" + name, "--xml").stdout.startswith("<?xml")
    box = np.zeros((9, 6, 7), np.uint8)
    box[::4, 2:5, 2:5] = 4
    head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 7 6 9\nspace: left-posterior-superior\n" \
           "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\n"
    open(folder + "/in.nrrd", "wb").write(head.encode() + box.tobytes())
    run(modules + "/SlicemorphFillBetweenSlices", "--inputLabels", "in.nrrd", "--outputLabels", "out.nrrd", folder=folder)
    assert np.array_equal(read_nrrd(folder + "/out.nrrd")[1], np.repeat(box[:1], 9, 0))


def case_package(folder):
    """The engine alone needs no library of io; a later minor version is refused."""
    version = re.search(r"project\(slicemorph VERSION (\d+)\.(\d+)", open(REPOSITORY + "/CMakeLists.txt").read())
    major, minor = map(int, version.groups())
    assert program("--version", folder=folder).stdout.startswith("slicemorph %d.%d." % (major, minor))
    open(folder + "/CMakeLists.txt", "w").write("""
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES CXX)
find_package(slicemorph %d.%d QUIET)
if(slicemorph_FOUND)
  message(FATAL_ERROR "found as a later version")
endif()
find_package(slicemorph %d.%d REQUIRED COMPONENTS engine)
foreach(unwanted slicemorph::io TinyGLTF::TinyGLTF OpenEXR::OpenEXR)
  if(TARGET ${unwanted})
    message(FATAL_ERROR "${unwanted} was looked for")
  endif()
endforeach()
if(NOT TARGET slicemorph::engine OR NOT EXISTS ${slicemorph_PLUGIN_DIR} OR CMAKE_MODULE_PATH)
  message(FATAL_ERROR "${slicemorph_PLUGIN_DIR}, ${CMAKE_MODULE_PATH}")
endif()
""" % (major, minor + 1, major, minor))
    run(CMAKE, "-S", folder, "-B", folder + "/build", "-DCMAKE_PREFIX_PATH=" + PREFIX)


install()
sys.exit(run_cases(named_cases(globals()), ONLY))
