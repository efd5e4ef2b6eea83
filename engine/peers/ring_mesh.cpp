#include "engine/peers/ring_mesh.h"

#include "engine/peers/function_level_set.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <cmath>

namespace slicemorph {

std::vector<openvdb::Vec3I> RingLayout::triangles() const {
  std::vector<openvdb::Vec3I> result;
  result.reserve(2 * size_t(rings) * size_t(around));
  const auto add = [&](size_t a, size_t b, size_t c) {
    result.emplace_back(unsigned(a), unsigned(b), unsigned(c));
  };
  const size_t last = count() - 1;
  for (int i = 0; i < around; ++i) {
    const int next = (i + 1) % around;
    add(0, index(0, next), index(0, i));
    for (int ring = 0; ring + 1 < rings; ++ring) {
      add(index(ring, i), index(ring, next), index(ring + 1, i));
      add(index(ring, next), index(ring + 1, next), index(ring + 1, i));
    }
    add(last, index(rings - 1, i), index(rings - 1, next));
  }
  return result;
}

Vec3d RingLayout::direction(size_t point) const {
  if (point == 0) return {0, 0, -1};
  if (point + 1 == count()) return {0, 0, 1};
  const size_t ring = (point - 1) / size_t(around), at = (point - 1) % size_t(around);
  const double polar = openvdb::math::pi<double>() * double(ring + 1) / (rings + 1);
  const double angle = 2 * openvdb::math::pi<double>() * double(at) / around;
  return {std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), -std::cos(polar)};
}

FloatGrid::Ptr levelSetOfMesh(const Mesh& mesh, double voxelSize) {
  try {
    const FloatGrid::Ptr grid = voxelise(mesh, voxelSize);
    grid->setName("surface");
    return grid;
  } catch (const GeometryError&) {  // nothing is inside
    return emptyLevelSet(voxelSize);
  }
}

}  // namespace slicemorph
