"""Inputs: everything that can be morphed, in memory or by its name."""
from __future__ import annotations

import os
from typing import Any, Dict, List, TYPE_CHECKING

import numpy as np

from . import _convert, _core, _options
from ._errors import InputError
from ._grid import Grid, Mesh, affine_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._option_types import ConvertOptions


class Volume:
    """A mesh, an image, or grids, as an input.

    Made by load(), from_numpy(), from_mesh(), from_grids(), from_nibabel() and from_pyopenvdb(). What it holds never changes.
    Sequences (name.####.vdb), inputs with braces behind their names, and contours are only named: they are read where they
    are used.
    """
    __slots__ = ("_core",)

    def __init__(self, core: _core.Input):
        self._core = core

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def kind(self) -> str:
        """"mesh", "image", "grids", "sequence", "contours" or "slices"."""
        return self._core.kind

    @property
    def notes(self) -> List[_core.Note]:
        """What was found while it was read."""
        return self._core._notes()

    def to_numpy(self) -> np.ndarray:
        """The voxels of an image, axes i, j, k, without a copy: it cannot be written to. Of one grid a dense copy."""
        if self.kind == "grids":
            grids = self.grids
            if len(grids) != 1:
                raise InputError("holds %d grids; choose one: .grids[name].to_numpy()" % len(grids), self.name)
            return next(iter(grids.values())).to_numpy()
        return self._core._voxels()

    def to_nibabel(self) -> Any:
        """An image as a nibabel.Nifti1Image, whose world is RAS; it shares the voxels."""
        return _convert.image_to_nibabel(self._core._voxels(), self.affine)

    def to_mesh(self, **options: Unpack[ConvertOptions]) -> Mesh:
        """The surface; of a mesh without options its own faces, as triangles. Options: as of level_set()."""
        if self.kind == "mesh" and not options:
            return Mesh(*self._core._own_mesh())
        grid, colors, _ = self._core._shape(_options.texts_of("convert", options))
        return Mesh(*_core._shape_mesh(grid, colors))

    def level_set(self, **options: Unpack[ConvertOptions]) -> Grid:
        """The shape as a level set: voxel_size, resolution, iso, image and others of options("convert")."""
        return Grid(self._core._shape(_options.texts_of("convert", options))[0])

    @property
    def grids(self) -> Dict[str, Grid]:
        """Grids by name, in their order; of several of one name the second is name[1]."""
        named: Dict[str, Grid] = {}
        for core in self._core._grids_in():
            name, n = core.name, 1
            while name in named:
                name, n = "%s[%d]" % (core.name, n), n + 1
            named[name] = Grid(core)
        return named

    @property
    def affine(self) -> np.ndarray:
        """Of an image, 4 x 4: from voxels (i, j, k) to the world, LPS millimetres."""
        return self._core._affine()

    @property
    def spacing(self) -> np.ndarray:
        """Of an image: three edges of a voxel, millimetres."""
        return np.linalg.norm(self.affine[:3, :3], axis=0)

    @property
    def origin(self) -> np.ndarray:
        """Of an image: world position of the centre of voxel (0, 0, 0)."""
        return self.affine[:3, 3]

    @property
    def direction(self) -> np.ndarray:
        """Of an image, 3 x 3: columns are the world directions of the axes i, j, k."""
        return self.affine[:3, :3] / self.spacing

    def save(self, path: Any) -> None:
        """Writes grids as .vdb, an image by the extension. Raises IoError."""
        self._core._save(os.fspath(path))

    def __repr__(self):
        return "<slicemorph.Volume %r: %s>" % (self.name, self.kind)


def load(path: Any, **options: Unpack[ConvertOptions]) -> Volume:
    """Reads any input, named as on the command line: "a.vdb:density", "scan.nii.gz", "folder:2", "name.####.png", "b.obj".

    options: those by which files are read: spacing (of picture stacks, three numbers, millimetres), memory.
    Raises IoError, InputError.
    """
    return Volume(_core.Input._open(os.fspath(path), _options.texts_of("convert", options)))


def from_numpy(array: Any, spacing: Any = None, origin: Any = None, direction: Any = None, *, affine: Any = None,
               name: str = "array", labels: bool = False) -> Volume:
    """An image of an array of axes i, j, k.

    array: uint8, int16, uint16, int32, float32, float64; others are converted where no value changes. It is copied.
    spacing: edge of a voxel, one number or three; origin: world position of the centre of voxel (0, 0, 0); direction: 3 x 3,
    a column for each axis of the array; or affine: 4 x 4. World units, in scans LPS millimetres.
    name: for messages. labels: its values are labels, whatever they look like.
    Raises InputError.
    """
    return Volume(_convert.image_input(array, affine_of(affine, spacing, origin, direction), name, labels))


def from_mesh(mesh: Any, faces: Any = None, *, colors: Any = None, name: str = "mesh") -> Volume:
    """A mesh: an object with `vertices` and `faces` (trimesh.Trimesh), or the two arrays.

    vertices: N x 3, world units. faces: M x 3 (or more corners, all alike), indices. colors: N x 3, 0 to 1.
    It need not be closed: holes are closed, and sheets given a thickness, as files' are. Raises InputError.
    """
    if faces is None:
        colors = _convert.mesh_colors(mesh) if colors is None else colors
        mesh, faces = mesh.vertices, mesh.faces
    return Volume(_convert.mesh_input(mesh, faces, colors, name))


def from_grids(*grids: Any, name: str = "") -> Volume:
    """Grids (of slicemorph or pyopenvdb) as if they were those of one VDB file."""
    return Volume(_convert.grids_input(grids, name))


def from_nibabel(image: Any, *, name: str = "", labels: bool = False) -> Volume:
    """A nibabel image of one volume; its RAS world becomes LPS."""
    return Volume(_convert.image_of_nibabel(image, name, labels))


def from_pyopenvdb(*grids: Any, name: str = "") -> Volume:
    """Grids of pyopenvdb as if they were those of one VDB file."""
    return from_grids(*grids, name=name)


def as_volume(value: Any) -> Volume:
    """What functions take as an input: a Volume, a path, and all that the functions above take but for bare arrays."""
    if isinstance(value, Volume):
        return value
    if isinstance(value, (str, os.PathLike)):
        return Volume(_core.Input._named(os.fspath(value)))
    if hasattr(value, "as_volume"):
        return value.as_volume()
    if isinstance(value, Grid) or _convert.is_pyopenvdb(value):
        return from_grids(value)
    if _convert.is_nibabel(value):
        return from_nibabel(value)
    if hasattr(value, "vertices") and hasattr(value, "faces"):
        return from_mesh(value)
    if isinstance(value, (list, tuple)) and value and all(isinstance(v, Grid) or _convert.is_pyopenvdb(v) for v in value):
        return from_grids(*value)
    if isinstance(value, tuple) and len(value) == 2:
        return from_mesh(*value)
    if isinstance(value, np.ndarray):
        raise InputError("an array alone does not say where it lies: from_numpy(array, spacing, origin)", "input")
    raise InputError("%s is no input: give a path, a Volume, a Grid, a mesh with vertices and faces, a nibabel image or a "
                     "grid of pyopenvdb" % type(value).__name__, "input")
