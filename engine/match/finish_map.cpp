#include "engine/match/finish_map.h"

#include "engine/match/fold_guard.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Cells of the finished lattice along the objects' longest side; fewer where the objects have fewer voxels. Chosen by
/// hand.
constexpr double kCells = 72;
/// Least volume ratio of a tetrahedron, see removeFolds. Below its default of 0.12, as a finer lattice bends
/// more sharply; above the kFoldedBelow of frames.
constexpr double kFinishedFloor = 0.1;
/// Displacements are multiples of a length of at most the smallest voxel over this: far below what a frame shows, and
/// a plan file stays small.
constexpr double kStepsPerVoxel = 1024;

/// Every displacement rounded to a multiple of the power of two that is at most `most`.
void roundDisplacements(Displacements& map, double most) {
  const float step = std::exp2(float(std::floor(std::log2(most))));
  for (VectorField& field : map.of)
    for (openvdb::Vec3s& d : field)
      for (int c = 0; c < 3; ++c) d[c] = std::nearbyint(d[c] / step) * step + 0.f;  // no negative zeros
}

}  // namespace

Displacements finishedMap(const MatchObjects& objects, const Displacements& map) {
  const Vec3d extents = objects.box.extents();
  const double longest = std::max({extents[0], extents[1], extents[2]});
  const double own = std::min(objects.smallestVoxel(), map.lattice.spacing);
  Displacements fine = resampled(map, Lattice::over(objects.reach(), std::max(longest / kCells, own)));
  removeFolds(fine, kFinishedFloor);
  roundDisplacements(fine, objects.smallestVoxel() / kStepsPerVoxel);
  return fine;
}

Displacements continuedOver(const MatchObjects& objects, const Displacements& before) {
  const Lattice& old = before.lattice;
  const openvdb::BBoxd reach = objects.reach();
  const openvdb::Coord low = openvdb::Coord::floor((reach.min() - old.origin) / old.spacing);
  const openvdb::Coord high = openvdb::Coord::ceil((reach.max() - old.origin) / old.spacing);
  const Lattice lattice{old.position(low[0], low[1], low[2]), old.spacing, high - low + openvdb::Coord(1)};
  Displacements result{lattice, std::vector<VectorField>(objects.count(), VectorField(lattice.count()))};
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        openvdb::Coord from = low + openvdb::Coord(x, y, z);
        from.maxComponent(openvdb::Coord(0));
        from.minComponent(old.size - openvdb::Coord(1));
        for (size_t k = 0; k < objects.count(); ++k)
          result.of[k][lattice.index(x, y, z)] = before.of[k][old.index(from[0], from[1], from[2])];
      }
  return result;
}

}  // namespace slicemorph
