#include "engine/blend/velocity_finder.h"

#include "engine/numerics/lattice_cell.h"
#include "engine/numerics/tetrahedra.h"

#include <algorithm>
#include <array>
#include <utility>

namespace slicemorph {

VelocityFinder::VelocityFinder(const LatticeMotion& motion, const Lattice& lattice, const LatticePose& pose,
                               const openvdb::math::Transform& transform, int step)
    : motion_(motion),
      lattice_(lattice),
      pose_(pose),
      transform_(transform),
      step_(step),
      velocity_(lattice.count()),
      computed_(lattice.count(), 0) {}

/// Sets the places of the wanted nodes, and marks them as known.
void VelocityFinder::place(NodeMap& map, const std::vector<char>& wanted) {
  map.place.assign(wanted.size(), {});
  map.known = wanted;
  std::vector<char> left = wanted;
  for (const NodeMap* from : placed_)
    forNodes(map, [&](const openvdb::Coord& c, size_t n) {
      if (!left[n] || !from->inside(c[0], c[1], c[2])) return;
      const LatticePlace& place = from->place[from->index(c[0], c[1], c[2])];
      if (place.cell != LatticePlace::kBeyond) map.place[n] = place, left[n] = 0;
    });
  if (std::find(left.begin(), left.end(), 1) == left.end()) return;
  if (!places_) places_.emplace(lattice_, pose_, transform_, step_);
  NodeMap box;
  box.step = map.step, box.origin = map.origin, box.size = map.size;
  const NodeMap found = places_->find(std::move(box), left);
  for (size_t n = 0; n < left.size(); ++n)
    if (left[n]) map.place[n] = found.place[n];
}

/// Computes the velocities of those nodes of the lattice that the places of a map rest on.
void VelocityFinder::computeAround(const NodeMap& map) {
  const std::array<std::uint32_t, 8> offset = cornerOffsets(lattice_);
  std::vector<size_t> missing;
  for (const LatticePlace& place : map.place) {
    if (place.cell == LatticePlace::kBeyond) continue;
    for (int c : kKuhnTetrahedra[place.tetrahedron]) {
      const size_t i = place.cell + offset[size_t(c)];
      if (!computed_[i]) computed_[i] = 1, missing.push_back(i);
    }
  }
  tbb::parallel_for(size_t(0), missing.size(),
                    [&](size_t m) { velocity_[missing[m]] = motion_.velocity(missing[m]); });
}

NodeMap VelocityFinder::find(NodeMap map, const std::vector<char>& wanted) {
  place(map, wanted);
  computeAround(map);
  evaluateAtPlaces(lattice_, {&velocity_}, map);
  forNodes(map, [&](const openvdb::Coord& c, size_t n) {
    if (!wanted[n] || map.place[n].cell != LatticePlace::kBeyond) return;
    const Vec3d q = pose_.chart.toChart(transform_.indexToWorld(map.step * c.asVec3d()));
    map.at[n] = openvdb::Vec3s(motion_.unit * (motion_.to.toWorld(q) - motion_.from.toWorld(q)));
  });
  return map;
}

}  // namespace slicemorph
