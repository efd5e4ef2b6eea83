"""Makes small whole files of every kind that is fuzzed: where mutations begin.

Usage: make_seeds.py SLICEMORPH FOLDER; a folder for each target (targets.cpp) is made in FOLDER."""
import gzip
import os
import shutil
import struct
import subprocess
import sys
import tempfile

sys.path.append("/usr/lib/python3/dist-packages")
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import nibabel as nib
import numpy as np
import pyopenvdb as vdb
import tifffile

from dicom_files import Grid, classic, enhanced, mosaic, segmentation
from meshes import box_obj, sphere_obj

PROGRAM, FOLDER = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])


def run(*arguments):
    subprocess.run([PROGRAM, *arguments, "--quiet"], check=True, stdout=subprocess.DEVNULL)


def keep(target, *paths):
    os.makedirs(os.path.join(FOLDER, target), exist_ok=True)
    for path in paths:
        shutil.copy(path, os.path.join(FOLDER, target))


def text(target, name, lines):
    os.makedirs(os.path.join(FOLDER, target), exist_ok=True)
    with open(os.path.join(FOLDER, target, name), "w") as file:
        file.write(lines)


def meshes():
    box_obj("box.obj", (0, 0, 0), (1, 2, 3))
    sphere_obj("sphere.obj", 1, 4)
    for ending in ("ply", "stl", "glb"):
        run("convert", "box.obj", "-o", "box." + ending, "--resolution", "8")
        keep(ending, "box." + ending)
    keep("obj", "box.obj", "sphere.obj")
    text("obj", "material.obj", "mtllib no.mtl\nusemtl a\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\n"
         "vt 0 0\nvt 1 0\nf 1/1 3/2 2\nf 1 2 4\nf 2 3 4\nf -4 -1 -2\nl 1 2 3\n")
    text("off", "box.off", "COFF\n4 4 6\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n0 0 1 9 9 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
    text("stl", "text.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n")
    text("ply", "text.ply", "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n0 0 1 1 2 3\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
    keep("positions-ply", "box.ply", os.path.join(FOLDER, "ply", "text.ply"))
    keep("positions-glb", "box.glb")
    text("positions-csv", "points.csv", "name,x,y,z\na,1,2,3\nb,4,5,6e-3\n")


def pictures():
    from PIL import Image
    small = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for ending in ("png", "jpg", "bmp", "gif", "tga"):
        try:
            Image.fromarray(small).save("t." + ending)
            keep("texture", "t." + ending)
        except (OSError, KeyError):
            pass
    volume = np.arange(60, dtype=np.uint16).reshape(3, 4, 5)
    tifffile.imwrite("stack.tif", volume, imagej=True, resolution=(2, 2), metadata={"spacing": 3, "unit": "mm"})
    tifffile.imwrite("packed.tif", volume.astype(np.float32), compression="zlib")
    keep("tiff", "stack.tif", "packed.tif")


def grids():
    box = vdb.FloatGrid(3.0)
    box.name, box.gridClass = "surface", vdb.GridClass.LEVEL_SET
    i, j, k = np.mgrid[-3:4, -3:4, -3:4]
    box.copyFromArray(np.clip(np.sqrt(i * i + j * j + k * k) - 2, -3, 3).astype(np.float32), (0, 0, 0), tolerance=0)
    vel = vdb.Vec3SGrid()
    vel.name = "vel"
    vel.fill((0, 0, 0), (2, 2, 2), (1, 2, 3))
    flag = vdb.BoolGrid()
    flag.name = "mask"
    flag.fill((0, 0, 0), (1, 2, 2), True)
    vdb.write("grids.vdb", grids=[box, vel, flag], metadata={"creator": "seed"})
    fog = vdb.FloatGrid()
    fog.name, fog.gridClass, fog.saveFloatAsHalf = "density", vdb.GridClass.FOG_VOLUME, True
    fog.fill((0, 0, 0), (3, 3, 3), 0.5)
    vdb.write("fog.vdb", grids=[fog])
    keep("vdb", "grids.vdb", "fog.vdb"), keep("info-vdb", "grids.vdb")
    run("slice", "grids.vdb:surface", "-o", "s.####.exr", "--slices", "2", "--pixel-size", "1")
    keep("exr-slices", "s.0001.exr")


def images():
    values = (np.arange(5 * 6 * 7).reshape(5, 6, 7) % 90).astype(np.int16)
    affine = np.array([[0, 2, 0, 5], [-1.5, 0, 0, 6], [0, 0, 3, 7], [0, 0, 0, 1.0]])
    nib.save(nib.Nifti1Image(values, affine), "one.nii")
    nib.save(nib.Nifti2Image(np.stack([values, values + 1], 3).astype(np.float32), affine), "two.nii")
    with open("one.nii", "rb") as file, open("packed.nii", "wb") as packed:
        packed.write(gzip.compress(file.read()))
    keep("nifti", "one.nii", "two.nii")
    keep("nifti", "packed.nii")
    nib.save(nib.AnalyzeImage(values, np.diag([2, 2, 2, 1.0])), "old.img")
    keep("analyze", "old.hdr")
    for name, more in (("raw", ""), ("kinds", "kinds: domain domain domain\nspace units: \"um\" \"um\" \"um\"\n")):
        with open(name + ".nrrd", "wb") as file:
            file.write(("NRRD0005\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: 7 6 5\nspace directions: (1,0,0) (0,1,0) (0,0,2)\n"
                        + more + "space origin: (1,2,3)\nendian: little\nencoding: raw\nkey:=value\n\n").encode())
            file.write(values.tobytes())
        keep("nrrd", name + ".nrrd")
    with open("text.nrrd", "w") as file:
        file.write("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 2\nencoding: ascii\n\n1 2 3 4 5 6 7 8\n")
    keep("nrrd", "text.nrrd")
    with open("raw.mha", "wb") as file:
        file.write(b"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
                   b"TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nCenterOfRotation = 0 0 0\nElementSpacing = 1 1 2\nDimSize = 7 6 5\n"
                   b"ElementType = MET_SHORT\nElementDataFile = LOCAL\n")
        file.write(values.tobytes())
    run("convert", "one.nii", "-o", "packed.mha")
    keep("metaimage", "raw.mha", "packed.mha")


def studies():
    grid = Grid(size=(5, 6))
    classic("classic.dcm", grid, 0)
    enhanced("enhanced.dcm", grid, [(k, {}) for k in range(3)])
    mosaic("mosaic.dcm", grid, 4, across=2, normal=grid.normal)
    mask = np.zeros((6, 5), np.uint8)
    mask[1:4, 1:4] = 1
    segmentation("segments.dcm", grid, [(k, 1, mask) for k in range(3)], {1: "a"})
    keep("dicom", "classic.dcm", "enhanced.dcm", "mosaic.dcm", "segments.dcm")
    labels = np.zeros((8, 8, 8), np.uint8)
    labels[2:6, 2:6, 2:6] = 1
    nib.save(nib.Nifti1Image(labels, np.eye(4)), "labels.nii")
    run("convert", "labels.nii", "-o", "s.rt.dcm")
    keep("rtstruct", "s.rt.dcm")
    text("csl", "square.csl", "CSLC\n2 2\n\n1 4 1 0 0 1 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 1 0 1 2 3\n\n2 4 1 0 0 1 -2\n0 0 2\n4 0 2\n4 4 2\n0 4 2\n4 1 0 1 2 3\n")


def texts():
    text("job", "all.toml", 'inputs = ["a.vdb", {file = "b.vdb", scale = 2.0}]\noutput = "o.####.vdb"\nframes = 5\n'
         'keys = [{at = 0, input = "a"}, {at = 0.5, weights = [0.5, 0.5]}, {at = 1, input = "b"}]\n'
         '[[feature]]\nname = "nose"\nkind = "point"\na = [0, 0, 1]\nb = [0, 1, 1]\n'
         '[[region]]\nname = "top"\ncenter = [0, 0, 0]\nradius = 2\nweights = [1, 0]\n')
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "assets", "jobs", "features.toml")) as file:
        text("job", "features.toml", file.read())
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "assets", "jobs", "parts.toml")) as file:
        text("job", "parts.toml", file.read())
    text("landmarks", "points.fcsv", "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = id,x,y,z\n1,1,2,3,0,0,0,1,1,1,0,a,,\n2,4,5,6\n")
    text("landmarks", "points.pts", "point\n2\n1 2 3\n4 5 6 tip\n")
    text("planes", "planes.txt", "ox oy oz nx ny nz\n0 0 0 0 0 1\n0;0;1;0;0.1;1 # leaning\n")
    sphere_obj("ball.obj", 1, 6), box_obj("cube.obj", (0, 0, 0), (1, 1, 1))
    run("plan", "ball.obj", "cube.obj", "-o", "small.plan", "--resolution", "12", "--slices", "8", "--samples", "16")
    keep("plan", "small.plan")


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for make in (meshes, pictures, grids, images, studies, texts):
        make()
    os.chdir("/")
