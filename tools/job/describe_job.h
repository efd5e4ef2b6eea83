#pragma once

#include "tools/job/morph_settings.h"

#include <nlohmann/json.hpp>

namespace slicemorph {

/// A job's settings as they bear on the result: what --resume compares, and the head of the report.
nlohmann::ordered_json describeJob(const MorphSettings& settings);

}  // namespace slicemorph
