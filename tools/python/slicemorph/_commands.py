"""The program's other commands."""
from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, TYPE_CHECKING, Union

import numpy as np

from . import _core, _options
from ._grid import Mesh
from ._plan import given_inputs, warn_of
from ._progress import reporting
from ._volume import Volume, as_volume

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._option_types import CompareOptions, MorphOptions, ReconstructOptions, RenderOptions, SliceOptions


class Slice(NamedTuple):
    """One slice: pixel [j, i] is at origin + pixel_size (i x_axis + j y_axis), world.

    values: by the name of the grid, float32, rows x columns, of vectors with a third axis of 3.
    """
    values: Dict[str, np.ndarray]
    origin: np.ndarray
    x_axis: np.ndarray
    y_axis: np.ndarray
    normal: np.ndarray
    pixel_size: float


def options(command: str = "morph") -> Dict[str, Dict[str, Any]]:
    """The options of "morph" (of plan() too), "compare", "render", "slice", "reconstruct" or "convert" by their names.

    Each has `name` (on the command line), `type`, `form`, `choices`, `help` with unit, range and default, `group`.
    """
    return dict(_options.table(command))


def morph(*inputs: Any, progress: Any = None, **options: Unpack[MorphOptions]) -> List[str]:
    """Makes a sequence as `slicemorph morph` does: frames, reports, pictures. Returns the files that were written.

    inputs: as of plan(). output: by extension, #### stands for the frame's number. progress: as of plan().
    """
    pairs = _options.texts_of("morph", options, ours=("progress",))
    with reporting(progress) as report:
        outcome = _core._morph(given_inputs(inputs), pairs, report)
    warn_of(outcome.notes, options)
    return outcome.files


def compare(a: Any, b: Any, *, progress: Any = None, **options: Unpack[CompareOptions]) -> Dict[str, Any]:
    """Distance between two surfaces both ways, volumes, areas, topology and overlap; of label maps also label by label.

    Returns what `slicemorph compare --json` prints: a, b (volume, area, pieces, genus), distance and distanceVoxels (mean,
    p95, p99, max), dice, intersection, symmetricDifference, labels. World units; of scans millimetres.
    """
    pairs = _options.texts_of("compare", options, ours=("progress",))
    with reporting(progress) as report:
        result, outcome = _core._compare(as_volume(a)._core, as_volume(b)._core, pairs, report)
    warn_of(outcome.notes, options)
    return result


def render(*inputs: Any, progress: Any = None, **options: Unpack[RenderOptions]) -> np.ndarray:
    """A picture of a shape or fog: float32, rows x columns x 4 (red, green, blue, alpha), linear light.

    Of several inputs, of sequences, and with turntable=N, an array of pictures. output="x.####.png" also writes them.
    For matplotlib: imshow(slicemorph.srgb(picture)).
    """
    pairs = _options.texts_of("render", options, ours=("progress",))
    with reporting(progress) as report:
        pictures, outcome = _core._render(given_inputs(inputs), pairs, report)
    warn_of(outcome.notes, options)
    return pictures[0] if len(pictures) == 1 else np.stack(pictures)


def srgb(picture: np.ndarray) -> np.ndarray:
    """Linear light as a screen shows it, 0 to 1 (IEC 61966-2-1); alpha stays."""
    linear = np.clip(picture[..., :3], 0, 1)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)
    return np.concatenate([shown, picture[..., 3:]], axis=-1)


def slice(volume: Any, *, progress: Any = None, **options: Unpack[SliceOptions]) -> Union[List[Slice], List[str]]:
    """Oriented slices of all grids of a volume; with output="x.####.exr" writes them, and returns the files' names."""
    pairs = _options.texts_of("slice", options, ours=("progress",))
    with reporting(progress) as report:
        made, outcome = _core._slice(as_volume(volume)._core, pairs, report)
    warn_of(outcome.notes, options)
    if made is None:
        return outcome.files
    return [Slice(values, np.array(plane["origin"]), np.array(plane["x_axis"]), np.array(plane["y_axis"]),
                  np.array(plane["normal"]), plane["pixel_size"]) for values, plane in made]


def reconstruct(volume: Any, *, surfaces: bool = False, progress: Any = None, **options: Unpack[ReconstructOptions]) -> Union[Volume, Dict[str, Mesh], List[str]]:
    """What is between slices: of a label map or grey image of which only some slices are given, or of contours.

    Returns a dense image, with `surfaces` the closed surface of each label by its name; with output="x.nii.gz" writes the
    result by its extension, and returns the files' names.
    """
    given: Dict[str, Any] = dict(options)
    in_memory = given.get("output") is None
    if in_memory:
        given["output"] = "made.####.ply" if surfaces else "made.nrrd"
    pairs = _options.texts_of("reconstruct", given, ours=("progress", "surfaces"))
    with reporting(progress) as report:
        image, meshes, outcome = _core._reconstruct(as_volume(volume)._core, pairs, in_memory, report)
    warn_of(outcome.notes, options)
    if not in_memory:
        return outcome.files
    if surfaces:
        return {name: Mesh(*arrays) for name, arrays in meshes.items()}
    assert image is not None  # it was asked for
    return Volume(image)
