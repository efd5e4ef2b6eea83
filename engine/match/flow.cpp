#include "engine/match/flow.h"

#include "engine/match/fit_field.h"
#include "engine/match/fold_guard.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

// The figures are chosen by hand; tests/engine/match/flow_test.cpp guards what they are for.

/// Most steps; correspondences that are not met by then stay unmet.
constexpr int kMaxSteps = 16;
/// The same for positions on the way, which need not be met exactly.
constexpr int kStepsOnTheWay = 4;
/// A step that brings the sites nearer by less than this share, root mean square, is the last.
constexpr double kLeastGain = 0.05;
/// A step squeezes no tetrahedron below this share of its volume.
constexpr double kLeastRatio = 0.4;
/// Of a step's fit, see fitFields.
constexpr double kStiffness = 0.3;
/// Weight of the points that stay fixed, against 1 of the limbs' points.
constexpr float kStillWeight = 0.3f;

/// Adds steps that carry the sites to the targets, and carries them.
void addSteps(Sites& sites, const std::vector<Vec3d>& target, const Lattice& lattice, int most,
              std::vector<Displacements>& steps) {
  const Displacements none{lattice, {VectorField(lattice.count(), openvdb::Vec3s(0.f))}};
  double before = std::numeric_limits<double>::max();
  for (int count = 0; count < most; ++count) {
    sites.value[0].clear();
    double farthest = 0, squares = 0;
    for (size_t i = 0; i < target.size(); ++i) {
      const Vec3d way = target[i] - sites.position[i];
      sites.value[0].push_back(way);
      farthest = std::max(farthest, way.length()), squares += way.lengthSqr();
    }
    const double away = std::sqrt(squares);
    if (farthest < 0.1 * lattice.spacing || away > (1 - kLeastGain) * before) break;
    before = away;
    // Not in fewer steps of conjugate gradients: with half of them a horse's tail and a hoof went astray.
    Displacements step = fitFields(lattice, sites, kStiffness, none);
    for (int halvings = 0; leastRatio(step) < kLeastRatio && halvings < 12; ++halvings)
      for (auto& d : step.of[0]) d *= 0.7f;
    for (Vec3d& p : sites.position) p += step.at(0, p);
    steps.push_back(std::move(step));
  }
}

/// The steps whose composition takes the correspondences' middle points to the points that `map` takes to
/// their positions on one object. `way`: of this object, see Ways.
std::vector<Displacements> stepsOf(const Displacements& map, size_t object,
                                   const std::vector<Correspondence>& points, const std::vector<Vec3d>& still,
                                   const Lattice& lattice, const std::vector<std::vector<Vec3d>>& way) {
  std::vector<std::vector<Vec3d>> targets(way.size() + 1);  // on the way; last at the object
  Sites sites;
  for (size_t i = 0; i < points.size(); ++i) {
    const Correspondence& c = points[i];
    Vec3d s = c.at[object] - map.at(object, c.at[object]);
    if (!toMiddle(map, object, c.at[object], s)) continue;
    sites.position.push_back(c.middle), sites.weight.push_back(c.weight), targets.back().push_back(s);
    for (size_t w = 0; w < way.size(); ++w) targets[w].push_back(way[w][i]);
  }
  for (const Vec3d& s : still) {
    sites.position.push_back(s), sites.weight.push_back(kStillWeight);
    for (std::vector<Vec3d>& target : targets) target.push_back(s);
  }
  sites.value.resize(1);
  std::vector<Displacements> steps;
  for (const std::vector<Vec3d>& target : targets)
    addSteps(sites, target, lattice, &target == &targets.back() ? kMaxSteps : kStepsOnTheWay, steps);
  return steps;
}

}  // namespace

Displacements flowed(const Displacements& map, const std::vector<Correspondence>& points,
                     const std::vector<Vec3d>& still, double spacing, const Lattice& lattice,
                     const Ways& ways) {
  // The result may have room for points that are outside the map's own lattice.
  openvdb::BBoxd room;
  for (const Lattice* l : {&map.lattice, &lattice}) {
    room.expand(l->origin);
    room.expand(l->position(l->size - openvdb::Coord(1)));
  }
  const Lattice coarse = Lattice::over(room, spacing);
  Displacements result{lattice, std::vector<VectorField>(map.of.size(), VectorField(lattice.count()))};
  tbb::parallel_for(size_t(0), map.of.size(), [&](size_t k) {
    const std::vector<std::vector<Vec3d>> way = ways.empty() ? std::vector<std::vector<Vec3d>>() : ways[k];
    const std::vector<Displacements> steps = stepsOf(map, k, points, still, coarse, way);
    tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int x = 0; x < lattice.size[0]; ++x) {
          const Vec3d s = lattice.position(x, y, z);
          Vec3d p = s;
          for (const Displacements& step : steps) p += step.at(0, p);
          result.of[k][lattice.index(x, y, z)] = openvdb::Vec3s(p + map.at(k, p) - s);
        }
    });
  });
  return result;
}

}  // namespace slicemorph
