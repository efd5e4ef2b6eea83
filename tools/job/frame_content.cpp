#include "tools/job/frame_content.h"

#include "engine/volume/surface_colors.h"
#include "io/vdb/fog_reader.h"
#include "io/vdb/grid_choice.h"
#include "io/vdb/vector_parts.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"

#include <algorithm>

namespace slicemorph {
namespace {

using Inputs = std::vector<LoadedObject>;

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void refuseSurface(const MorphSettings& settings) {
  throw InputError("--grids surface: --method " + settings.method + " makes no surface");
}

FrameContent contentOfImages(const MorphSettings& settings, const Inputs& inputs) {
  const std::vector<std::string>& grids = settings.grids;
  const std::string name = inputs[0].labels ? "labels" : "image";
  const auto asked = [&](const std::string& grid) { return grids.empty() || contains(grids, grid); };
  for (const std::string& grid : grids)
    if (grid != "surface" && grid != name)
      throw InputError("--grids: there is no grid '" + grid + "'; there are surface, " + name);
  FrameContent content;
  content.surface = asked("surface") && settings.can().surface;
  if (!content.surface && !asked(name)) refuseSurface(settings);
  content.images =
      !settings.toPictures() && (settings.holdsGrids() ? asked(name) : isImageOutput(settings.output));
  content.labelFigures =
      !settings.reports.empty() &&
      std::all_of(inputs.begin(), inputs.end(), [](const LoadedObject& input) { return input.labels; });
  return content;
}

/// Takes the colours of surfaces out of the sets, since they are carried with the surface and not as grids of
/// their own. Returns the name of their grid; empty: there are none.
std::string takeColors(std::vector<GridSet>& sets, const Inputs& inputs) {
  std::string colorName;
  for (const LoadedObject& input : inputs)
    if (input.colors) colorName = "Cd";
  bool named = false;
  for (GridSet& set : sets) {
    if (!isColorName(set.name)) continue;
    for (size_t k = 0; k < inputs.size(); ++k) {
      if (!inputs[k].colors || !set.index[k] || set.index[k] != findColors(*inputs[k].file)) continue;
      set.index[k].reset();
      if (!named) colorName = set.name, named = true;
    }
  }
  return colorName;
}

/// Takes the grids that the shapes were read from out of the sets, since the shapes represent them. Returns
/// the index of the set that the first of them that is fog was in; none: no shape is fog.
std::optional<size_t> takeShapes(std::vector<GridSet>& sets, const Inputs& inputs) {
  std::optional<size_t> fogSet;
  for (size_t s = 0; s < sets.size(); ++s)
    for (size_t k = 0; k < inputs.size(); ++k)
      if (inputs[k].file && sets[s].index[k] == inputs[k].grid) {
        sets[s].index[k].reset();
        if (inputs[k].fog && !fogSet) fogSet = s;
      }
  return fogSet;
}

/// Adds the sets of other grids; where the result is fog, also the set of the shapes' fog, at the index
/// that it had.
void addSets(FrameContent& content, std::vector<GridSet> found, const MorphSettings& settings,
             const Inputs& inputs, bool fog) {
  GridSet shape = shapeSet(inputs);
  if (shape.name.empty()) shape.name = "density";
  const std::optional<size_t> fogSet = takeShapes(found, inputs);
  for (size_t s = 0; s < found.size(); ++s) {
    if (fog && fogSet == s) content.shapeSet = content.sets.size(), content.sets.push_back(shape);
    const auto& index = found[s].index;
    const bool there = std::any_of(index.begin(), index.end(), [](const auto& i) { return i.has_value(); });
    if (there && (!settings.toPictures() || isDrawn(found[s].name))) content.sets.push_back(found[s]);
  }
  if (fog && !content.shapeSet) content.shapeSet = 0, content.sets.insert(content.sets.begin(), shape);
}

/// The names by which --grids may ask for a set: its own, and of a vector field those of its components.
std::vector<std::string> setNames(const GridSet& set) {
  std::vector<std::string> names = set.parts;
  if (names.empty()) names.push_back(set.name);
  return names;
}

bool isAsked(const GridSet& set, const std::vector<std::string>& asked) {
  const std::vector<std::string> names = setNames(set);
  return contains(asked, set.name) || std::any_of(names.begin(), names.end(), [&](const std::string& name) {
           return contains(asked, name);
         });
}

/// Keeps only what --grids names.
void keepAsked(FrameContent& content, const MorphSettings& settings, bool first) {
  const std::vector<std::string>& asked = settings.grids;
  std::string known = content.surfaceName;
  if (!content.colorName.empty()) known += ", " + content.colorName;
  for (const GridSet& set : content.sets)
    for (const std::string& name : setNames(set)) known += ", " + name;
  std::vector<GridSet> kept;
  std::optional<size_t> shapeSet;
  for (size_t s = 0; s < content.sets.size(); ++s) {
    if (!isAsked(content.sets[s], asked)) continue;
    if (content.shapeSet == s) shapeSet = kept.size();
    kept.push_back(content.sets[s]);
  }
  for (const std::string& name : asked) {
    const bool there =
        std::any_of(kept.begin(), kept.end(), [&](const GridSet& set) { return isAsked(set, {name}); });
    if (first && !there && name != "surface" && name != content.surfaceName && name != content.colorName)
      throw InputError("--grids: no input has a grid '" + name + "'; there are " + known);
  }
  content.surface = contains(asked, "surface") || contains(asked, content.surfaceName);
  if (!contains(asked, content.colorName)) content.colorName.clear();
  if (content.surface && !settings.can().surface) refuseSurface(settings);
  content.sets = std::move(kept);
  content.shapeSet = shapeSet;
}

}  // namespace

FrameContent contentOf(const MorphSettings& settings, const Inputs& inputs, bool first) {
  const MethodTraits& can = settings.can();
  const auto all = [&](const auto& is) { return std::all_of(inputs.begin(), inputs.end(), is); };
  const auto any = [&](const auto& is) { return std::any_of(inputs.begin(), inputs.end(), is); };
  if (can.images && all([](const LoadedObject& input) { return bool(input.image); }))
    return contentOfImages(settings, inputs);

  FrameContent content;
  const bool fog = settings.holdsGrids() && can.grids &&
                   (!can.surface || any([](const LoadedObject& input) { return input.fog; }));
  content.surface = !fog;
  content.surfaceName = surfaceNameOf(inputs);
  if (first && !can.colors && any([](const LoadedObject& input) { return bool(input.colors); }))
    content.notes.emplace_back(
        "colors.left-out", Severity::kNote, "",
        "the inputs' colours are left out: only " + methodsThat(&MethodTraits::colors) + " carries them");
  if (!can.grids) return content;
  GridSets found = pairGrids(inputs, settings.grids.empty());
  // Colours of fog are treated as any other grid.
  if (!fog && can.colors) content.colorName = takeColors(found.sets, inputs);
  if (!settings.holdsGrids()) return content;
  if (first) content.notes.insert(content.notes.end(), found.notes.begin(), found.notes.end());
  addSets(content, std::move(found.sets), settings, inputs, fog);
  if (first && settings.velocity.add && !settings.toPictures() &&
      std::none_of(content.sets.begin(), content.sets.end(), [&](const GridSet& set) {
        return isVelocityName(set.name) || set.name == settings.velocity.name;
      }))
    content.notes.emplace_back(
        "velocity.none-to-add", Severity::kWarning, "--add-velocity",
        "no input has a velocity grid (vel, v, velocity, or their components as vel.x)");
  if (!settings.grids.empty()) keepAsked(content, settings, first);
  return content;
}

}  // namespace slicemorph
