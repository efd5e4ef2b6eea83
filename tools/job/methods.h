#pragma once

#include "slicemorph/slicemorph.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

struct FrameJob;
struct LoadedObject;
struct MorphSettings;

/// What a method has decided once for all frames of the same inputs.
struct MethodPlan {
  /// The shape of one frame; may be called for any frame, in any order.
  std::function<InBetween(const FrameJob&)> shape;
  /// For what rides along, by the weights of a frame; empty where the method carries nothing.
  std::function<Pullback(const Weights&)> pullback = {};
  /// Of methods that match slices; null: there are none to draw, and no map of points.
  std::shared_ptr<const MorphPlan> slices = nullptr;
  std::optional<double> restDistance = {};  ///< of the last step to the last input, voxels; none: not known
  Notes notes = {};
};

/// What a method plans from.
struct MethodTask {
  const MorphSettings& settings;
  const std::vector<LoadedObject>& inputs;
  int frame;                 ///< number of the first frame that the plan is for
  const MethodPlan* before;  ///< of the frame before, whose inputs were others; null: this is the first
  Progress& progress;
};

/// What a method can do. Options that need more are refused, inputs that have more are told of.
struct MethodTraits {
  bool surface = true;  ///< makes a shape: a level set, its mesh and pictures of it
  bool grids = false;   ///< carries the grids beside the shape's own, and the fog that a shape is part of
  bool colors = false;  ///< carries the colours of surfaces
  bool images = false;  ///< carries images
  bool guided = false;  ///< takes features, regions, landmarks and paths of contours; its slices can be drawn
  bool anyTime = true;  ///< makes any blend; else only steps from the first input to the last, inputs still
  size_t mostInputs = 0;  ///< 0: as many as there are
};

/// One way to make in-betweens. To add one: its source in the engine, a row of the table in methods.cpp.
struct MorphMethod {
  std::string name;  ///< as --method has it
  std::string help;  ///< what it does, after its name: "blends distances point by point"
  MethodTraits can;
  MethodPlan (*plan)(const MethodTask&);
};

/// All there are, the default one first.
const std::vector<MorphMethod>& morphMethods();
/// Throws InputError naming those that there are.
const MorphMethod& methodNamed(const std::string& name);

std::vector<std::string> methodNames();
/// One sentence on all of them, for the help of --method.
std::string methodHelp();

/// Those with a trait, for messages: "--method slices or dissolve".
std::string methodsThat(bool MethodTraits::*can);

}  // namespace slicemorph
