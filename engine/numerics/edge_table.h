#pragma once

#include <openvdb/Types.h>

#include <cstdint>
#include <vector>

namespace slicemorph {

/// One triangle's side of an edge.
struct HalfEdge {
  using Index = std::uint32_t;

  Index low, high;  ///< points
  Index corner;     ///< 3 t + k: from corner k of triangle t to the next one
  bool forward;     ///< the triangle runs from `low` to `high`

  Index triangle() const { return corner / 3; }
  Index from() const { return forward ? low : high; }
  Index to() const { return forward ? high : low; }
};

/// The edges of a triangle mesh, ordered by their points (low, then high), each with its half edges ordered
/// by triangle.
class EdgeTable {
 public:
  explicit EdgeTable(const std::vector<openvdb::Vec3I>& triangles);

  size_t count() const { return starts_.size() - 1; }
  /// Number of triangles at an edge.
  size_t faces(size_t edge) const { return starts_[edge + 1] - starts_[edge]; }
  const HalfEdge& half(size_t edge, size_t i) const { return halves_[starts_[edge] + i]; }
  const HalfEdge* begin(size_t edge) const { return halves_.data() + starts_[edge]; }
  const HalfEdge* end(size_t edge) const { return halves_.data() + starts_[edge + 1]; }

 private:
  std::vector<HalfEdge> halves_;
  std::vector<HalfEdge::Index> starts_;  ///< edges + 1 offsets into `halves_`
};

}  // namespace slicemorph
