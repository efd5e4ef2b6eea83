#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// A dense copy of a box of grid values, so that interpolation need not search the tree. Vectors are stored
/// as three scalar channels. `Real`: float or double.
template <typename Real>
class LocalBlock {
 public:
  /// Copies all voxels that interpolation at points within `points` (index space) reads.
  template <typename GridType>
  void fill(const typename GridType::ConstAccessor& accessor, const openvdb::BBoxd& points);

  /// Whether any voxel of the box is active.
  bool anyActive() const { return any_; }
  /// Whether all voxels are active and have the same value. Only tiles are recognised, not leaves.
  bool uniform() const { return uniform_; }
  /// Whether any of the eight voxels around a point is active.
  bool active(const Vec3d& at) const;
  /// Trilinear value.
  Real linear(const Vec3d& at, int channel) const;
  /// Trilinear mean of only the active voxels among the eight around a point, for three channels. Returns the
  /// sum of their trilinear weights, 0 to 1.
  Real linearAmongActive(const Vec3d& at, Real value[3]) const;
  /// Catmull-Rom spline [CR74] through the 4 x 4 x 4 voxels around, clamped to the range of their values:
  /// sharper than trilinear, without overshoot.
  Real cubic(const Vec3d& at, int channel) const;

 private:
  struct Corner {
    size_t index;      ///< of the voxel at the floor of the point
    Real fraction[3];  ///< of the point's offset from that voxel, 0 to 1 per axis
  };
  Corner cornerOf(const Vec3d& at) const;
  size_t index(const openvdb::Coord& c) const {
    return (size_t(c[0] - low_[0]) * size_t(size_[1]) + size_t(c[1] - low_[1])) * size_t(size_[2]) +
           size_t(c[2] - low_[2]);
  }
  void reset(const openvdb::BBoxd& points, int channels);
  template <typename Value>
  void put(size_t i, const Value& value, bool on);
  template <typename Value>
  bool isFirst(const Value& value) const;

  openvdb::Coord low_, size_;
  size_t count_ = 0;
  std::vector<Real> values_;  ///< per channel and voxel, z fastest
  std::vector<char> active_;
  bool any_ = false, uniform_ = false;
};

template <typename Real>
template <typename Value>
void LocalBlock<Real>::put(size_t i, const Value& value, bool on) {
  if constexpr (openvdb::VecTraits<Value>::IsVec) {
    for (int channel = 0; channel < 3; ++channel)
      values_[size_t(channel) * count_ + i] = Real(value[channel]);
  } else {
    values_[i] = Real(value);
  }
  active_[i] = on;
}

template <typename Real>
template <typename Value>
bool LocalBlock<Real>::isFirst(const Value& value) const {
  if constexpr (openvdb::VecTraits<Value>::IsVec)
    return values_[0] == Real(value[0]) && values_[count_] == Real(value[1]) &&
           values_[2 * count_] == Real(value[2]);
  else
    return values_[0] == Real(value);
}

template <typename Real>
template <typename GridType>
void LocalBlock<Real>::fill(const typename GridType::ConstAccessor& accessor, const openvdb::BBoxd& points) {
  using Leaf = typename GridType::TreeType::LeafNodeType;
  using Value = typename GridType::ValueType;
  constexpr int kSide = int(Leaf::DIM);
  reset(points, openvdb::VecTraits<Value>::Size);
  const openvdb::Coord high = low_ + size_ - openvdb::Coord(1), first = low_ & ~(kSide - 1);
  openvdb::Coord block, c;
  for (block[0] = first[0]; block[0] <= high[0]; block[0] += kSide)
    for (block[1] = first[1]; block[1] <= high[1]; block[1] += kSide)
      for (block[2] = first[2]; block[2] <= high[2]; block[2] += kSide) {
        const openvdb::Coord from = openvdb::Coord::maxComponent(block, low_);
        const openvdb::Coord to = openvdb::Coord::minComponent(block.offsetBy(kSide - 1), high);
        const size_t row = size_t(to[2] - from[2] + 1);
        const Leaf* leaf = accessor.probeConstLeaf(block);
        Value tile{};
        const bool tileOn = !leaf && accessor.probeValue(block, tile);
        const Value* values = leaf ? leaf->buffer().data() : nullptr;
        for (c[0] = from[0]; c[0] <= to[0]; ++c[0])
          for (c[1] = from[1]; c[1] <= to[1]; ++c[1]) {
            c[2] = from[2];
            const size_t i = index(c);
            const openvdb::Index n = Leaf::coordToOffset(c);
            if (leaf) {
              for (openvdb::Index z = 0; z < row; ++z) put(i + z, values[n + z], leaf->isValueOn(n + z));
            } else {
              for (size_t z = 0; z < row; ++z) put(i + z, tile, tileOn);
            }
          }
        any_ |= leaf ? !leaf->isEmpty() : tileOn;
        uniform_ = uniform_ && !leaf && tileOn && isFirst(tile);
      }
}

extern template class LocalBlock<float>;
extern template class LocalBlock<double>;

}  // namespace slicemorph
