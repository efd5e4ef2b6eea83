#!/usr/bin/env python3
"""Prints SHA-256 sums of the outputs of some thirty small commands: all kinds of inputs, outputs, methods.

usage: output_sums.py PROGRAM [REPOSITORY] [NAME...]     (NAME: only the commands whose name contains it)

For changes that must not change outputs: run it with the program before and after, and compare the lists. It is
no test by itself, since sums depend on compiler and libraries. What differs from run to run by design is removed
first: the unique number in a VDB's header, and the times in a report.
"""
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.append("/usr/lib/python3/dist-packages")

PROGRAM = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else sys.exit(__doc__)
REPOSITORY = os.path.abspath(sys.argv[2] if len(sys.argv) > 2 else os.path.join(os.path.dirname(__file__), ".."))
ONLY = sys.argv[3:]
SMALL = "--resolution 40 --slices 48"

# Each line: a name and the arguments. Later commands read what earlier ones wrote, so the order matters.
COMMANDS = """
voxels            convert assets/creature.ply -o creature.vdb --resolution 48
mesh-obj          convert assets/ring.ply -o ring.obj --resolution 40
mesh-stl          convert assets/blade.ply -o blade.stl --resolution 40
mesh-glb          convert assets/octahedron.ply -o octahedron.glb --resolution 32
mesh-nii          convert assets/creature.ply -o creature.nii.gz --resolution 40
mesh-nrrd         convert assets/ring.ply -o ring.nrrd --resolution 40
mesh-mha          convert assets/blade.ply -o blade.mha --voxel-size 0.06
from-off          convert tetrahedron.off -o from_off.vdb --resolution 32
from-stl          convert blade.stl -o from_stl.vdb --resolution 32
from-obj          convert ring.obj -o from_obj.ply --resolution 32
from-glb          convert octahedron.glb -o from_glb.vdb --resolution 32
stack-in          convert stack.##.tif -o from_stack.nrrd --spacing 1,1,2
dicom-in          convert dicom -o from_dicom.mha
morph-vdb         morph assets/creature.ply assets/ring.ply -o pair.####.vdb --frames 4 SMALL --report pair.json --report pair.csv
morph-page        morph assets/blade.ply assets/amphora.ply -o page.####.vdb --frames 2 SMALL --report page.json
morph-blend       morph assets/blade.ply assets/creature.ply assets/ring.ply -o third.vdb --weights 0.4,0.3,0.3 SMALL
morph-keys        morph assets/amphora.ply assets/blade.ply assets/ring.ply -o keys.####.vdb --frames 5 --timing catmull-rom --ease in-out SMALL
morph-regions     morph --config assets/jobs/parts.toml
morph-features    morph --config assets/jobs/features.toml
morph-paths       morph assets/creature.ply assets/amphora.ply -o path.vdb --at 0.4 --interpolation intrinsic SMALL
morph-curved      morph assets/blade.ply assets/ring.ply -o curved.vdb --at 0.5 --spine curved --axis y SMALL
morph-unaligned   morph assets/creature.ply creature.vdb -o unaligned.ply --at 0.3 --align none SMALL
morph-colors      morph assets/die.ply assets/octahedron.ply -o colors.####.ply --frames 3 SMALL
morph-glb         morph assets/blade.ply assets/creature.ply -o animated.glb --frames 3 SMALL
morph-sdf         morph assets/blade.ply assets/ring.ply -o sdf.####.vdb --frames 3 --method sdf SMALL
morph-levelset    morph assets/blade.ply assets/ring.ply -o ls.####.vdb --frames 3 --method levelset SMALL
morph-dissolve    morph assets/blade.ply assets/creature.ply -o fade.####.vdb --frames 3 --method dissolve SMALL
morph-sequence    morph fade.####.vdb assets/ring.ply -o smoke.####.vdb --conserve --velocity v --velocity-unit frame SMALL
morph-grids       morph smoke.0001.vdb smoke.0003.vdb -o grids.####.vdb --frames 3 --add-velocity --fps 25
morph-pictures    morph assets/blade.ply assets/ring.ply -o beauty.####.exr --frames 2 --size 80x60 --light 1,-1,-0.5 SMALL
morph-slices      morph assets/blade.ply assets/ring.ply -o stack.####.exr --frames 2 --exr slices --exr-slices 8 SMALL
morph-labels      morph creature.nii.gz ring.nrrd -o mask.##.nii.gz --frames 3 --slices 48 --report mask.csv
morph-grey        morph from_dicom.mha grey.nii.gz -o grey.##.nrrd --frames 3 --iso 300/250 --slices 48 --align none
morph-marks       morph assets/creature.ply assets/amphora.ply -o marks.vdb --at 0.5 --landmarks a.txt,b.txt SMALL --report marks.json
slice-axis        slice pair.0002.vdb -o cut.exr --axis 1,0.5,2 --slices 12
slice-spine       slice pair.0002.vdb -o leaning.exr --spine --slices 6 --half --compression piz --tiles 32
slice-planes      slice smoke.0002.vdb -o planes.####.exr --plane 0,0.5,0/0,1,0 --pixel-size 0.1
rebuild-slices    reconstruct cut.exr -o again.vdb
rebuild-labels    reconstruct creature.nii.gz -o dense.nii.gz --between 2
rebuild-contours  reconstruct two.csl -o contours.stl --voxel-size 0.1
render-png        render pair.####.vdb -o picture.####.png --contact-sheet sheet.png --size 80x60
render-fog        render smoke.0002.vdb -o fog.exr --size 80x60
render-turn       render pair.0003.vdb -o turn.####.png --turntable 2 --ortho --size 60x60
compare           compare creature.vdb assets/creature.ply --json
info              info smoke.0002.vdb --json
"""


