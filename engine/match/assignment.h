#pragma once

#include <vector>

namespace slicemorph {

/// Assignment of least total cost (Kuhn 1955, Munkres 1957; shortest augmenting paths). `cost` has no more
/// rows than columns; returns the column of every row.
std::vector<int> assign(const std::vector<std::vector<double>>& cost);

}  // namespace slicemorph
