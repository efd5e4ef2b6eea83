"""Plans and frames."""
from __future__ import annotations

import os
import warnings
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, TYPE_CHECKING, Tuple, Union

import numpy as np

from . import _convert, _core, _options
from ._errors import InputError
from ._grid import Grid, Mesh
from ._progress import reporting
from ._volume import Volume, as_volume

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._option_types import MorphOptions

# What says of a plan, which is in memory, what its frames hold.
_GRIDS, _IMAGES = "frame.####.vdb", "frame.####.nrrd"

When = Union[float, Sequence[float]]


class SlicemorphWarning(UserWarning):
    """What is probably wrong with an input, and what can be done about it."""


def warn_of(notes: Sequence[_core.Note], options: Mapping[str, Any]) -> None:
    """Shows warnings among notes, unless `quiet`."""
    for note in notes:
        if note.severity == "warning" and not options.get("quiet"):
            warnings.warn(str(note), SlicemorphWarning, stacklevel=4)


class Frame:
    """One in-between."""
    __slots__ = ("_core",)

    def __init__(self, core: _core.Frame):
        self._core = core

    @property
    def number(self) -> int:
        """As the program would number it."""
        return self._core.number

    @property
    def t(self) -> Optional[float]:
        """Its time, 0 to 1; None of a blend."""
        return self._core.t

    @property
    def weights(self) -> List[float]:
        """One for each input."""
        return self._core.weights

    @property
    def notes(self) -> List[_core.Note]:
        """What was found while it was made."""
        return self._core.notes

    @property
    def fold_share(self) -> float:
        """Share of the map near the surface that is folded."""
        return self._core.fold_share

    @property
    def grids(self) -> Dict[str, Grid]:
        """All grids of the frame by name, as a .vdb file of the program holds them; none of in-between images."""
        return {core.name: Grid(core) for core in self._core._grids()}

    @property
    def surface(self) -> Grid:
        """The shape as a level set, world units; made when it is asked for where the frame holds fog or an image."""
        return Grid(self._core._shape())

    @property
    def image(self) -> Optional[Volume]:
        """The in-between image; None where the inputs are no images."""
        core = self._core._image()
        return None if core is None else Volume(core)

    def to_numpy(self, grid: Optional[str] = None) -> np.ndarray:
        """Voxels, axes i, j, k: the in-between image, else a grid by name, by default the first one, over its box."""
        image = self.image if grid is None else None
        if image is not None:
            return image.to_numpy()
        grids = self.grids
        name = next(iter(grids)) if grid is None else grid
        if name not in grids:
            raise InputError("there is no grid '%s'; there are %s" % (name, ", ".join(grids) or "none"), "grid")
        return grids[name].to_numpy()

    def to_mesh(self) -> Mesh:
        """The surface, with the colours that the inputs' surfaces have."""
        return Mesh(*self._core._mesh())

    def to_nibabel(self) -> Any:
        """The in-between image as a nibabel.Nifti1Image."""
        image = self.image
        if image is None:
            raise InputError("is no image: the inputs are none", "frame")
        return image.to_nibabel()

    def velocity(self) -> Grid:
        """How fast what is there moves, world units per second (as velocity_unit says), vec3s. Raises InputError."""
        core = self._core._velocity()
        if core is None:
            raise InputError("has no velocities: it is a blend by weights, an image, or planned with velocity=\"none\"", "frame")
        return Grid(core)

    def save(self, path: Any) -> None:
        """Writes the frame as .vdb, .obj, .ply, .stl, .glb or an image, by the extension; the program's bytes."""
        self._core._save(os.fspath(path))

    def as_volume(self) -> Volume:
        """The frame as an input of a function."""
        return self.image or Volume(_convert.grids_input([Grid(core) for core in self._core._grids()], "frame"))

    def __repr__(self):
        when = "t = %g" % self.t if self.t is not None else "weights %s" % self.weights
        return "<slicemorph.Frame %d: %s>" % (self.number, when)


