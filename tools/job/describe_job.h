#pragma once

#include "tools/job/morph_settings.h"

#include <nlohmann/json.hpp>

namespace slicemorph {

/// The settings that affect a job's result: --resume compares them, and reports begin with them.
nlohmann::ordered_json describeJob(const MorphSettings& settings);

}  // namespace slicemorph
