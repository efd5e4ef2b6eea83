"""Fills in a label map of which only every fourth slice is drawn, by way of nibabel, and compares it with the whole one."""
import nibabel
import numpy as np

import slicemorph

# A drawn structure: an ellipsoid, 1 x 1 x 2 mm voxels, as a nibabel image.
voxels = np.indices((64, 64, 32)).transpose(1, 2, 3, 0)
whole = (np.linalg.norm((voxels - [32, 30, 16]) / [24, 18, 13], axis=-1) < 1).astype(np.uint8)
affine = np.diag([1.0, 1.0, 2.0, 1.0])
sparse = np.zeros_like(whole)
sparse[:, :, ::4] = whole[:, :, ::4]

filled = slicemorph.reconstruct(nibabel.Nifti1Image(sparse, affine), every=4, image="labels")
dice = 2 * np.sum(filled.to_numpy() * whole) / (filled.to_numpy().sum() + whole.sum())
print("Dice with the whole structure: %.4f" % dice)

image = filled.to_nibabel()  # the same world as what came in
assert np.allclose(image.affine, affine)
nibabel.save(image, "filled.nii.gz")
