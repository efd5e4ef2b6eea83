#pragma once

#include "engine/match/register.h"

namespace slicemorph {

/// Matches more than two objects: builds their mean shape by the map so far, matches each object with it as a
/// pair, and recentres the result so that every point of the middle space is the mean of its positions on all
/// objects (unbiased atlas [JDJG04]). So every object is matched as well as one of two, none is special, and
/// the work grows linearly with their number. `start`: of all objects; kept except for the map. `frames`: the
/// objects' coordinate frames. `names`: of the objects, for notes. Throws Cancelled.
Registration matchThroughMean(Registration start, const MatchObjects& objects, const Frames& frames,
                              const std::vector<std::string>& names, const MorphOptions& options,
                              Progress& progress);

}  // namespace slicemorph
