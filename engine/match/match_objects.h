#pragma once

#include "engine/frame/align.h"
#include "engine/match/chart_samples.h"
#include "engine/match/features.h"
#include "engine/numerics/lattice.h"

namespace slicemorph {

/// One surface of every object: its distance fields and its samples.
struct MatchSurface {
  Fields fields;                      ///< per object; null where it has none
  std::vector<ChartSamples> samples;  ///< per object
};

/// The objects to be matched, with what is measured once before matching.
struct MatchObjects {
  std::vector<Chart> charts;           ///< per object
  MatchSurface shape;                  ///< the objects' own surfaces: every object has one
  std::vector<MatchSurface> inner;     ///< further surfaces, which also guide the map
  std::vector<Feature> features;       ///< prescribed by the user, world coordinates
  FeaturePoints guides;                ///< the same in chart coordinates
  std::vector<openvdb::BBoxd> boxes;   ///< per object, chart space
  openvdb::BBoxd box;                  ///< of all objects
  double size = 1;                     ///< cube root of the box's volume, chart units
  double overlapSpacing = kWholeLook;  ///< of the lattice on which overlaps are measured, fraction of `size`

  /// Lattice spacings for the matching itself, and, with a third of the nodes (0.7^3), for quick trials.
  static constexpr double kWholeLook = 0.035, kQuickLook = 0.05;

  size_t count() const { return charts.size(); }
  /// Over all objects and a margin around them; `spacing`: fraction of `size`.
  Lattice lattice(double spacing) const { return Lattice::over(reach(), spacing * size); }
  /// The box of all objects with a margin for what the map moves beyond it.
  openvdb::BBoxd reach() const;
  /// Samples per object: `samples` for two objects; more objects share the same total, so that the work grows
  /// no faster than the number of objects.
  int ofEach(int samples) const;
  /// Of all objects, chart units: a lattice, a slice or a shape made of them need not be finer.
  double smallestVoxel() const;
};

/// `inner`: for each further surface one field per object, null where it has none.
/// `features`: of these objects.
MatchObjects measureObjects(const Fields& fields, const std::vector<Fields>& inner,
                            const std::vector<Chart>& charts, const std::vector<Feature>& features);

}  // namespace slicemorph
