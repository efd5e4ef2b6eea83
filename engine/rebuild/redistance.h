#pragma once

#include "engine/volume/leaf.h"
#include "slicemorph/conventions.h"

#include <limits>
#include <unordered_map>

namespace slicemorph {

/// Values of a function on the leaves of a narrow band and a little around it, with its zero set the surface.
class SparseValues {
 public:
  static constexpr float kUnknown = std::numeric_limits<float>::max();

  /// `origins`: of the leaves (multiples of 8), in the order in which they are to be built.
  SparseValues(std::vector<openvdb::Coord> origins, float voxelSize);

  float* leaf(size_t i) { return &values_[i * size_t(kLeafSize)]; }
  const float* leaf(size_t i) const { return &values_[i * size_t(kLeafSize)]; }
  const std::vector<openvdb::Coord>& origins() const { return origins_; }
  float voxelSize() const { return voxelSize_; }
  /// The leaf that starts at `origin`; null where there is none.
  const float* find(const openvdb::Coord& origin) const;

 private:
  std::vector<openvdb::Coord> origins_;
  float voxelSize_;
  std::vector<float> values_;
  std::unordered_map<openvdb::Coord, size_t> index_;
};

/// Makes a level set of a function that is about a distance near its zero set, up to a factor that may change
/// from position to position: two Newton steps along the gradient to the zero set. Signs, and so the topology, are
/// kept.
FloatGrid::Ptr redistance(const SparseValues& values, const openvdb::math::Transform& transform);

}  // namespace slicemorph
