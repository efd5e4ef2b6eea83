"""Grids of OpenVDB, and meshes."""
from __future__ import annotations

from typing import Any, NamedTuple, Optional, Tuple

import numpy as np

from . import _core
from ._errors import InputError

Index = Tuple[int, int, int]


class Mesh(NamedTuple):
    """Triangles: closed and wound outwards where they are a shape's.

    vertices: float32, N x 3, world units.
    faces: uint32, M x 3, indices of vertices.
    colors: float32, N x 3, red, green, blue; None: there are none.
    """
    vertices: np.ndarray
    faces: np.ndarray
    colors: Optional[np.ndarray] = None

    def to_trimesh(self) -> Any:
        """A trimesh.Trimesh with the same vertices in the same order."""
        import trimesh
        colors = None if self.colors is None else np.clip(self.colors * 255 + 0.5, 0, 255).astype(np.uint8)
        return trimesh.Trimesh(self.vertices, self.faces.astype(np.int64), vertex_colors=colors, process=False)


def affine_of(affine, spacing, origin, direction) -> np.ndarray:
    """The 4 x 4 matrix that takes voxels to the world, of itself or of its parts."""
    if affine is not None:
        if spacing is not None or origin is not None or direction is not None:
            raise InputError("give it, or spacing, origin and direction, not both", "affine")
        return np.asarray(affine, float)
    matrix = np.eye(4)
    spacing = np.broadcast_to(np.asarray(1.0 if spacing is None else spacing, float), (3,))
    if not np.all(np.isfinite(spacing)) or np.any(spacing <= 0):
        raise InputError("expected one number above 0, or three, not %s" % spacing, "spacing")
    direction = np.eye(3) if direction is None else np.asarray(direction, float)
    if direction.size != 9:
        raise InputError("expected 3 x 3 numbers, a column for each axis of the array", "direction")
    matrix[:3, :3] = direction.reshape(3, 3) * spacing
    matrix[:3, 3] = 0.0 if origin is None else np.asarray(origin, float)
    return matrix


class Grid:
    """A sparse grid. Its values never change; to_numpy() copies them.

    Arrays have the axes i, j, k of the grid's index space, as pyopenvdb's copyToArray has them. `affine` takes positions
    of voxel centres, (i, j, k), to the world.
    """
    __slots__ = ("_core",)

    def __init__(self, core: _core.Grid):
        self._core = core

    @staticmethod
    def from_numpy(array: np.ndarray, spacing: Any = None, origin: Any = None, direction: Any = None, *, affine: Any = None,
                   name: str = "", grid_class: str = "unknown", background: float = 0.0, tolerance: float = 0.0) -> "Grid":
        """A grid of an array of axes i, j, k, or of i, j, k and 3 components.

        array: float32, float64, bool or integers (to int32); read without a copy where it is C-contiguous.
        spacing: edge of a voxel, world units, one number or three; origin: centre of voxel (0, 0, 0), world; direction:
        3 x 3, a column for each axis; or affine: 4 x 4.
        grid_class: "level set" (signed distances in world units, below 0 inside), "fog volume" or "unknown".
        background: value of all that is not stored; values within `tolerance` of it are not stored.
        Raises InputError.
        """
        array = np.asarray(array)
        if array.dtype.kind in "iu":
            array = array.astype(np.int32)
        elif array.dtype.kind == "f" and (array.dtype.itemsize != 8 or not array.dtype.isnative):
            array = array.astype(np.float32, copy=False)
        return Grid(_core.Grid._from_numpy(array, affine_of(affine, spacing, origin, direction), name, grid_class, background,
                                           tolerance))

    @staticmethod
    def from_pyopenvdb(grid: Any) -> "Grid":
        """A grid of pyopenvdb, by the bytes that it is pickled as: values are copied."""
        return Grid(_core.Grid._from_bytes(grid.__getstate__()[1]))

    def to_pyopenvdb(self) -> Any:
        """The same as a grid of pyopenvdb. Raises InputError for value types that pyopenvdb does not have."""
        import pyopenvdb
        for kind in pyopenvdb.GridTypes:
            if kind.valueTypeName == self.value_type:
                grid = kind()
                grid.__setstate__(({}, self._core._to_bytes()))
                return grid
        raise InputError("pyopenvdb has no grids of %s" % self.value_type, "grid '%s'" % self.name)

    def to_numpy(self, box: Optional[Tuple[Index, Index]] = None) -> np.ndarray:
        """A dense array of the voxels of a box, by default that of all active voxels; the same type of numbers.

        box: first and last voxel, both inside. Element [0, 0, 0] is the first one's. Vectors have a fourth axis.
        """
        return self._core._to_numpy(box)

    def to_mesh(self, iso: float = 0.0) -> Mesh:
        """The surface of a grid of floats at a value, world units."""
        return Mesh(*self._core._to_mesh(iso))

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def value_type(self) -> str:
        """As OpenVDB names it: "float", "vec3s"."""
        return self._core.value_type

    @property
    def grid_class(self) -> str:
        return self._core.grid_class.lower()

    @property
    def affine(self) -> np.ndarray:
        """4 x 4: from (i, j, k) to the world."""
        return self._core._affine

    @property
    def voxel_size(self) -> np.ndarray:
        """Three edges, world units."""
        return np.linalg.norm(self.affine[:3, :3], axis=0)

    @property
    def box(self) -> Tuple[Optional[Index], Optional[Index]]:
        """First and last voxel of the box of all active ones; (None, None): there are none."""
        return self._core.box

    @property
    def active_voxels(self) -> int:
        return self._core.active_voxels

    def __repr__(self):
        return "<slicemorph.Grid %r: %s, %s, %d active voxels>" % (self.name, self.value_type, self.grid_class, self.active_voxels)
