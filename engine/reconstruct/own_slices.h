#pragma once

#include "engine/reconstruct/label_slices.h"

namespace slicemorph {

/// Labels that were given on the same slices.
struct LabelGroup {
  std::vector<int> labels;  ///< ascending; none: all that are in no other group
  GivenSlices given;        ///< without labels of their own
};

/// The labels with slices of their own, together where these are the same, and first all others.
std::vector<LabelGroup> groupsOf(const GivenSlices& given);

/// The map with one group's labels alone; 0 elsewhere.
Image onlyGroup(const Image& labels, const std::vector<LabelGroup>& groups, size_t group);

/// Writes a group, filled in between its slices, into what the groups before it left. Where two meet, that stays
/// whose own slice is nearer. `given`: the map of given slices, whose labels stay.
void mergeGroup(const Image& given, const std::vector<LabelGroup>& groups, size_t group, const Image& filled,
                Image& dense);

}  // namespace slicemorph
