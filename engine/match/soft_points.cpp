#include "engine/match/soft_points.h"

#include <algorithm>
#include <utility>

namespace slicemorph {

namespace {

/// Points that are trusted less than this are left out. Chosen by hand.
constexpr float kLeastTrust = 0.05f;

/// Targets of one object's samples, per object; empty for the object itself.
using TargetsOnOthers = std::vector<SoftTargets>;

std::vector<TargetsOnOthers> matchedPairs(const std::vector<MiddleSamples>& samples, double blur) {
  const size_t objects = samples.size();
  std::vector<TargetsOnOthers> targets(objects, TargetsOnOthers(objects));
  for (size_t j = 0; j < objects; ++j)
    for (size_t k = j + 1; k < objects; ++k) {
      SoftMatch m = softMatch(samples[j].points, samples[k].points, blur);
      targets[j][k] = std::move(m.aToB), targets[k][j] = std::move(m.bToA);
    }
  return targets;
}

/// The correspondence of sample `i` of object `j`.
Correspondence softPoint(const Displacements& map, const std::vector<MiddleSamples>& samples,
                         const TargetsOnOthers& targets, size_t j, size_t i) {
  const size_t objects = samples.size();
  const Vec3d& s = samples[j].points.position[i];
  Correspondence c;
  c.middle = s;
  float best = 0;
  for (size_t k = 0; k < objects; ++k)
    if (k != j) best = std::max(best, float(targets[k].trust[i]));
  for (size_t k = 0; k < objects; ++k) {
    const float trust = k == j ? 0.f : float(targets[k].trust[i]);
    if (!(trust > 0)) {
      c.at.push_back(k == j ? samples[j].own[i] : s + map.at(k, s));
      continue;
    }
    const Vec3d t = s + double(trust / best) * (targets[k].position[i] - s);
    c.at.push_back(t + map.at(k, t));
    c.middle += (t - s) / double(objects);
  }
  c.weight = std::min(1.f, best);
  return c;
}

}  // namespace

std::vector<Correspondence> softPoints(const Displacements& map, const std::vector<MiddleSamples>& samples,
                                       double blur) {
  const std::vector<TargetsOnOthers> targets = matchedPairs(samples, blur);
  std::vector<Correspondence> points;
  for (size_t j = 0; j < samples.size(); ++j)
    for (size_t i = 0; i < samples[j].own.size(); ++i) {
      Correspondence c = softPoint(map, samples, targets[j], j, i);
      if (c.weight > kLeastTrust) points.push_back(std::move(c));
    }
  return points;
}

}  // namespace slicemorph
