#pragma once

#include "engine/measure/label_comparison.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slicemorph {

/// Labels of a comparison as JSON: millilitres, millimetres (LPS); null: the label is in one map alone.
nlohmann::ordered_json labelsJson(const std::vector<LabelComparison>& labels);

/// The same as a table, a line a label. Without labels it has one line, of the whole shapes, where `whole` is their JSON
/// as `compare --json` prints it.
std::string comparisonTable(const std::vector<LabelComparison>& labels, const nlohmann::ordered_json& whole);

}  // namespace slicemorph
