#!/usr/bin/env python3
"""Displacement fields of `apply --field` in ITK's convention: resampled by elastix' transformix, and inverse to each other.

usage: displacement_field_test.py PATH/TO/slicemorph [NAME...]     (NAME: only the cases whose name contains it)
"""
import os
import shutil
import subprocess
import sys
import zlib

sys.path.append("/usr/lib/python3/dist-packages")
import nibabel as nib
import numpy as np
from scipy.ndimage import binary_erosion, map_coordinates

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cases import Skip, run_within
from program import Program

if len(sys.argv) < 2:
    sys.exit(__doc__)
ONLY = sys.argv[2:]
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
SIZE, SPACING, ORIGIN = (72, 64, 50), np.array([1.0, 1.1, 1.5]), np.array([-36.0, -34.0, -37.0])


program = Program(sys.argv[1])
run = program.run


def places():
    """LPS positions of all voxels."""
    return np.stack(np.meshgrid(*[np.arange(n) for n in SIZE], indexing="ij"), -1) * SPACING + ORIGIN


def save(name, values):
    affine = np.diag([*SPACING, 1.0])
    affine[:3, 3] = ORIGIN
    nib.save(nib.Nifti1Image(values.astype(np.float32), LPS @ affine), name)


def read_mha(path):
    """Components x i x j x k; numbers are floats."""
    head, _, body = open(path, "rb").read().partition(b"ElementDataFile = LOCAL\n")
    fields = dict(line.split(" = ", 1) for line in head.decode().splitlines())
    if fields.get("CompressedData") == "True":
        body = zlib.decompress(body)
    sizes = [int(fields.get("ElementNumberOfChannels", 1)), *map(int, fields["DimSize"].split())]
    return np.frombuffer(body, "<f4").reshape(sizes, order="F")


def write_shapes():
    """A pear-like body and another one, turned, moved and of other sides; and a picture of waves. Masks of both."""
    p = places()

    def body(middle, sides, angle):
        c, s = np.cos(angle), np.sin(angle)
        q = (p - middle) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        return np.sqrt(((q / (np.array(sides) * (1 + 0.2 * q[..., 2:] / 25))) ** 2).sum(-1))

    distances = [body([0, 0, 0], [12, 16, 25], 0), body([2, -2, 1], [14, 15, 22], 0.3)]
    for name, d in zip("ab", distances):
        save(name + ".nii.gz", 1000 / (1 + np.exp((d - 1) * 15)))
    save("g.nii.gz", 100 * (np.sin(p[..., 0] / 6) + np.cos(p[..., 1] / 7) + np.sin(p[..., 2] / 8)))
    return [d < 1 for d in distances]


PLANNED = ("--plan", "x.plan")


def write_fields():
    run("plan", "a.nii.gz", "b.nii.gz", "-o", "x.plan", "--iso", 500)
    for name, start, end in (("f01", 0, 1), ("f10", 1, 0)):
        run("apply", "--field", "-o", name + ".mha", "--like", "a.nii.gz", "--from", start, "--to", end, *PLANNED)
    return read_mha("f01.mha"), read_mha("f10.mha")


def moved(values, field):
    """Values at the places where a field leads to from each voxel, trilinear."""
    index = np.stack(np.meshgrid(*[np.arange(n) for n in SIZE], indexing="ij"))
    return map_coordinates(values, index + field / SPACING[:, None, None, None], order=1, mode="nearest")


def case_inverse():
    """There and back again is where one was: points to a hundredth of a voxel; by the fields, trilinear, to a tenth wherever
    the voxels that are interpolated lie inside (at the outline the map is curved, see the next case)."""
    inside = write_shapes()
    fields = write_fields()
    for start, (there, back, mask) in enumerate(((fields[0], fields[1], inside[0]), (fields[1], fields[0], inside[1]))):
        left = there + np.stack([moved(part, there) for part in back])
        assert np.abs(there[:, mask]).max() > 2, "nothing moves"
        voxels = np.linalg.norm(left / SPACING[:, None, None, None], axis=0)
        assert voxels[binary_erosion(mask)].max() < 0.1, voxels[binary_erosion(mask)].max()
        assert np.percentile(voxels[mask], 99) < 0.1
        points = places()[mask][::37]
        np.savetxt("p.csv", points, "%.9g", ",", header="x,y,z", comments="")
        for source, target, t in (("p.csv", "q.csv", start), ("q.csv", "r.csv", 1 - start)):
            run("apply", source, "-o", target, "--from", t, "--to", 1 - t, *PLANNED)
        again = np.loadtxt("r.csv", delimiter=",", skiprows=1)
        assert np.linalg.norm((again - points) / SPACING, axis=1).max() < 0.01


