#pragma once

#include "engine/measure/label_measures.h"
#include "engine/measure/measure.h"
#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"
#include "tools/report/report_page.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slicemorph {

struct FrameSeconds {
  double evaluate = 0, measure = 0, write = 0;
};

/// Of one grid of a frame.
struct GridFigures {
  std::string name;
  std::uint64_t activeVoxels = 0;
  std::optional<double> total, peak;  ///< of scalars: values times the voxels' volume; the largest value
};

struct FrameFigures {
  double voxelSize = 0, foldShare = 0;
  std::optional<ShapeMeasures> shape;         ///< none where the method makes no surface
  std::vector<GridFigures> grids;             ///< of VDB outputs
  std::vector<LabelMeasures> labels;          ///< of images: each label, or what is above the surface's value
  std::optional<double> symmetricDifference;  ///< to the frame before, world units cubed
  FrameSeconds seconds;
};

/// The inputs' settings as they bear on the result: what --resume compares, and the head of the report.
nlohmann::ordered_json describeJob(const MorphSettings& settings);

/// One frame of the report. `inputs`: measures of the inputs, in order.
nlohmann::ordered_json describeFrame(const FrameJob& job, const FrameFigures& figures,
                                     const std::vector<ShapeMeasures>& inputs);

/// How far from where they should be landmarks of the first object arrive on the last one, world units.
struct LandmarkErrors {
  size_t count = 0;
  double before = 0, mean = 0, median = 0, most = 0;  ///< before: mean distance of the places as given
};
LandmarkErrors landmarkErrors(const std::vector<Landmark>& landmarks, const MorphPlan& plan);

struct ReportParts {
  Notes notes;
  std::vector<ShapeMeasures> inputs;
  std::vector<nlohmann::ordered_json> frames;
  double loadSeconds = 0, planSeconds = 0;
  std::optional<double> restDistance;  ///< of --method levelset, voxels
  std::optional<LandmarkErrors> landmarks, checkLandmarks;
  PageParts page;  ///< for .html
};

/// Writes the reports, each whole or not at all. Throws IoError.
void writeReports(const MorphSettings& settings, const ReportParts& parts);

}  // namespace slicemorph
