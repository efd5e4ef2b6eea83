#pragma once

#include "engine/measure/label_measures.h"
#include "engine/measure/measure.h"
#include "slicemorph/io/placing.h"
#include "slicemorph/note.h"
#include "slicemorph/slicemorph.h"
#include "tools/report/report_page.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

struct FrameSeconds {
  double evaluate = 0, measure = 0, write = 0;
};

/// Figures of one grid of a frame.
struct GridFigures {
  std::string name;
  std::uint64_t activeVoxels = 0;
  std::optional<double> total, peak;  ///< of scalars: values times the voxels' volume; the largest value
};

struct FrameFigures {
  int number = 1;           ///< of the frame, as in its file's name
  std::optional<double> t;  ///< none for a blend given by weights
  Weights weights;
  std::string file;
  double voxelSize = 0, foldShare = 0;
  std::optional<ShapeMeasures> shape;         ///< none where the method makes no surface
  std::optional<FrameStrain> strain;          ///< of the method slices
  std::vector<GridFigures> grids;             ///< of VDB outputs
  std::vector<LabelMeasures> labels;          ///< of images: each label, or the part above the iso value
  std::optional<double> symmetricDifference;  ///< to the frame before, world units cubed
  FrameSeconds seconds;
};

/// One frame of the report. `inputs`: measures of the inputs, in order.
nlohmann::ordered_json describeFrame(const FrameFigures& figures, const std::vector<ShapeMeasures>& inputs);

/// Distances, world units, between the last object's landmarks and those of the first object as the map
/// carries them there.
struct LandmarkErrors {
  size_t count = 0;
  double before = 0, mean = 0, median = 0, most = 0;  ///< before: mean distance of the positions as given
};
/// `landmarks`: each a position per object, world units.
LandmarkErrors landmarkErrors(const std::vector<std::vector<Vec3d>>& landmarks, const MorphPlan& plan);

struct ReportParts {
  nlohmann::ordered_json settings;      ///< of the job, those that affect the result
  std::vector<std::string> inputNames;  ///< in order
  std::vector<ShapeMeasures> inputs;    ///< in order
  std::vector<Placing> placings;        ///< in order; what was done to the inputs
  Notes notes;
  std::vector<nlohmann::ordered_json> frames;
  double loadSeconds = 0, planSeconds = 0;
  std::optional<double> restDistance;  ///< of --method levelset, voxels
  std::optional<LandmarkErrors> landmarks, checkLandmarks;
  std::optional<double> overlap;  ///< after matching, of the method slices
  std::vector<TurnChoice> turns;  ///< how sure it is of which way round objects lie
  PageParts page;                 ///< for .html
};

/// Writes the reports by extension, .json, .csv or .html, each whole or not at all. Throws IoError.
void writeReports(const std::vector<std::string>& paths, const ReportParts& parts);

}  // namespace slicemorph
