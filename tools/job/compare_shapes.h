#pragma once

#include "engine/measure/label_comparison.h"
#include "slicemorph/measure.h"
#include "tools/job/job_events.h"
#include "tools/job/job_options.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph compare` is to do; values are checked.
struct CompareJob {
  std::string inputs[2];
  HeldInputs held;  ///< those of the inputs that are in memory
  LoadOptions load;
};

struct Comparison {
  std::string inputs[2];
  ShapeMeasures shapes[2];
  double voxelSizes[2] = {0, 0};
  SurfaceDistance distance;
  Overlap overlap;
  std::vector<LabelComparison> labels;  ///< of two label maps
};

/// Throws IoError, InputError, GeometryError, MemoryError.
Comparison compareShapes(const CompareJob& job, JobEvents& events);

/// As `compare --json` prints it.
nlohmann::ordered_json jsonOf(const Comparison& comparison);

}  // namespace slicemorph
