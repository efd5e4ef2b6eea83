#pragma once

#include "io/mesh/glb_writer.h"
#include "slicemorph/slicemorph.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slicemorph {

/// What the page of a report shows in addition to its figures.
struct PageParts {
  std::string glb;                  ///< of the player, one frame per second; empty: there is nothing to play
  std::vector<size_t> frames;       ///< frames of the report, from 0, that the player has
  std::string sheet;                ///< contact sheet, a PNG; empty: none
  std::vector<std::string> slices;  ///< an SVG each
  std::string pick;                 ///< of pickPart, to point at places of the inputs; empty: none
};

/// The job that a page is about.
struct PageJob {
  std::vector<std::string> inputs;  ///< names
  size_t frames = 0;                ///< their number in the report
  GlbSpace space;                   ///< of the player's shapes
};

/// One frame's surface for the page.
struct PageFrame {
  size_t index = 0;  ///< in the report, from 0
  Weights weights;
  std::string caption;  ///< of its picture
  FloatGrid::ConstPtr surface;
  openvdb::Vec3SGrid::ConstPtr colors;  ///< of the surface; null: it has none
};

/// Collects coarse surfaces of some of a job's frames, and makes the page's shapes and pictures from them.
class PageShapes {
 public:
  explicit PageShapes(PageJob job);
  /// Whether the page shows a frame, from 0.
  bool has(size_t frame) const;
  /// Adds a frame; frames must come in order. Surfaces that are null, empty or too thin to be seen
  /// are left out.
  void add(const PageFrame& frame);
  /// `plan`: of all frames; null where there is none.
  PageParts finish(const MorphPlan* plan, Progress& progress) const;

 private:
  PageJob job_;
  std::vector<size_t> shown_;     ///< frames that the page has room for
  std::vector<PageFrame> added_;  ///< with coarse surfaces
};

/// The page: one HTML file that needs no network. `report`: all figures, as in the .json.
std::string pageOf(const nlohmann::ordered_json& report, const PageParts& parts);

}  // namespace slicemorph
