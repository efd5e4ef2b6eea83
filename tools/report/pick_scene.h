#pragma once

#include "slicemorph/mesh.h"
#include "slicemorph/slicemorph.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// A branch of a shape as it is drawn.
struct PickLimb {
  std::vector<Vec3d> line;  ///< world, from the body to the tip
  int group = -1;           ///< limbs of one group meet; -1: it meets none of each other shape
};

/// One of the shapes at which a user points.
struct PickShape {
  std::string name;  ///< of its input, as typed
  Mesh mesh;         ///< coarse; with the input's own colours, if it has some
  /// Per other shape, in order: where the map takes the mesh's points, relative to that shape's origin; empty: there is
  /// no map.
  std::vector<std::vector<openvdb::Vec3s>> meets = {};
  std::vector<PickLimb> limbs = {};
};

/// Shapes side by side, and how they were matched.
struct PickScene {
  std::vector<PickShape> shapes;
  Vec3d up{0, 1, 0};              ///< world direction that is up on the screen
  std::optional<double> overlap;  ///< after matching; none: they were not matched
  std::vector<TurnChoice> turns;  ///< of each shape but the first; empty: they did not turn
};

struct PickSceneJob {
  std::vector<std::string> names;                         ///< of the inputs, as typed
  std::vector<FloatGrid::ConstPtr> levelSets;             ///< theirs
  std::vector<openvdb::Vec3SGrid::ConstPtr> colors = {};  ///< per input, null or beyond the end: it has none
  const MorphPlan* plan = nullptr;                        ///< of them; null: they are shown without a match
  Vec3d up{0, 0, 0};  ///< the inputs' upright direction; zero: Z, as of images
};

/// Meshes of the inputs, small enough for a page, where the plan's map takes their points, and their limbs. Throws Cancelled.
PickScene pickScene(const PickSceneJob& job, const Progress& cancel);

}  // namespace slicemorph
