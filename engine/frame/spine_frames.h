#pragma once

#include "engine/frame/align.h"

#include <optional>

namespace slicemorph {

struct LaidFrames {
  Frames steady;
  std::optional<Frames> twisted;  ///< where turning each slice for itself makes slices overlap by 3 % better
  bool bowed = false;             ///< whether any spine is clearly not straight
};

/// Charts about the objects' own axes, straight or curved, laid on the first object's: the axis this way or
/// the other way round, and turned in the slice planes, as the slices overlap best, less a small price on
/// turning and bending. Nothing where an object has no sound axis (`fitSpine`). `names`: of the objects, for
/// notes.
std::optional<LaidFrames> framesAlongSpines(const Fields& fields, const std::vector<std::string>& names);

/// The frames with the objects' slices turned in their planes by an angle that changes along the spine;
/// nothing where that does not make slices overlap by 3 % better.
std::optional<Frames> twistedFrames(const Fields& fields, const std::vector<std::string>& names,
                                    const Frames& frames);

}  // namespace slicemorph
