#pragma once

#include "tools/job/frame_maker.h"
#include "tools/report/morph_report.h"

#include <map>
#include <vector>

namespace slicemorph {

/// Measures a job's frames for its reports. Nothing is measured if no report is asked for.
class FrameReport {
 public:
  explicit FrameReport(const MorphSettings& settings);

  bool wanted() const { return !settings_.reports.empty(); }
  /// One of the reports is a page, for which surfaces are followed.
  bool hasPage() const;
  /// Measures a frame that was made; frames in order, since its shape is compared with that of
  /// the frame before, which was measured, too, or given to compareWith().
  FrameFigures measure(const FrameTask& task, const MorphFrame& frame);
  /// The next frame will be measured, and is to be compared with this one, which is not.
  void compareWith(const FrameTask& task);
  /// Adds the frame's row to the report and returns it; null where nothing is measured.
  nlohmann::ordered_json addRow(const FrameFigures& figures, const std::vector<LoadedObject>& inputs);
  /// Adds a frame that an earlier run made. `row`: of that run.
  void addKept(const FrameTask& task, const nlohmann::ordered_json& row);
  /// Puts the frame, whose row is the next one, on the page if it is one of those shown.
  void addToPage(const FrameTask& task, const MorphFrame& frame);

  /// `progress`: of the page, 0 to 1. Throws IoError.
  void write(const FrameMaker& maker, const Notes& notes, Progress& progress) const;

 private:
  ShapeMeasures measuresOf(const FloatGrid::ConstPtr& levelSet);

  const MorphSettings& settings_;
  PageShapes page_;
  std::vector<nlohmann::ordered_json> rows_;
  FloatGrid::ConstPtr previous_;                           ///< surface of a frame; null: there is none
  int previousNumber_ = 0;                                 ///< of that frame
  std::map<FloatGrid::ConstPtr, ShapeMeasures> measures_;  ///< cache, of inputs
};

}  // namespace slicemorph
