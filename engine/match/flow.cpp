#include "engine/match/flow.h"

#include "engine/match/fit_field.h"
#include "engine/match/fold_guard.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

// The figures are chosen by hand; tests/engine/match/flow_test.cpp guards what they are for.

/// Most steps; correspondences that are not met by then stay unmet.
constexpr int kMaxSteps = 16;
/// A step squeezes no tetrahedron below this share of its volume.
constexpr double kLeastRatio = 0.4;
/// Of a step's fit, see fitFields.
constexpr double kStiffness = 0.3;
/// Weight of the points that stay fixed, against 1 of the limbs' points.
constexpr float kStillWeight = 0.3f;

/// The steps whose composition takes the correspondences' middle points to the points that `map` takes to
/// their positions on one object.
std::vector<Displacements> stepsOf(const Displacements& map, size_t object,
                                   const std::vector<Correspondence>& points, const std::vector<Vec3d>& still,
                                   const Lattice& lattice) {
  std::vector<Vec3d> target;
  Sites sites;
  for (const Correspondence& c : points) {
    Vec3d s = c.at[object] - map.at(object, c.at[object]);
    if (!toMiddle(map, object, c.at[object], s)) continue;
    sites.position.push_back(c.middle), sites.weight.push_back(c.weight), target.push_back(s);
  }
  for (const Vec3d& s : still)
    sites.position.push_back(s), sites.weight.push_back(kStillWeight), target.push_back(s);
  sites.value.resize(1);
  std::vector<Displacements> steps;
  while (steps.size() < kMaxSteps) {
    sites.value[0].clear();
    double farthest = 0;
    for (size_t i = 0; i < target.size(); ++i) {
      sites.value[0].push_back(target[i] - sites.position[i]);
      farthest = std::max(farthest, sites.value[0].back().length());
    }
    if (farthest < 0.1 * lattice.spacing) break;
    Displacements step =
        fitFields(lattice, sites, kStiffness, {lattice, {VectorField(lattice.count(), openvdb::Vec3s(0.f))}});
    for (int halvings = 0; leastRatio(step) < kLeastRatio && halvings < 12; ++halvings)
      for (auto& d : step.of[0]) d *= 0.7f;
    for (Vec3d& p : sites.position) p += step.at(0, p);
    steps.push_back(std::move(step));
  }
  return steps;
}

}  // namespace

Displacements flowed(const Displacements& map, const std::vector<Correspondence>& points,
                     const std::vector<Vec3d>& still, double spacing, const Lattice& lattice) {
  const Vec3d extent = map.lattice.spacing * (map.lattice.size.asVec3d() - Vec3d(1));
  const Lattice coarse = Lattice::over({map.lattice.origin, map.lattice.origin + extent}, spacing);
  Displacements result{lattice, std::vector<VectorField>(map.of.size(), VectorField(lattice.count()))};
  for (size_t k = 0; k < map.of.size(); ++k) {
    const std::vector<Displacements> steps = stepsOf(map, k, points, still, coarse);
    tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int x = 0; x < lattice.size[0]; ++x) {
          const Vec3d s = lattice.position(x, y, z);
          Vec3d p = s;
          for (const Displacements& step : steps) p += step.at(0, p);
          result.of[k][lattice.index(x, y, z)] = openvdb::Vec3s(p + map.at(k, p) - s);
        }
    });
  }
  return result;
}

}  // namespace slicemorph