class Plan:
    """How inputs belong together. Frames are made of it in any order."""
    __slots__ = ("_core",)

    def __init__(self, core: _core.Plan):
        self._core = core

    @property
    def notes(self) -> List[_core.Note]:
        """What was found and decided."""
        return self._core.notes

    @property
    def inputs(self) -> List[str]:
        """Names of the inputs."""
        return self._core.inputs

    @property
    def overlap(self) -> float:
        """Of the matched shapes, intersection over union, 0 to 1."""
        return self._core.overlap

    @property
    def turns(self) -> List[Tuple[float, float]]:
        """For each input but the first: degrees by which it is turned, margin to the next best turn (below 0: unknown)."""
        return self._core.turns

    def weights_at(self, t: float) -> List[float]:
        """The weights of a time, 0 to 1, by keys, timing and ease."""
        return self._core.weights_at(t)

    def frame(self, t: Optional[float] = None, *, weights: Optional[Sequence[float]] = None, progress: Any = None) -> Frame:
        """The frame at a time, 0 to 1, or the blend of these weights (one for each input, of sum 1).

        Velocities of a time are those of a sequence of as many frames as `frames` says; a blend has none.
        """
        when = _when(t, weights)
        job = self._core._blend(when) if isinstance(when, list) else self._core._at(when)
        return self._make(job, progress)

    def frames(self, n: Optional[int] = None, *, progress: Any = None) -> Iterator[Frame]:
        """Frames one after another: n evenly from 0 to 1, as `morph --frames n`; by default those of the plan's options."""
        jobs = self._core._jobs(n)
        return (self._make(job, progress) for job in jobs)

    def carry(self, grids: Union[Grid, Sequence[Optional[Grid]]], t: Optional[When] = None, *,
              weights: Optional[Sequence[float]] = None, voxel_size: float = 0.0, conserve: bool = False) -> Grid:
        """The in-between of further grids, which move with the shapes and are blended.

        grids: one for each input, None where it has none; of one alone it is the first input's. All of one type.
        voxel_size: world units; 0: the grids' own. conserve: the total goes straight from the one to the other.
        """
        listed: List[Any] = [grids] + [None] * (len(self.inputs) - 1) \
            if isinstance(grids, Grid) or _convert.is_pyopenvdb(grids) else list(grids)
        cores = [None if g is None else (g if isinstance(g, Grid) else Grid.from_pyopenvdb(g))._core for g in listed]
        return Grid(self._core._carry(cores, _when(t, weights), voxel_size, conserve))

    def apply(self, points: Any, from_: When = 0.0, to: When = 1.0) -> np.ndarray:
        """World positions, N x 3, at `to` of what is at `points` (N x 3) at `from_`: times, or weights; float64."""
        return self._core._apply(np.asarray(points, float), _when(from_, None), _when(to, None))

    def velocity(self, t: float) -> Grid:
        """The velocities of the frame at a time, see Frame.velocity()."""
        return self.frame(t).velocity()

    def save(self, path: Any) -> None:
        """Writes the plan for `morph --plan`; its inputs must have been given as paths."""
        self._core._save(os.fspath(path))

    def _make(self, job: _core.FrameJob, progress: Any) -> Frame:
        with reporting(progress) as report:
            return Frame(_core.Plan._frame(self._core, job, report))

    def __repr__(self):
        return "<slicemorph.Plan of %s>" % ", ".join(self.inputs)


def _when(t: Optional[When], weights: Optional[Sequence[float]]) -> Union[float, List[float]]:
    if (t is None) == (weights is None):
        raise InputError("give a time or weights", "t")
    value: Any = t if weights is None else weights
    return float(value) if np.ndim(value) == 0 else [float(w) for w in value]


def given_inputs(inputs: Tuple[Any, ...]) -> List[_core.Input]:
    return [as_volume(value)._core for value in inputs]


def plan(*inputs: Any, progress: Any = None, **options: Unpack[MorphOptions]) -> Plan:
    """Decides how shapes, fog volumes or images belong together; frames are then made at once.

    inputs: two or more, in the order of time: paths, Volumes, Grids, meshes (vertices, faces), nibabel images, grids of
    pyopenvdb, Frames.
    progress: a function of a stage and a share, 0 to 1, called about twenty times a second; or a bar as tqdm makes them.
    options: all of `slicemorph morph`, see options("morph"); names of several numbers take lists: spacing=(1, 1, 2).
    `output` is only the name by which the program would know what frames hold: "x.vdb" grids, "x.nii" images, "x.obj" the
    surface; by default images of images, grids of all else.
    Raises InputError, IoError, GeometryError, OutOfMemory; Ctrl-C ends it cleanly with KeyboardInterrupt.
    """
    cores = given_inputs(inputs)
    pairs = _options.texts_of("morph", options, ours=("progress",))
    output: Any = options.get("output")
    if output is not None:
        # Not the name counts, but the kind; and frames may be many.
        extension = os.path.basename(os.fspath(output)).partition(".")[2]
        pairs = [pair for pair in pairs if pair[0] != "output"] + [("output", ["frame.####." + extension])]
    else:
        images = bool(cores) and all(core.kind == "image" for core in cores) and "grids" not in options
        pairs.append(("output", [_IMAGES if images else _GRIDS]))
    with reporting(progress) as report:
        made = Plan(_core.Plan(cores, pairs, report))
    warn_of(made.notes, options)
    return made
