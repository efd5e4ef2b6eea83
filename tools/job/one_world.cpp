#include "tools/job/one_world.h"

#include "io/vdb/grid_choice.h"

#include <algorithm>
#include <filesystem>
#include <optional>

namespace slicemorph {
namespace {

/// Folder and name of a file without the number at the name's end, or its run of #; none where it has neither.
std::optional<std::string> familyOf(const std::string& name) {
  const InputSpec input = parseInput(name);
  const std::filesystem::path path = std::filesystem::absolute(input.path).lexically_normal();
  std::string stem = path.stem().string();
  const size_t end = stem.find_last_not_of("0123456789#");
  const size_t kept = end == std::string::npos ? 0 : end + 1;
  if (kept == stem.size()) return std::nullopt;
  stem.resize(kept);
  return (path.parent_path() / stem).string();
}

/// Why the inputs are taken to stand in one world, as part of a sentence; none: they may be anywhere.
std::optional<std::string> whyOneWorld(const std::vector<LoadedObject>& inputs,
                                       const std::vector<std::string>& names) {
  const auto all = [&](const auto& is) { return std::all_of(inputs.begin(), inputs.end(), is); };
  if (!all([](const LoadedObject& input) { return bool(input.file); })) return std::nullopt;
  if (all([](const LoadedObject& input) { return input.fog; })) return "all are fog";
  if (all([](const LoadedObject& input) { return input.fog || isLiquidName(input.gridName); }))
    return "their grids are named as those of liquids are";
  if (!all([](const LoadedObject& input) { return !input.file->inMemory(); })) return std::nullopt;
  const std::optional<std::string> first = familyOf(names[0]);
  if (first && std::all_of(names.begin(), names.end(),
                           [&](const std::string& name) { return familyOf(name) == first; }))
    return "they are numbered files of one folder";
  return std::nullopt;
}

}  // namespace

PlanOptions optionsInOneWorld(const MorphOptions& options, const std::vector<LoadedObject>& inputs,
                              const std::vector<std::string>& names) {
  PlanOptions result{options, {}};
  const std::optional<std::string> why = whyOneWorld(inputs, names);
  if (options.align != Align::kAuto || !why) return result;
  result.options.align = Align::kDirections;
  result.notes.emplace_back("align.one-world", Severity::kNote, "",
                            "the inputs count as standing in one world, as " + *why +
                                ": they do not turn (--align auto lays them on each other, --align none also "
                                "keeps their places)");
  return result;
}

}  // namespace slicemorph
