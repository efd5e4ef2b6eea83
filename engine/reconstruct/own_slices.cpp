#include "engine/reconstruct/own_slices.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <unordered_map>

namespace slicemorph {

namespace {

/// By label the group that it is in; labels of the first group are not listed.
std::unordered_map<int, size_t> groupNumbers(const std::vector<LabelGroup>& groups) {
  std::unordered_map<int, size_t> numbers;
  for (size_t g = 1; g < groups.size(); ++g)
    for (const int label : groups[g].labels) numbers[label] = g;
  return numbers;
}

size_t groupOf(const std::unordered_map<int, size_t>& numbers, int label) {
  const auto found = numbers.find(label);
  return found == numbers.end() ? 0 : found->second;
}

/// Slices from one to the nearest of a group's.
int toNearest(const LabelGroup& group, int at) {
  int nearest = 1 << 30;
  for (const int given : group.given.at) nearest = std::min(nearest, std::abs(given - at));
  return nearest;
}

}  // namespace

std::vector<LabelGroup> groupsOf(const GivenSlices& given) {
  std::vector<LabelGroup> groups{{{}, {given.axis, given.at, {}}}};
  std::map<std::vector<int>, std::vector<int>> own;
  for (const OwnSlices& one : given.own) own[one.at].push_back(one.label);
  for (auto& [at, labels] : own) groups.push_back({std::move(labels), {given.axis, at, {}}});
  return groups;
}

Image onlyGroup(const Image& labels, const std::vector<LabelGroup>& groups, size_t group) {
  Image only = labels;
  const std::unordered_map<int, size_t> numbers = groupNumbers(groups);
  std::visit(
      [&](auto& values) {
        for (auto& value : values)
          if (value != 0 && groupOf(numbers, int(value)) != group) value = 0;
      },
      only.values);
  return only;
}

void mergeGroup(const Image& given, const std::vector<LabelGroup>& groups, size_t group, const Image& filled,
                Image& dense) {
  const std::unordered_map<int, size_t> numbers = groupNumbers(groups);
  const int axis = groups[group].given.axis;
  const openvdb::Coord size = given.lattice.size;
  std::vector<std::vector<int>> nearest;
  for (const LabelGroup& one : groups) {
    nearest.emplace_back();
    for (int at = 0; at < size[axis]; ++at) nearest.back().push_back(toNearest(one, at));
  }
  const auto& from = filled.values;
  std::visit(
      [&](auto& out) {
        using T = std::decay_t<decltype(out)>;
        const T& added = std::get<T>(from);
        const T& kept = std::get<T>(given.values);
        for (int k = 0; k < size[2]; ++k)
          for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i) {
              const size_t n = given.lattice.index(i, j, k);
              if (added[n] == 0 || (kept[n] != 0 && kept[n] != added[n])) continue;
              const size_t at = size_t(openvdb::Coord(i, j, k)[axis]);
              const size_t other = groupOf(numbers, int(out[n]));
              if (out[n] == 0 || nearest[group][at] < nearest[other][at]) out[n] = added[n];
            }
      },
      dense.values);
}

}  // namespace slicemorph
