"""slicemorph: morphs volumes through oriented slices.

    import slicemorph
    plan = slicemorph.plan("a.vdb", "b.vdb")
    for frame in plan.frames(24):
        frame.save("m.%04d.vdb" % frame.number)

Inputs are paths, named as on the command line, or what is in memory: load(), from_numpy(), from_mesh(), from_nibabel(),
from_pyopenvdb(), from_grids(). World positions are of voxel centres; images and scans are in LPS millimetres. Arrays have the
axes i, j, k. Options of plan(), morph() and the other functions are the program's, see options().
"""
from . import _options
from ._commands import Slice, compare, morph, options, reconstruct, render, slice, srgb
from ._core import Note, __version__
from ._errors import Cancelled, Error, GeometryError, InputError, IoError, OutOfMemory
from ._grid import Grid, Mesh
from ._plan import Frame, Plan, SlicemorphWarning, plan
from ._volume import Volume, from_grids, from_mesh, from_nibabel, from_numpy, from_pyopenvdb, load

for _function, _command in ((plan, "morph"), (morph, "morph"), (compare, "compare"), (render, "render"), (slice, "slice"),
                            (reconstruct, "reconstruct"), (Volume.level_set, "convert")):
    _function.__doc__ += "\n\n    Options, in groups:\n" + _options.describe(_command)

__all__ = ["Cancelled", "Error", "Frame", "GeometryError", "Grid", "InputError", "IoError", "Mesh", "Note", "OutOfMemory",
           "Plan", "Slice", "SlicemorphWarning", "Volume", "compare", "from_grids", "from_mesh", "from_nibabel", "from_numpy",
           "from_pyopenvdb", "load", "morph", "options", "plan", "reconstruct", "render", "slice", "srgb"]
