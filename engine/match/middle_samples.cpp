#include "engine/match/middle_samples.h"

#include <tbb/parallel_for.h>

#include <optional>

namespace slicemorph {

namespace {

std::optional<Vec3d> inMiddleSpace(const Matching& matching, size_t object, const Vec3d& a) {
  Vec3d s = matching.guesses.empty() ? a - matching.map.at(object, a) : matching.guesses[object].near(a);
  if (!toMiddle(matching.map, object, a, s)) return std::nullopt;
  return s;
}

}  // namespace

MiddleSamples middleSamples(const Matching& matching, size_t object, const OrientedPoints& points) {
  const size_t n = points.position.size();
  std::vector<std::optional<Vec3d>> middle(n);
  tbb::parallel_for(size_t(0), n,
                    [&](size_t i) { middle[i] = inMiddleSpace(matching, object, points.position[i]); });
  MiddleSamples result;
  double total = 0;
  for (size_t i = 0; i < n; ++i) {
    if (!middle[i]) continue;
    result.points.position.push_back(*middle[i]);
    result.points.normal.push_back(points.normal[i]);
    result.points.mass.push_back(points.mass[i]);
    result.own.push_back(points.position[i]);
    total += points.mass[i];
  }
  for (double& m : result.points.mass) m /= total;
  return result;
}

std::vector<MiddleSamples> middleSamples(const MatchObjects& objects, const Matching& matching, int count) {
  std::vector<MiddleSamples> samples;
  for (size_t k = 0; k < objects.count(); ++k)
    samples.push_back(middleSamples(
        matching, k, thinned(objects.shape.samples[k], objects.ofEach(count), objects.box.min())));
  return samples;
}

}  // namespace slicemorph
