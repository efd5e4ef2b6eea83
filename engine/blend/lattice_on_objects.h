#pragma once

#include "engine/frame/align.h"
#include "engine/match/displacements.h"

namespace slicemorph {

/// Where the nodes of the matching's lattice lie on every object.
struct LatticeOnObjects {
  Lattice lattice;  ///< in the middle space
  std::vector<Chart> charts;
  std::vector<VectorField> chart;            ///< per object: chart coordinates of the nodes
  std::vector<Vec3d> anchor;                 ///< per object: its field's
  std::vector<VectorField> position;         ///< per object: in the world, relative to the anchor
  std::vector<std::vector<float>> distance;  ///< per object: at the nodes, chart units

  size_t objects() const { return charts.size(); }
};

/// Distance, in chart units, that nodes get beyond the line where a bent chart's slices cross: far outside.
/// Any value much larger than the objects, whose size is a few chart units.
constexpr float kNothingThere = 1e3f;

LatticeOnObjects latticeOnObjects(const Displacements& map, const Fields& fields,
                                  const std::vector<Chart>& charts);

/// The objects' positions, one field an object.
std::vector<const VectorField*> positionFields(const LatticeOnObjects& on);

}  // namespace slicemorph
