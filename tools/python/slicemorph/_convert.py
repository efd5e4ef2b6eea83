"""What other packages have, as inputs, and back."""
from __future__ import annotations

import os
from typing import Any

import numpy as np

from . import _core
from ._errors import InputError
from ._grid import Grid

# NIfTI's world is RAS, ours LPS: x and y are turned round.
LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])


def image_of_nibabel(image: Any, name: str, labels: bool) -> _core.Input:
    """Of a nibabel image of three dimensions; values as get_fdata() has them, in the file's type where it does not scale."""
    array = np.asanyarray(image.dataobj)
    while array.ndim > 3 and array.shape[-1] == 1:
        array = array[..., 0]
    if array.ndim != 3:
        raise InputError("has %d dimensions; give one volume of it: image.slicer[..., 0]" % array.ndim, name or "nibabel image")
    return image_input(array, LPS_FROM_RAS @ np.asarray(image.affine, float), name or nibabel_name(image), labels)


def nibabel_name(image: Any) -> str:
    path = image.get_filename() if hasattr(image, "get_filename") else None
    return os.path.basename(path).split(".")[0] if path else "image"


def image_to_nibabel(array: np.ndarray, affine: np.ndarray) -> Any:
    import nibabel
    image = nibabel.Nifti1Image(array, LPS_FROM_RAS @ affine)
    image.header.set_xyzt_units("mm")
    return image


def image_input(array: Any, affine: np.ndarray, name: str, labels: bool) -> _core.Input:
    return _core.Input._image(name, _image_numbers(np.asarray(array), name), affine, labels)


# Numbers that images have, and what others become where they fit.
_KEPT = ("|u1", "<i2", "<u2", "<i4", "<f4", "<f8")
_WIDER = {"|b1": np.uint8, "|i1": np.int16, "<f2": np.float32}


def _image_numbers(array: np.ndarray, name: str) -> np.ndarray:
    array = array.astype(array.dtype.newbyteorder("="), copy=False)
    kind = array.dtype.str
    if kind in _KEPT:
        return array
    if kind in _WIDER:
        return array.astype(_WIDER[kind])
    if array.dtype.kind in "iu" and array.size:
        if array.min() >= np.iinfo(np.int32).min and array.max() <= np.iinfo(np.int32).max:
            return array.astype(np.int32)
        raise InputError("its values, %d to %d, are beyond 32 bits" % (array.min(), array.max()), name)
    raise InputError("numbers of the type %s are none that images have; there are uint8, int16, uint16, int32, float32, "
                     "float64" % array.dtype, name)


def is_nibabel(value: Any) -> bool:
    return hasattr(value, "dataobj") and hasattr(value, "affine")


def is_pyopenvdb(value: Any) -> bool:
    return type(value).__module__.split(".")[0] in ("pyopenvdb", "openvdb") and hasattr(value, "copyToArray")


def mesh_input(vertices: Any, faces: Any, colors: Any, name: str) -> _core.Input:
    return _core.Input._mesh(name, np.asarray(vertices), np.asarray(faces), colors)


def mesh_colors(mesh: Any) -> Any:
    """Colours of a trimesh-like mesh as numbers 0 to 1; None: it has none of its own."""
    if getattr(mesh, "colors", None) is not None:
        return np.asarray(mesh.colors)
    visual: Any = getattr(mesh, "visual", None)
    if getattr(visual, "kind", None) == "vertex":
        return np.asarray(visual.vertex_colors, np.float32)[:, :3] / 255
    return None


def grids_input(grids: Any, name: str) -> _core.Input:
    cores = [(grid if isinstance(grid, Grid) else Grid.from_pyopenvdb(grid))._core for grid in grids]
    return _core.Input._grids(name or (cores[0].name if cores else ""), cores)
