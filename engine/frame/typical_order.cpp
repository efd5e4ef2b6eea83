#include "engine/frame/typical_order.h"

#include "engine/volume/moments.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace slicemorph {

namespace {

/// Number of shells, and radius of the outermost one in cube roots of the volume (a ball has
/// 0.62). Chosen by hand.
constexpr size_t kShells = 12;
constexpr double kReach = 1.8;

/// Shape descriptor, invariant to position, rotation and size: half logarithms of the normalised variances
/// and the shares of volume in shells about the centroid (kCompared values). The rest, volume, centroid and
/// covariance, only make the order of objects with equal descriptors definite.
using Description = std::array<double, 3 + kShells + 10>;
constexpr size_t kCompared = 3 + kShells;

Description describe(const DistanceField& field) {
  const Moments moments = insideMoments(field);
  const double size = std::cbrt(moments.volume);
  const Vec3d variances = principalAxes(moments.covariance).variances;
  Description d{};
  for (size_t i = 0; i < 3; ++i) d[i] = 0.5 * std::log(std::max(variances[int(i)] / (size * size), 1e-12));
  double count = 0;
  const openvdb::Coord n = field.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        if (!(field.nodeDistance(x, y, z) < 0)) continue;
        const double radius = (field.nodePosition(x, y, z) - moments.centroid).length() / size;
        d[3 + std::min(size_t(radius / kReach * kShells), kShells - 1)] += 1;
        ++count;
      }
  for (size_t s = 0; s < kShells; ++s) d[3 + s] /= std::max(count, 1.0);
  d[kCompared] = moments.volume;
  for (size_t a = 0; a < 3; ++a) d[kCompared + 1 + a] = moments.centroid[int(a)];
  for (int a = 0, n = kCompared + 4; a < 3; ++a)
    for (int b = a; b < 3; ++b) d[size_t(n++)] = moments.covariance(a, b);
  return d;
}

double squaredDistance(const Description& a, const Description& b) {
  double sum = 0;
  for (size_t i = 0; i < kCompared; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

}  // namespace

std::vector<size_t> typicalOrder(const Fields& fields) {
  std::vector<Description> all(fields.size());
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) { all[k] = describe(*fields[k]); });
  std::vector<size_t> order(fields.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return all[a] < all[b]; });
  Description mean{};  // summed in an order that is the same however the objects are given
  for (size_t k : order)
    for (size_t i = 0; i < mean.size(); ++i) mean[i] += all[k][i] / double(fields.size());
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return squaredDistance(all[a], mean) < squaredDistance(all[b], mean);
  });
  return order;
}

}  // namespace slicemorph
