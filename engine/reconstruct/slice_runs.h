#pragma once

#include "engine/reconstruct/label_slices.h"

namespace slicemorph {

/// Calls visit(x, y, end, label) for every run of equal values in the rows of a slice.
template <typename Visit>
void visitRuns(const LabelSlice& slice, const Visit& visit) {
  const SliceLayout& layout = slice.layout;
  std::visit(
      [&](const auto& values) {
        for (int y = 0; y < layout.height; ++y)
          for (int x = 0, end = 0; x < layout.width; x = end) {
            const auto* row = &values[size_t(slice.at) * layout.slice + size_t(y) * layout.y];
            const auto v = row[size_t(x) * layout.x];
            for (end = x + 1; end < layout.width && row[size_t(end) * layout.x] == v;) ++end;
            visit(x, y, end, int(v));
          }
      },
      slice.values);
}

}  // namespace slicemorph
