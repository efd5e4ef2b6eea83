#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Whether two grids have the same transform, topology and active values.
inline bool sameValues(const FloatGrid& a, const FloatGrid& b) {
  if (a.transform() != b.transform() || !a.tree().hasSameTopology(b.tree())) return false;
  for (auto it = a.cbeginValueOn(); it; ++it)
    if (b.tree().getValue(it.getCoord()) != *it) return false;
  return true;
}

}  // namespace slicemorph
