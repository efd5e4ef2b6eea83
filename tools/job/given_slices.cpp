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
  try {
    return findGivenSlices(labelled, job.axis, job.every);
  } catch (const InputError& error) {
    throw InputError(job.input + ": " + error.what() +
                     "; --between N puts N slices between every two of a stack");
  }
}

ImageLattice expandedLattice(const ImageLattice& lattice, int axis, int between) {
  ImageLattice result = lattice;
  const int gap = between + 1;
  result.size[axis] = (lattice.size[axis] - 1) * gap + 1;
  result.step[axis] /= gap;
  return result;
}

std::string described(const GivenSlices& given) {
  const int first = given.at.size() > 1 ? given.at[1] - given.at[0] : 0;
  const bool even = std::adjacent_find(given.at.begin(), given.at.end(),
                                       [&](int a, int b) { return b - a != first; }) == given.at.end();
  return std::to_string(given.at.size()) + " given slices along axis " + std::string(1, "ijk"[given.axis]) +
         (even ? ", every " + std::to_string(first) : ", unevenly") + ", from " +
         std::to_string(given.at.front()) + " to " + std::to_string(given.at.back());
}

}  // namespace slicemorph
