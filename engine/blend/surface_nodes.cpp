#include "engine/blend/surface_nodes.h"

#include "engine/blend/find_nodes.h"
#include "engine/numerics/tetrahedra.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Largest stretch between neighbouring nodes' positions, beyond the ratio of the objects'
/// sizes. Chosen by hand.
constexpr double kMostStretch = 4;

/// Cells of the lattice near the surface.
struct NearCells {
  std::vector<char> near;  ///< per cell, at its first node
  size_t crossed = 0;      ///< number of cells that the surface goes through
  size_t folded = 0;       ///< number of these that fold on some object
};

/// Whether the map of a cell from the in-between to some object folds.
bool cellFolds(const LatticeOnObjects& on, const LatticePose& pose, const size_t (&corner)[8]) {
  Vec3d q[8], a[8];
  for (int c = 0; c < 8; ++c) q[c] = pose.at[corner[c]];
  bool folds = false;
  for (size_t k = 0; k < on.objects() && !folds; ++k) {
    for (int c = 0; c < 8; ++c) a[c] = Vec3d(on.chart[k][corner[c]]);
    for (const auto& t : kKuhnTetrahedra) {
      const double vq = parallelepipedVolume(q, t), va = parallelepipedVolume(a, t);
      folds |= !(vq > 0) || !(va > kFoldedBelow * vq);
    }
  }
  return folds;
}

/// The cells within `reach` (chart units) of the surface.
NearCells nearCells(const LatticeOnObjects& on, const LatticePose& pose, float reach) {
  const Lattice& lattice = on.lattice;
  NearCells cells{std::vector<char>(lattice.count(), 0)};
  std::vector<size_t> crossed(lattice.size[2], 0), folded(lattice.size[2], 0);
  tbb::parallel_for(0, int(lattice.size[2]) - 1, [&](int z) {
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int x = 0; x + 1 < lattice.size[0]; ++x) {
        float low = 1e30f, high = -1e30f;
        size_t corner[8];
        for (int c = 0; c < 8; ++c) {
          corner[c] = lattice.corner(x, y, z, c);
          low = std::min(low, pose.distance[corner[c]]), high = std::max(high, pose.distance[corner[c]]);
        }
        if (low > reach || high < -reach) continue;
        cells.near[corner[0]] = 1;
        if (low > 0 || high < 0) continue;
        ++crossed[z];
        folded[z] += cellFolds(on, pose, corner);
      }
  });
  for (int z = 0; z < lattice.size[2]; ++z) cells.crossed += crossed[z], cells.folded += folded[z];
  return cells;
}

/// Whether an outermost node of the lattice is nearer to the surface than `distance`, chart units.
bool endsWithin(const Lattice& lattice, const LatticePose& pose, float distance) {
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y) {
      const bool whole = z == 0 || y == 0 || z == lattice.size[2] - 1 || y == lattice.size[1] - 1;
      for (int x = 0; x < lattice.size[0]; x += whole ? 1 : lattice.size[0] - 1)
        if (pose.distance[lattice.index(x, y, z)] < distance) return true;
    }
  return false;
}

/// Finds the nodes beyond the lattice by extrapolating the displacements of its outermost nodes. `reach`:
/// distance to the surface up to which nodes are needed, chart units.
void continueBeyond(const LatticeOnObjects& on, const LatticePose& pose,
                    const openvdb::math::Transform& transform, float reach, NodeMap& map) {
  const Lattice& lattice = on.lattice;
  const size_t objects = on.objects();
  const VectorField displacement = displacementOf(lattice, pose);
  const openvdb::Coord end = lattice.size - openvdb::Coord(1);
  const Vec3d first = lattice.origin, last = lattice.position(end[0], end[1], end[2]);
  // The outermost cells are included: their tetrahedra end at slightly other positions than
  // the trilinear field.
  const openvdb::BBoxd inner(first + Vec3d(lattice.spacing), last - Vec3d(lattice.spacing));
  forUnknownNodes(map, pose.chart, transform, [&](const Vec3d& q, size_t n) {
    Vec3d s = q;
    if (!toMiddleContinued(lattice, displacement, q, s) || inner.isInside(s)) return;
    const Vec3d border = openvdb::math::minComponent(openvdb::math::maxComponent(s, first), last);
    // The objects lie within the lattice: points beyond a border node that is far from them
    // are further away still.
    const openvdb::Coord nearest = openvdb::Coord::round((border - first) / lattice.spacing);
    if (pose.distance[lattice.index(nearest[0], nearest[1], nearest[2])] > reach + lattice.spacing) return;
    bool crossed = false;
    for (size_t k = 0; k < objects; ++k) {
      const Vec3d a = sampleContinued(lattice, on.chart[k], border) + s - border;
      crossed |= on.charts[k].spread(a) <= 0;
      map.at[n * objects + k] = openvdb::Vec3s(on.charts[k].toWorld(a) - on.anchor[k]);
    }
    map.known[n] = !crossed;
  });
}

}  // namespace

std::vector<double> longestJumps(const LatticeOnObjects& on, const Chart& chart,
                                 const openvdb::math::Transform& transform, int step) {
  std::vector<double> jumps;
  if (chart.bend.straight()) return jumps;
  for (const Chart& c : on.charts)
    jumps.push_back(kMostStretch * step * transform.voxelSize()[0] * c.meanScale() / chart.meanScale());
  return jumps;
}

NodeMap surfaceNodes(const LatticeOnObjects& on, const LatticePose& pose,
                     const openvdb::math::Transform& transform, int step) {
  NodeMap map;
  map.step = step;
  map.objects = on.objects();
  map.jump = longestJumps(on, pose.chart, transform, step);
  // Nodes are needed throughout the band, and two more for the splines.
  const double voxel = transform.voxelSize()[0] / pose.chart.meanScale();
  const float reach = float((kHalfWidth + 2 * step * std::sqrt(3.0)) * voxel);
  NearCells cells = nearCells(on, pose, reach);
  map.foldShare = cells.crossed ? double(cells.folded) / double(cells.crossed) : 0;
  if (cells.crossed == 0) return map;
  const PosedLattice posed(on.lattice, pose, transform, step, std::move(cells.near));
  openvdb::BBoxd box = posed.box();
  // The lattice's margin is a fraction of the objects' size; with large voxels the band may reach beyond it.
  const bool ends =
      endsWithin(on.lattice, pose, float((kHalfWidth + kSteepest * step * std::sqrt(3.0)) * voxel));
  if (ends) {
    const Vec3d nodes(reach / (voxel * step));
    box = openvdb::BBoxd(box.min() - nodes, box.max() + nodes);
  }
  map.origin = openvdb::Coord::floor(box.min());
  map.size = openvdb::Coord::ceil(box.max()) - map.origin + openvdb::Coord(1);
  posed.place(map);
  evaluateAtPlaces(on.lattice, positionFields(on), map);
  if (ends) continueBeyond(on, pose, transform, reach, map);
  return map;
}

}  // namespace slicemorph