def make_inputs(folder):
    """Inputs that the bundled shapes do not cover: pictures, a DICOM
    series, grey values, contours, points, OFF."""
    import nibabel
    import numpy as np
    import pydicom
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

    def path(name):
        return os.path.join(folder, name)

    def write(name, text):
        with open(path(name), "w") as file:
            file.write(text)

    write("tetrahedron.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    write("a.txt", "1.44 1.50 0\n-0.93 1.07 0.02\n")
    write("b.txt", "0.38 1.12 0\n-0.66 0.38 0\n")
    x, y, z = np.meshgrid(*3 * [np.arange(24.0)], indexing="ij")

    def ball(cx, cy, cz, r):
        return np.clip(500 - 60 * (np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) - r), 0, 1000).astype(np.int16)

    nibabel.save(nibabel.Nifti1Image(ball(13, 11, 12, 8), np.diag([-1.0, -1.0, 2.0, 1.0])), path("grey.nii.gz"))
    first = ball(11, 12, 12, 6)
    os.mkdir(path("dicom"))
    series = generate_uid(entropy_srcs=["series"])
    for i in range(24):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = CTImageStorage
        meta.MediaStorageSOPInstanceUID = generate_uid(entropy_srcs=["slice", str(i)])
        meta.TransferSyntaxUID = ExplicitVRLittleEndian
        d = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        d.SOPClassUID, d.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
        d.SeriesInstanceUID = d.StudyInstanceUID = d.FrameOfReferenceUID = series
        d.Modality, d.PatientID = "CT", "ball"
        d.Rows = d.Columns = 24
        d.PixelSpacing, d.SliceThickness = [1, 1], 2
        d.ImageOrientationPatient, d.ImagePositionPatient = [1, 0, 0, 0, 1, 0], [0, 0, 2 * i]
        d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
        d.BitsAllocated = d.BitsStored = 16
        d.HighBit, d.PixelRepresentation = 15, 1
        d.RescaleIntercept, d.RescaleSlope = 0, 1
        d.PixelData = np.ascontiguousarray(first[:, :, i].T).tobytes()
        d.is_little_endian, d.is_implicit_VR = True, False
        d.save_as(path("dicom/%03d.dcm" % ((7 * i) % 24)), write_like_original=False)
    import OpenImageIO as oiio
    for i in range(24):
        spec = oiio.ImageSpec(24, 24, 1, "uint16")
        out = oiio.ImageOutput.create(path("stack.%02d.tif" % i))
        out.open(path("stack.%02d.tif" % i), spec)
        out.write_image(np.ascontiguousarray(first[:, :, i].T.astype(np.uint16)).reshape(24, 24, 1))
        out.close()
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    lines = ["CSLC", "3 2"]
    for n in range(3):
        size = (1.0, 0.7, 0.4)[n]
        lines.append("\n%d 4 1 0 0 1 %g" % (n + 1, -n))
        lines += ["%g %g %g" % (size * px, size * py, n) for px, py in square]
        lines.append("4 1 0 1 2 3")
    write("two.csl", "\n".join(lines) + "\n")


def digest(path):
    content = open(path, "rb").read()
    if path.endswith(".vdb"):
        content = re.sub(rb"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}", b"", content)
    if path.endswith((".json", ".csv")):
        content = re.sub(rb'"(seconds|peakMemoryBytes|version)": (\{[^}]*\}|[^,\n]*)', b"", content)
        content = re.sub(rb'"notes": \[[^\]]*\]', b"", content)
    return hashlib.sha256(content).hexdigest()


def files_of(folder):
    return {os.path.join(at, name) for at, _, names in os.walk(folder) for name in names}


def main():
    failed = 0
    with tempfile.TemporaryDirectory(prefix="slicemorph-sums-") as folder:
        os.symlink(os.path.join(REPOSITORY, "assets"), os.path.join(folder, "assets"))
        make_inputs(folder)
        for line in COMMANDS.strip().splitlines():
            name, arguments = line.split(None, 1)
            if ONLY and not any(word in name for word in ONLY):
                continue
            before = files_of(folder)
            result = subprocess.run([PROGRAM] + arguments.replace("SMALL", SMALL).split(), cwd=folder, capture_output=True)
            if result.returncode:
                failed += 1
                print("%-17s FAILED: %s" % (name, result.stderr.decode(errors="replace").strip()), flush=True)
                continue
            sums = sorted((os.path.relpath(path, folder), digest(path)) for path in files_of(folder) - before)
            if not sums:
                sums = [("", hashlib.sha256(result.stdout).hexdigest())]
            whole = hashlib.sha256("".join(a + b for a, b in sums).encode()).hexdigest()
            print("%-17s %s  %d files" % (name, whole, len(sums)), flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
