#include "engine/reconstruct/first_guess.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Planes more than this many times farther than the nearest are ignored; their weight would be below
/// 1 / 5^3.
constexpr double kHeardPlanes = 5;
constexpr double kLeastHeight = 1e-3;  ///< in voxels; closer points count as on the plane

/// The planes that may contribute to points of a row; the row extends `half` to both sides of `middle`.
std::vector<int> planesAlong(const PlaneSet& planes, const Vec3d& middle, const Vec3d& half) {
  std::vector<double> closest(planes.sections.size());
  double least = 1e300;
  for (size_t i = 0; i < closest.size(); ++i) {
    const PlaneContours& frame = planes.sections[i].frame;
    const double height = std::abs(frame.height(middle)), change = std::abs(half.dot(frame.normal));
    closest[i] = height - change;
    least = std::min(least, height + change);
  }
  least = std::max(least, kLeastHeight * planes.step);
  std::vector<int> out;
  for (int i = 0; i < int(closest.size()); ++i)
    if (closest[i] <= kHeardPlanes * least) out.push_back(i);
  return out;
}

/// The weighted mean of the planes' distances at a point, closed beyond the outermost ones. `among` must
/// contain all planes that contribute.
double guessAt(const PlaneSet& planes, const std::vector<int>& among, const Vec3d& p) {
  int nearest = 0;
  double least = 1e300;
  for (int i : among) {
    const double height = std::abs(planes.sections[i].frame.height(p));
    if (height < least) least = height, nearest = i;
  }
  least = std::max(least, kLeastHeight * planes.step);
  double sum = 0, weights = 0;
  for (int i : among) {
    const PlaneContours& frame = planes.sections[i].frame;
    const double height = std::max(std::abs(frame.height(p)), least);
    if (height > kHeardPlanes * least) continue;
    const double share = least / height, weight = share * share * share, far = 4 * planes.gap + height;
    sum += weight * std::clamp(planes.images[i].at(frame.toPlane(p)), -far, far);
    weights += weight;
  }
  double value = sum / weights;
  const PlaneContours& frame = planes.sections[nearest].frame;
  const double height = frame.height(p);
  const int side = height < 0 ? -1 : 1;
  const Vec3d foot = p - height * frame.normal;
  if (planes.endsAt(nearest, foot, side))
    value = std::max(value, std::abs(height) - planes.capHeight(nearest, foot, side));
  return value;
}

}  // namespace

std::vector<float> firstGuess(const PlaneSet& planes, const Lattice& lattice) {
  std::vector<float> values(lattice.count());
  tbb::parallel_for(0, lattice.size[2], [&](int k) {
    constexpr int kTogether = 16;  // nodes of a row for which planes are selected together
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int first = 0; first < lattice.size[0]; first += kTogether) {
        const int end = std::min(first + kTogether, lattice.size[0]);
        const Vec3d from = lattice.position(first, j, k), to = lattice.position(end - 1, j, k);
        const std::vector<int> among = planesAlong(planes, 0.5 * (from + to), 0.5 * (to - from));
        for (int i = first; i < end; ++i)
          values[lattice.index(i, j, k)] = float(guessAt(planes, among, lattice.position(i, j, k)));
      }
  });
  return values;
}

}  // namespace slicemorph
