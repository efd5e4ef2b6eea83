#include "engine/volume/seed.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>
#include <limits>
#include <vector>

namespace slicemorph {
namespace {

/// The radius: less than two voxels, and a ball has no inside for the matching.
constexpr double kSeedVoxels = 2;
/// Voxels as deep as the deepest, to this share of it, count as the deepest: bands are clamped.
constexpr double kDeep = 0.9;

openvdb::Coord placeOf(const FloatGrid& levelSet) {
  float deepest = 0;
  for (auto value = levelSet.cbeginValueOn(); value; ++value) deepest = std::min(deepest, *value);
  std::vector<openvdb::Coord> deep;
  Vec3d middle(0.0);
  for (auto value = levelSet.cbeginValueOn(); value; ++value)
    if (*value <= kDeep * deepest) deep.push_back(value.getCoord()), middle += value.getCoord().asVec3d();
  middle /= double(std::max<size_t>(deep.size(), 1));
  openvdb::Coord place(0, 0, 0);
  double least = std::numeric_limits<double>::max();
  for (const openvdb::Coord& at : deep)
    if (const double d = (at.asVec3d() - middle).lengthSqr(); d < least) least = d, place = at;
  return place;
}

}  // namespace

FloatGrid::Ptr seedIn(const FloatGrid& levelSet) {
  const double voxel = levelSet.voxelSize()[0];
  const FloatGrid::Ptr seed = FloatGrid::create(float(kHalfWidth * voxel));
  seed->insertMeta(levelSet);
  seed->setTransform(levelSet.transform().copy());
  seed->setGridClass(openvdb::GRID_LEVEL_SET);
  const openvdb::Coord place = placeOf(levelSet);
  const int reach = int(std::ceil(kSeedVoxels + kHalfWidth));
  auto accessor = seed->getAccessor();
  for (auto at = openvdb::CoordBBox(place.offsetBy(-reach), place.offsetBy(reach)).begin(); at; ++at) {
    const double distance = ((*at - place).asVec3d().length() - kSeedVoxels) * voxel;
    if (std::abs(distance) < kHalfWidth * voxel) accessor.setValue(*at, float(distance));
  }
  openvdb::tools::signedFloodFill(seed->tree());
  return seed;
}

}  // namespace slicemorph
