#pragma once

#include "slicemorph/slicemorph.h"
#include "tools/job/method_parameters.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

struct FrameJob;
struct LoadedObject;
struct MorphSettings;

/// What a method prepares once for all frames of the same inputs.
struct MethodPlan {
  /// The shape of one frame; may be called for any frame, in any order.
  std::function<InBetween(const FrameJob&)> shape;
  /// The pullback of grids and images at the weights of a frame; empty where the method carries none.
  std::function<Pullback(const Weights&)> pullback = {};
  /// Of methods that match slices; null: there are no slices to draw and no map of points.
  std::shared_ptr<MorphPlan> slices = nullptr;
  std::optional<double> restDistance = {};  ///< from the last frame to the last input, voxels; none: unknown
  Notes notes = {};
};

/// What a method plans from.
struct MethodTask {
  const MorphSettings& settings;
  const std::vector<LoadedObject>& inputs;
  int frame;                 ///< number of the first frame that the plan is for
  const MethodPlan* before;  ///< of the frame before, which had other inputs; null: this is the first
  Progress& progress;
  /// The settings', completed by what was found in the inputs; null: as they are.
  const MorphOptions* options = nullptr;
  const std::string* decisions = nullptr;  ///< of an earlier plan, see MorphPlan::decidedBefore; null: none

  /// A parameter of the settings' method: as it was given, else its default.
  double parameter(const std::string& name) const;
};

/// What a method can do. Options that need more are refused; for what is left out of inputs there are notes.
struct MethodTraits {
  bool surface = true;    ///< makes a shape: a level set, its mesh and pictures of it
  bool grids = false;     ///< carries the grids beside the shape's own, and the fog that a shape is part of
  bool colors = false;    ///< carries the colours of surfaces
  bool images = false;    ///< carries images
  bool guided = false;    ///< takes regions and paths of contours; its slices can be drawn
  bool features = false;  ///< takes features and landmarks
  bool anyTime = true;    ///< makes any blend; else only steps from the first input to the last, no sequences
  size_t mostInputs = 0;  ///< 0: any number
};

/// A method that makes in-betweens. To add one: its source in the engine, a row of the table in methods.cpp.
struct MorphMethod {
  std::string name;  ///< as --method has it
  std::string help;  ///< what it does, after its name: "blends distances point by point"
  MethodTraits can;
  MethodPlan (*plan)(const MethodTask&);
  std::vector<MethodParameter> parameters = {};
};

/// All methods, the default first.
const std::vector<MorphMethod>& morphMethods();
/// Throws InputError, listing all methods, where there is none of that name.
const MorphMethod& methodNamed(const std::string& name);

/// A method as it was asked for: `levelset{steps=500}`.
struct MethodChoice {
  std::string name;
  MethodValues given;
};

/// Throws InputError where there is no such method, or it has no such parameter, or a value is out of range.
MethodChoice methodChoice(const std::string& text);

std::vector<std::string> methodNames();
/// One sentence on all methods, for the help of --method.
std::string methodHelp();

/// What a method does, and its parameters.
std::string describeMethod(const MorphMethod& method);

/// The methods with a trait, for messages: "--method slices or dissolve".
std::string methodsThat(bool MethodTraits::*can);

}  // namespace slicemorph
