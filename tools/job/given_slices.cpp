#include "tools/job/given_slices.h"

#include "slicemorph/errors.h"

#include <algorithm>

namespace slicemorph {
namespace {

GivenSlices everySlice(int axis, int gap, int count) {
  GivenSlices given;
  given.axis = axis;
  for (int n = 0; n < count; ++n) given.at.push_back(n * gap);
  return given;
}

/// The axis of slices that the job names: that along which nothing is labelled on others.
int axisOfNamed(const ReconstructJob& job, const LabelledSlices& labelled, const ImageLattice& lattice) {
  std::string why;
  for (int axis = 0; axis < 3; ++axis) {
    if (job.axis >= 0 && axis != job.axis) continue;
    const std::vector<char>& found = labelled.along(axis);
    const std::string where = std::string(" along axis ") + "ijk"[axis];
    if (job.given.back() >= lattice.size[axis]) {
      why += "; there are " + std::to_string(lattice.size[axis]) + where;
      continue;
    }
    int other = -1;
    for (int at = 0; at < int(found.size()) && other < 0; ++at)
      if (found[size_t(at)] && !std::binary_search(job.given.begin(), job.given.end(), at)) other = at;
    if (other < 0) return axis;
    why += "; slice " + std::to_string(other) + where + " is labelled, too";
  }
  throw InputError(job.input + ": --given does not fit the map" + why);
}

/// Of equal steps: leaves out the empty slices that were not drawn: those within one body, and all where no two
/// labelled slices are one step apart.
std::vector<int> drawn(const GivenSlices& found, const std::vector<char>& labelled,
                       const DrawnSlices& slices) {
  std::vector<int> at;
  int step = found.at.back() - found.at.front(), least = step;
  for (size_t i = 1, last = 0; i < found.at.size(); ++i) {
    step = std::min(step, found.at[i] - found.at[i - 1]);
    if (labelled[size_t(found.at[i])]) least = std::min(least, found.at[i] - found.at[last]), last = i;
  }
  for (const int slice : found.at)
    if (labelled[size_t(slice)] || (least == step && !slices.goesOnOver(slice))) at.push_back(slice);
  return at;
}

}  // namespace

GivenSlices givenSlices(const ReconstructJob& job, const LabelledSlices& labelled,
                        const ImageLattice& lattice) {
  if (job.between > 0) {
    const int axis = job.axis < 0 ? int(openvdb::math::MaxIndex(lattice.spacing())) : job.axis;
    if (lattice.size[axis] < 2)
      throw InputError(job.input + " has one slice along axis " + std::string(1, "ijk"[axis]) +
                       "; a surface needs two or more");
    return everySlice(axis, job.between + 1, lattice.size[axis]);
  }
  if (!job.given.empty()) return {axisOfNamed(job, labelled, lattice), job.given, {}};
  try {
    return findGivenSlices(labelled, job.axis, job.every);
  } catch (const InputError& error) {
    throw InputError(job.input + ": " + error.what() +
                     "; --between N puts N slices between every two of a stack");
  }
}

bool areFound(const ReconstructJob& job) { return job.between == 0 && job.every == 0 && job.given.empty(); }

GivenSlices whatWasDrawn(GivenSlices found, const LabelledSlices& labelled, const DrawnSlices& slices) {
  found.at = drawn(found, labelled.along(found.axis), slices);
  found.own = slices.ownSlices(found.at);
  return found;
}

ImageLattice expandedLattice(const ImageLattice& lattice, int axis, int between) {
  ImageLattice result = lattice;
  const int gap = between + 1;
  result.size[axis] = (lattice.size[axis] - 1) * gap + 1;
  result.step[axis] /= gap;
  return result;
}

/// The stack with `between` empty slices between every two.
Image expandedStack(const Image& stack, int axis, int between) {
  Image result{expandedLattice(stack.lattice, axis, between), {}};
  std::visit(
      [&](const auto& from) {
        std::decay_t<decltype(from)> to(result.lattice.count(), 0);
        const openvdb::Coord n = stack.lattice.size;
        for (int k = 0; k < n[2]; ++k)
          for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
              openvdb::Coord at(i, j, k);
              at[axis] *= between + 1;
              to[result.lattice.index(at[0], at[1], at[2])] = from[stack.lattice.index(i, j, k)];
            }
        result.values = std::move(to);
      },
      stack.values);
  return result;
}

namespace {

/// "0, 10, 25"; of many the first and the last.
std::string listed(const std::vector<int>& at) {
  constexpr size_t kMost = 12;
  if (at.size() > kMost) return "from " + std::to_string(at.front()) + " to " + std::to_string(at.back());
  std::string list;
  for (const int slice : at) list += (list.empty() ? "" : ", ") + std::to_string(slice);
  return list;
}

}  // namespace

std::string described(const GivenSlices& given) {
  const int first = given.at.size() > 1 ? given.at[1] - given.at[0] : 0;
  const bool even = std::adjacent_find(given.at.begin(), given.at.end(),
                                       [&](int a, int b) { return b - a != first; }) == given.at.end();
  return std::to_string(given.at.size()) + " given slices along axis " + std::string(1, "ijk"[given.axis]) +
         (even ? ", every " + std::to_string(first) + ", from " + std::to_string(given.at.front()) + " to " +
                     std::to_string(given.at.back())
               : ", unevenly, " + listed(given.at));
}

Notes notesOf(const GivenSlices& given, const std::vector<char>& labelled) {
  Notes notes{{"reconstruct.given-slices", Severity::kNote, "", described(given)}};
  std::vector<int> empty;
  for (const int at : given.at)
    if (size_t(at) < labelled.size() && !labelled[size_t(at)]) empty.push_back(at);
  if (!empty.empty())
    notes.emplace_back("reconstruct.empty-slices", Severity::kNote, "",
                       "slices without labels taken as given, nothing is there: " + listed(empty) +
                           "; --given K,K,... names the slices that were drawn");
  constexpr size_t kNamed = 8;
  for (size_t i = 0; i < std::min(given.own.size(), kNamed); ++i)
    notes.emplace_back(
        "reconstruct.own-slices", Severity::kNote, "label " + std::to_string(given.own[i].label),
        "was drawn on slices of its own, and is filled in between those: " + listed(given.own[i].at) +
            "; --given K,K,... says that all labels are on the same");
  if (given.own.size() > kNamed)
    notes.emplace_back("reconstruct.own-slices", Severity::kNote, "",
                       std::to_string(given.own.size() - kNamed) + " more labels have slices of their own");
  return notes;
}

}  // namespace slicemorph
