#pragma once

#include "engine/volume/leaf.h"
#include "slicemorph/conventions.h"

#include <limits>
#include <unordered_map>

namespace slicemorph {

/// Values of a function on the leaves of a narrow band and a margin around it. Its zero set is the surface.
class SparseValues {
 public:
  static constexpr float kUnknown = std::numeric_limits<float>::max();

  /// `origins`: of the leaves (multiples of 8 voxels). All values start as kUnknown.
  SparseValues(std::vector<openvdb::Coord> origins, float voxelSize);

  float* leaf(size_t i) { return &values_[i * size_t(kLeafSize)]; }
  const float* leaf(size_t i) const { return &values_[i * size_t(kLeafSize)]; }
  const std::vector<openvdb::Coord>& origins() const { return origins_; }
  float voxelSize() const { return voxelSize_; }
  /// The leaf with this origin; null if there is none.
  const float* find(const openvdb::Coord& origin) const;

 private:
  std::vector<openvdb::Coord> origins_;
  float voxelSize_;
  std::vector<float> values_;
  std::unordered_map<openvdb::Coord, size_t> index_;
};

/// Level set of a function that, near its zero set, is a signed distance up to a factor that varies slowly in
/// space: two Newton steps along the gradient to the zero set. Signs are kept, and so is the topology.
FloatGrid::Ptr redistance(const SparseValues& values, const openvdb::math::Transform& transform);

}  // namespace slicemorph
