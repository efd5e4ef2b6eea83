#pragma once

#include "engine/frame/align.h"
#include "engine/match/chart_samples.h"
#include "engine/match/features.h"
#include "engine/numerics/lattice.h"

namespace slicemorph {

/// One surface of every object as the matching sees it.
struct MatchSurface {
  Fields fields;                      ///< per object; null where it has none
  std::vector<ChartSamples> samples;  ///< per object
};

/// What is measured once of objects that are to be matched. Chart space is that of their frames.
struct MatchObjects {
  std::vector<Chart> charts;           ///< per object
  MatchSurface shape;                  ///< the objects' own surfaces: every object has one
  std::vector<MatchSurface> inner;     ///< further surfaces, that steer the map
  std::vector<Feature> features;       ///< what the user prescribed, world
  FeaturePoints guides;                ///< the same in chart coordinates
  std::vector<openvdb::BBoxd> boxes;   ///< per object, chart space
  openvdb::BBoxd box;                  ///< of all objects
  double size = 1;                     ///< cube root of the box's volume, chart units
  double overlapSpacing = kWholeLook;  ///< of the lattice on which overlaps are measured, in sizes

  /// For what decides, and with a third of the nodes for trials.
  static constexpr double kWholeLook = 0.035, kQuickLook = 0.05;

  size_t count() const { return charts.size(); }
  /// Over all objects and a margin around them; `spacing`: in sizes.
  Lattice lattice(double spacing) const { return Lattice::over(reach(), spacing * size); }
  /// The box of all objects with room around it for what moves.
  openvdb::BBoxd reach() const;
  /// Samples are counted for two objects; more share them, so that the work grows no faster than their
  /// number.
  int ofEach(int samples) const;
};

/// `inner`: each per object, null where one has none. `features`: of these objects.
MatchObjects measureObjects(const Fields& fields, const std::vector<Fields>& inner,
                            const std::vector<Chart>& charts, const std::vector<Feature>& features);

}  // namespace slicemorph
