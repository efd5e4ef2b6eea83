#pragma once

#include "engine/frame/align.h"

#include <optional>

namespace slicemorph {

/// Charts about the objects' own curved axes, laid on the first object's: the axis this way or the other way round, and
/// turned in the slice planes, as the slices overlap best, less a small price on the turn. Nothing where an object has
/// no sound axis (`fitSpine`), or where all axes are straight.
std::optional<Frames> curvedFrames(const Fields& fields);

/// The frames with the objects' slices turned in their planes by an angle that changes along the spine; nothing where no
/// object's slices overlap the first object's by 3 % better for it.
std::optional<Frames> twistedFrames(const Fields& fields, const Frames& frames);

}  // namespace slicemorph
