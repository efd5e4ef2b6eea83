#pragma once

#include "slicemorph/errors.h"

namespace slicemorph {

/// A file that is fine but holds nothing: a grid without active voxels, or without any inside a surface; a mesh without
/// points and faces. In a sequence that is a frame like others.
struct NothingError : GeometryError {
  using GeometryError::GeometryError;
};

}  // namespace slicemorph
