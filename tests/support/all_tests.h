#pragma once

#include <cstdlib>

namespace slicemorph {

/// Whether every case is to be run: with SLICEMORPH_ALL_TESTS set. Without it some of many like cases are
/// left out, to keep the tests below ten minutes.
inline bool allTests() { return std::getenv("SLICEMORPH_ALL_TESTS") != nullptr; }

}  // namespace slicemorph
