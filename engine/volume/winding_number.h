#pragma once

#include "slicemorph/mesh.h"

#include <cstdint>
#include <optional>

namespace slicemorph {

/// The generalized winding number of any set of triangles [JKS13]: how often they wrap around a point. 1 inside a
/// closed surface that is wound outwards and 0 outside; it falls smoothly across holes, adds up over shells, and is -1
/// inside what is wound inwards. Evaluated as in [BDSLJ18]: near triangles by their solid angles [VS83], far ones as
/// groups by a series of second order. Same bytes for any number of threads. Holds 100 bytes for about 4 triangles.
class WindingNumber {
 public:
  /// Of the listed triangles of a mesh, which must outlive this.
  WindingNumber(const Mesh& mesh, std::vector<std::uint32_t> triangles);
  explicit WindingNumber(const Mesh& mesh);

  /// At a world point: within .01 of the sum over all triangles.
  double at(const Vec3d& point) const;

  /// The first triangle that a ray from `origin` hits; none if it gets away.
  std::optional<std::uint32_t> firstHit(const Vec3d& origin, const Vec3d& direction) const;

 private:
  /// A group of triangles: the moments of their area vectors about a centre, in world units.
  struct Group {
    float centre[3], squaredRadius;
    float area[3];     ///< sum of the area vectors
    float first[6];    ///< symmetric part of the first moments: xx, yy, zz, xy, yz, zx
    float second[10];  ///< of the second moments: xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz
  };
  struct Draft;

  size_t firstOf(size_t leaf) const { return order_.size() * leaf / leaves_; }
  void sortIntoLeaves();
  void gatherGroups();
  Draft draftOfLeaf(size_t leaf) const;
  static Draft joined(const Draft& a, const Draft& b);
  static Group rounded(const Draft& draft);
  double farAngle(const Group& group, const Vec3d& toCentre) const;
  double nearAngle(size_t leaf, const Vec3d& point) const;

  const Mesh& mesh_;
  std::vector<std::uint32_t> order_;  ///< the triangles, leaf after leaf
  size_t leaves_ = 1;                 ///< a power of two
  std::vector<Group>
      groups_;  ///< a binary heap from 1 on: the children of i are 2 i and 2 i + 1; the last are the leaves
};

}  // namespace slicemorph
