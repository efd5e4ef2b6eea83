#pragma once

#include "engine/frame/align.h"

#include <optional>

namespace slicemorph {

/// Frames of all objects with their slices laid on the first object's.
struct LaidFrames {
  Frames steady;                  ///< each object's slices turned by one angle
  std::optional<Frames> twisted;  ///< by an angle per slice, where that raises the slices' overlap by 0.03
  bool bowed = false;             ///< whether any spine is clearly not straight
};

/// Charts about the objects' own axes, straight or curved. Each object's axis is reversed or not and its
/// slices are turned so that they overlap best with the first object's, minus a small price on turning and
/// bending. Nothing where an object has no valid axis (`fitSpine`). `names`: of the objects, for notes.
std::optional<LaidFrames> framesAlongSpines(const Fields& fields, const std::vector<std::string>& names);

/// The frames with the objects' slices turned by an angle that varies along the spine; nothing where that
/// does not raise the slices' overlap by 0.03.
std::optional<Frames> twistedFrames(const Fields& fields, const std::vector<std::string>& names,
                                    const Frames& frames);

}  // namespace slicemorph
