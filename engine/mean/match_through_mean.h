#pragma once

#include "engine/match/register.h"

namespace slicemorph {

/// The matching of more than two objects: their mean shape by the map so far is built, each object is matched
/// with it as one of a pair is, and what lies at a point of the mean is moved to the mean of its positions on
/// all of them. So every object is matched as well as two are, none is special, and the work grows with their
/// number. (Unbiased atlases [JDJG04].) `start`: of all objects; taken over but for the map. `frames`: of
/// the objects, from which their charts are. `names`: of the objects, for notes.
Registration matchThroughMean(Registration start, const MatchObjects& objects, const Frames& frames,
                              const std::vector<std::string>& names, const MorphOptions& options,
                              Progress& progress);

}  // namespace slicemorph