def case_inverse_of_finer_fields():
    """What is left between forward and back at the outline is the fields' sampling: with half the voxels' spacing it is below a
    tenth of a voxel everywhere inside."""
    inside = write_shapes()
    write_fields()
    affine = np.diag([*SPACING / 2, 1.0])
    affine[:3, 3] = ORIGIN
    nib.save(nib.Nifti1Image(np.zeros([2 * n - 1 for n in SIZE], np.uint8), LPS @ affine), "fine.nii.gz")
    fields = []
    for start, end in ((0, 1), (1, 0)):
        run("apply", "--field", "-o", "fine.mha", "--like", "fine.nii.gz", "--from", start, "--to", end, *PLANNED)
        fields.append(read_mha("fine.mha"))
    index = np.stack(np.meshgrid(*[np.arange(n) for n in SIZE], indexing="ij"))
    for there, back, mask in ((*fields, inside[0]), (*fields[::-1], inside[1])):
        there = there[:, ::2, ::2, ::2]
        at = 2 * (index + there / SPACING[:, None, None, None])
        left = there + np.stack([map_coordinates(part, at, order=1, mode="nearest") for part in back])
        voxels = np.linalg.norm(left / SPACING[:, None, None, None], axis=0)[mask]
        assert voxels.max() < 0.1, voxels.max()


def transformed(transform):
    """`g.mha` as transformix draws it on the voxels of A with trilinear interpolation. transform: the file's lines on it."""
    with open("t.txt", "w") as file:
        file.write(transform + """(InitialTransformParametersFileName "NoInitialTransform")
(HowToCombineTransforms "Compose")
(FixedImageDimension 3)
(MovingImageDimension 3)
(FixedInternalImagePixelType "float")
(MovingInternalImagePixelType "float")
(Size %d %d %d)
(Index 0 0 0)
(Spacing %g %g %g)
(Origin %g %g %g)
(Direction 1 0 0 0 1 0 0 0 1)
(UseDirectionCosines "true")
(ResampleInterpolator "FinalBSplineInterpolator")
(FinalBSplineInterpolationOrder 1)
(Resampler "DefaultResampler")
(DefaultPixelValue 0)
(ResultImageFormat "mha")
(ResultImagePixelType "float")
(CompressResultImage "false")
""" % (*SIZE, *SPACING, *ORIGIN))
    os.mkdir("out")
    subprocess.run(["transformix", "-in", "g.mha", "-tp", "t.txt", "-out", "out"], check=True, capture_output=True, timeout=300)
    return read_mha("out/result.mha")[0]


def case_transformix():
    """transformix draws an image of B in A's frame as trilinear interpolation along the field does; so does `apply`."""
    if not shutil.which("transformix"):
        raise Skip("elastix is not installed")
    inside, _ = write_shapes()
    field, _ = write_fields()
    run("convert", "g.nii.gz", "-o", "g.mha")
    drawn = transformed("""(Transform "DeformationFieldTransform")
(NumberOfParameters 0)
(DeformationFieldFileName "f01.mha")
(DeformationFieldInterpolationOrder 1)
""")
    waves = nib.load("g.nii.gz").get_fdata()
    own = moved(waves, field)
    # Floats of 32 bits: positions of some 50 mm to 4e-6 mm, on a slope of at most 17 a millimetre for each axis.
    assert np.abs(drawn - own)[inside].max() < 0.01, np.abs(drawn - own)[inside].max()
    assert np.abs(waves - own)[inside].max() > 20, "nothing moves"
    run("apply", "g.nii.gz", "--from", 1, "--to", 0, "-o", "carried.nii.gz", "--like", "a.nii.gz", *PLANNED)
    carried = nib.load("carried.nii.gz").get_fdata()
    assert np.abs(drawn - carried)[inside].max() < 1, np.abs(drawn - carried)[inside].max()


def case_metaimage_by_itk():
    """ITK reads our compressed MetaImage: transformix with no transform gives the same values."""
    if not shutil.which("transformix"):
        raise Skip("elastix is not installed")
    write_shapes()
    run("convert", "g.nii.gz", "-o", "g.mha")
    drawn = transformed("""(Transform "TranslationTransform")
(NumberOfParameters 3)
(TransformParameters 0 0 0)
""")
    # Positions that are voxels but for rounding, on a slope of at most 17 a millimetre.
    assert np.abs(drawn - nib.load("g.nii.gz").get_fdata()).max() < 1e-3


sys.exit(run_within(globals(), ONLY))
