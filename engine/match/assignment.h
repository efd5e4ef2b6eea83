#pragma once

#include <vector>

namespace slicemorph {

/// Assignment of least total cost ([Kuh55], [Mun57]; shortest augmenting paths). `cost` has no more
/// rows than columns; returns the column of every row.
std::vector<int> assign(const std::vector<std::vector<double>>& cost);

}  // namespace slicemorph
