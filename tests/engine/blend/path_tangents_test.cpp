#include "engine/blend/path_tangents.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Where a node is at a time, the middle of the stretch 0 to 1 being where the lattice has it: with even acceleration.
Vec3d atTime(const Vec3d& node, double t) {
  const Vec3d speed = Vec3d(1, 2, -1) + 0.1 * node, bend(0.5, -0.3, 0.2);
  return node + speed * (t - 0.5) + bend * (t * t - 0.25);
}

/// The lattice of a stretch whose objects are at the times 0 and 1, in charts that are turned and stretched. `order`: which
/// of them is the first object.
LatticeOnObjects stretchOf(const std::array<double, 2>& times) {
  LatticeOnObjects on;
  on.lattice = Lattice{Vec3d(-1, -1, -1), 0.5, openvdb::Coord(5)};
  on.charts.resize(2);
  for (Chart& chart : on.charts) {
    chart.axes = rotationFromVector({0.3, 0.5, -0.2});
    chart.scale = Vec3d(2, 1, 0.5), chart.center = Vec3d(1, 2, 3);
  }
  on.chart.assign(2, VectorField(on.lattice.count())), on.position = on.chart;
  on.anchor = {Vec3d(0.5, 0, 0), Vec3d(0, 0.25, 0)};
  for (size_t k = 0; k < 2; ++k)
    for (int z = 0; z < 5; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x) {
          const size_t i = on.lattice.index(x, y, z);
          const Vec3d p = atTime(on.lattice.position(x, y, z), times[k]);
          on.position[k][i] = openvdb::Vec3s(p - on.anchor[k]);
          on.chart[k][i] = openvdb::Vec3s(on.charts[k].toChart(p));
        }
  return on;
}

/// The positions of all nodes at a time; what a neighbouring stretch says whatever it is asked.
PathTangents::Neighbour nodesAt(const Lattice& lattice, double time) {
  return [=](const std::vector<Vec3d>& points) {
    std::vector<Vec3d> at(points.size());
    for (int z = 0; z < 5; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x) at[lattice.index(x, y, z)] = atTime(lattice.position(x, y, z), time);
    return at;
  };
}

/// The largest distance of nodes from where they are with even acceleration; of straight paths without `tangents`.
double worstPath(const LatticeOnObjects& on, const PathTangents* tangents, bool reversed) {
  double worst = 0;
  for (double t : {0.2, 0.5, 0.9}) {
    const Weights weights = reversed ? Weights{t, 1 - t} : Weights{1 - t, t};
    VectorField offsets;
    if (tangents) tangents->add(weights, offsets);
    for (int z = 0; z < 5; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x) {
          const size_t i = on.lattice.index(x, y, z);
          Vec3d q = weights[0] * Vec3d(on.chart[0][i]) + weights[1] * Vec3d(on.chart[1][i]);
          if (!offsets.empty()) q += Vec3d(offsets[i]);
          worst =
              std::max(worst, (on.charts[0].toWorld(q) - atTime(on.lattice.position(x, y, z), t)).length());
        }
  }
  return worst;
}

/// Even acceleration is met exactly (cubics through four points of a parabola are that parabola), to the floats of the map;
/// whichever of the objects is called the first.
TEST(PathTangents, EvenAccelerationIsMet) {
  const LatticeOnObjects on = stretchOf({0, 1}), other = stretchOf({1, 0});
  const PathTangents tangents(on, {nodesAt(on.lattice, -1), nodesAt(on.lattice, 2)}),
      reversed(other, {nodesAt(on.lattice, 2), nodesAt(on.lattice, -1)});
  EXPECT_LT(worstPath(on, &tangents, false), 1e-5);
  EXPECT_LT(worstPath(other, &reversed, true), 1e-5);
  EXPECT_GT(worstPath(on, nullptr, false), 0.1);
}

/// At an end without a neighbour the path begins as the straight one, and nothing changes at the objects.
TEST(PathTangents, EndsOfASequence) {
  const LatticeOnObjects on = stretchOf({0, 1});
  const PathTangents last(on, {nodesAt(on.lattice, -1), PathTangents::Neighbour()});
  VectorField nothing;
  last.add({1, 0}, nothing), last.add({0, 1}, nothing);
  EXPECT_TRUE(nothing.empty());
  const double t = 0.999;
  VectorField offsets;
  last.add({1 - t, t}, offsets);
  for (const auto& offset : offsets) EXPECT_LT(offset.length(), 1e-5);
  EXPECT_LT(worstPath(on, &last, false), worstPath(on, nullptr, false));
}

}  // namespace
}  // namespace slicemorph
