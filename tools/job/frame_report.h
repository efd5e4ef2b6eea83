#pragma once

#include "tools/job/frame_maker.h"
#include "tools/report/morph_report.h"

#include <map>
#include <vector>

namespace slicemorph {

/// What a job measures of its frames for its reports. Nothing is measured where none is asked for.
class FrameReport {
 public:
  explicit FrameReport(const MorphSettings& settings);

  bool wanted() const { return !settings_.reports.empty(); }
  /// Adds a frame that was made, frames in order; its shape, if it has one, is compared with the frame's
  /// before.
  FrameFigures measure(const FrameTask& task, const MorphFrame& frame);
  /// Its row of the report, kept; null where nothing is measured.
  nlohmann::ordered_json addRow(const FrameFigures& figures, const std::vector<LoadedObject>& inputs);
  /// Adds a frame that an earlier run made. `row`: of that run; `compared`: the next frame will be made, and
  /// compared with this one.
  void addKept(size_t index, const FrameTask& task, const nlohmann::ordered_json& row, bool compared);
  /// Shows the frame (`index`: of the job, from 0) on the page, where it has room for it.
  void addToPage(size_t index, const FrameTask& task, const MorphFrame& frame);

  /// Throws IoError.
  void write(const FrameMaker& maker, const Notes& notes, Progress& progress) const;

 private:
  ShapeMeasures measuresOf(const FloatGrid::ConstPtr& levelSet);

  const MorphSettings& settings_;
  PageShapes page_;
  std::vector<nlohmann::ordered_json> rows_;
  FloatGrid::ConstPtr previous_;                           ///< surface of the frame before
  std::map<FloatGrid::ConstPtr, ShapeMeasures> measures_;  ///< of inputs
};

}  // namespace slicemorph
