#pragma once

#include "tools/job/morph_settings.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slicemorph {

/// What the page of a report shows beside its figures.
struct PageParts {
  std::string glb;                  ///< of the player, a frame a second; empty: there is nothing to play
  std::vector<size_t> frames;       ///< of the job, from 0, that the player has
  std::string sheet;                ///< a PNG; empty: none
  std::vector<std::string> slices;  ///< an SVG each
};

/// Collects a job's surfaces, coarse and of some frames only, and makes the page's shapes and pictures of
/// them.
class PageShapes {
 public:
  explicit PageShapes(const MorphSettings& settings);
  /// Whether the page shows a frame, from 0.
  bool has(size_t frame) const;
  /// `colors`: of the surface; null: it has none.
  void add(size_t frame, const FloatGrid& surface, const openvdb::Vec3SGrid* colors);
  /// `plan`: null where one does not serve all frames, or there is none.
  PageParts finish(const MorphPlan* plan, Progress& progress);

 private:
  const MorphSettings& settings_;
  std::vector<size_t> frames_;  ///< that are shown
  std::vector<size_t> added_;
  std::vector<FloatGrid::Ptr> surfaces_;
  std::vector<openvdb::Vec3SGrid::ConstPtr> colors_;  ///< per surface
};

/// The page: one file that opens from the disk, without a network. `report`: all figures, as in the .json.
std::string pageOf(const nlohmann::ordered_json& report, const PageParts& parts);

}  // namespace slicemorph
