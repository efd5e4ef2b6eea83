#include "engine/blend/lattice_pose.h"

#include "engine/numerics/tetrahedra.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// A cell whose nodes' weights differ by less is not at a border.
constexpr float kSameWeight = 1e-3f;

}  // namespace

Vec3d onPath(const LatticeOnObjects& on, size_t node, const Vec3d& middle, const Weights& path) {
  double rest = 1;  // coefficient of the position in the middle space
  for (double w : path) rest -= w;
  Vec3d q = rest * middle;
  for (size_t k = 0; k < path.size(); ++k) q += path[k] * Vec3d(on.chart[k][node]);
  return q;
}

LatticePose blendedPose(const LatticeOnObjects& on, const Weights& weights, const NodeWeights& local,
                        const VectorField& offsets) {
  const Lattice& lattice = on.lattice;
  const size_t objects = on.objects();
  LatticePose pose;
  pose.mean = weights;
  pose.at.resize(lattice.count());
  pose.distance.resize(lattice.count());
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    Weights own = weights, path = pathWeights(weights);
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const size_t i = lattice.index(x, y, z);
        if (!local.empty()) {
          own.assign(&local[i * objects], &local[i * objects] + objects);
          path = pathWeights(own);
        }
        Vec3d q = onPath(on, i, lattice.position(x, y, z), path);
        float d = 0;
        for (size_t k = 0; k < objects; ++k)
          if (own[k] != 0) d += float(own[k]) * on.distance[k][i];
        if (!offsets.empty()) q += Vec3d(offsets[i]);
        pose.at[i] = q, pose.distance[i] = d;
      }
  });
  return pose;
}

VectorField displacementOf(const Lattice& lattice, const LatticePose& pose) {
  VectorField displacement(lattice.count());
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const size_t i = lattice.index(x, y, z);
        displacement[i] = openvdb::Vec3s(pose.at[i] - lattice.position(x, y, z));
      }
  });
  return displacement;
}

std::vector<Vec3d> worldOf(const LatticePose& pose, const Chart& chart) {
  std::vector<Vec3d> world(pose.at.size());
  tbb::parallel_for(size_t(0), world.size(), [&](size_t i) { world[i] = chart.toWorld(pose.at[i]); });
  return world;
}

bool poseFolds(const LatticeOnObjects& on, const LatticePose& pose, const NodeWeights& local) {
  const Lattice& lattice = on.lattice;
  const size_t objects = on.objects();
  const auto border = [&](const size_t(&corner)[8]) {
    for (size_t k = 0; k < objects && !local.empty(); ++k)
      for (int c = 1; c < 8; ++c)
        if (std::abs(local[corner[c] * objects + k] - local[corner[0] * objects + k]) > kSameWeight)
          return true;
    return local.empty();
  };
  std::vector<char> found(lattice.size[2], 0);
  const double cell = lattice.spacing * lattice.spacing * lattice.spacing;
  tbb::parallel_for(0, int(lattice.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x) {
        Vec3d p[8];
        size_t corner[8];
        float nearest = 1e30f;
        for (int c = 0; c < 8; ++c) {
          corner[c] = lattice.corner(x, y, z, c);
          p[c] = pose.at[corner[c]], nearest = std::min(nearest, pose.distance[corner[c]]);
        }
        if (nearest > 2 * lattice.spacing || !border(corner)) continue;
        for (const auto& t : kKuhnTetrahedra) found[z] |= !(parallelepipedVolume(p, t) > kFoldedBelow * cell);
      }
  });
  return std::find(found.begin(), found.end(), 1) != found.end();
}

Vec3d poseCentroid(const Lattice& lattice, const LatticePose& pose, const std::vector<Vec3d>& world,
                   const Chart& chart) {
  std::vector<Vec3d> sums(lattice.size[2], Vec3d(0.0));
  std::vector<double> volumes(lattice.size[2], 0);
  tbb::parallel_for(0, int(lattice.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x) {
        Vec3d p[8], middle(0.0);
        float d = 0;
        for (int c = 0; c < 8; ++c) {
          const size_t i = lattice.corner(x, y, z, c);
          p[c] = world[i];
          middle += p[c] / 8.0, d += pose.distance[i] / 8;
        }
        double share = std::min(std::max(0.5 - d / lattice.spacing, 0.0), 1.0);
        if (share == 0) continue;
        double volume = 0;
        for (const auto& t : kKuhnTetrahedra) volume += parallelepipedVolume(p, t);
        if (!(volume > 0)) continue;
        sums[z] += share * volume * middle, volumes[z] += share * volume;
      }
  });
  Vec3d sum(0.0);
  double volume = 0;
  for (size_t z = 0; z < sums.size(); ++z) sum += sums[z], volume += volumes[z];
  return volume > 0 ? sum / volume : chart.center;
}

}  // namespace slicemorph
