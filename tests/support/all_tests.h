#pragma once

#include <cstdlib>

namespace slicemorph {

/// Whether SLICEMORPH_ALL_TESTS is set. Without it some cases that are similar to others are left out, to
/// keep the tests below ten minutes.
inline bool allTests() { return std::getenv("SLICEMORPH_ALL_TESTS") != nullptr; }

}  // namespace slicemorph
