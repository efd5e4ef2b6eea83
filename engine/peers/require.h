#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/slicemorph.h"

#include <string>

/// What the classic methods refuse in the same words.
namespace slicemorph {

/// Throws InputError unless there is one weight per object.
void requireWeights(const Weights& weights, size_t objects);

/// Throws InputError for a `count` of more than `most`, or one that is no number, which a smaller resolution would lower. `needs`: the
/// message up to the count.
void requireAtMost(const std::string& needs, double count, double most);

}  // namespace slicemorph
