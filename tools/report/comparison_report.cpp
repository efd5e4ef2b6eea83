#include "tools/report/comparison_report.h"

#include <cmath>

namespace slicemorph {
namespace {

using ComparisonJson = nlohmann::ordered_json;

ComparisonJson pointJson(const Vec3d& p, bool there) {
  return there ? ComparisonJson{p[0], p[1], p[2]} : ComparisonJson(nullptr);
}

std::string cell(const ComparisonJson& value) { return value.is_null() ? std::string() : value.dump(); }

/// Three cells of a point.
std::string pointCells(const ComparisonJson& point) {
  if (point.is_null()) return ",,";
  return cell(point[0]) + "," + cell(point[1]) + "," + cell(point[2]);
}

}  // namespace

nlohmann::ordered_json labelsJson(const std::vector<LabelComparison>& labels) {
  ComparisonJson rows = ComparisonJson::array();
  for (const LabelComparison& c : labels) {
    const auto distance = [&](double SurfaceDistance::*which) {
      return c.distance ? ComparisonJson((*c.distance).*which) : ComparisonJson(nullptr);
    };
    rows.push_back({{"label", c.label},
                    {"voxelsA", c.voxels[0]},
                    {"voxelsB", c.voxels[1]},
                    {"volumeMlA", c.volume[0] / 1000},
                    {"volumeMlB", c.volume[1] / 1000},
                    {"dice", c.dice},
                    {"distanceMm",
                     {{"mean", distance(&SurfaceDistance::mean)},
                      {"p95", distance(&SurfaceDistance::p95)},
                      {"max", distance(&SurfaceDistance::max)}}},
                    {"centroidA", pointJson(c.centroid[0], c.voxels[0] > 0)},
                    {"centroidB", pointJson(c.centroid[1], c.voxels[1] > 0)},
                    {"centroidDistanceMm", c.voxels[0] && c.voxels[1]
                                               ? ComparisonJson((c.centroid[1] - c.centroid[0]).length())
                                               : ComparisonJson(nullptr)}});
  }
  return rows;
}

std::string comparisonTable(const std::vector<LabelComparison>& labels, const nlohmann::ordered_json& whole) {
  if (labels.empty()) {
    const auto& distance = whole["distance"];
    return "volume_a,volume_b,area_a,area_b,dice,distance_mean,distance_p95,distance_p99,distance_max\n" +
           cell(whole["a"]["volume"]) + "," + cell(whole["b"]["volume"]) + "," + cell(whole["a"]["area"]) +
           "," + cell(whole["b"]["area"]) + "," + cell(whole["dice"]) + "," + cell(distance["mean"]) + "," +
           cell(distance["p95"]) + "," + cell(distance["p99"]) + "," + cell(distance["max"]) + "\n";
  }
  std::string table =
      "label,volume_a_ml,volume_b_ml,dice,distance_mean_mm,distance_p95_mm,distance_max_mm,centroid_a_x_mm,"
      "centroid_a_y_mm,centroid_a_z_mm,centroid_b_x_mm,centroid_b_y_mm,centroid_b_z_mm,centroid_distance_"
      "mm\n";
  for (const ComparisonJson& row : labelsJson(labels)) {
    const ComparisonJson& distance = row["distanceMm"];
    table += cell(row["label"]) + "," + cell(row["volumeMlA"]) + "," + cell(row["volumeMlB"]) + "," +
             cell(row["dice"]) + "," + cell(distance["mean"]) + "," + cell(distance["p95"]) + "," +
             cell(distance["max"]) + "," + pointCells(row["centroidA"]) + "," + pointCells(row["centroidB"]) +
             "," + cell(row["centroidDistanceMm"]) + "\n";
  }
  return table;
}

}  // namespace slicemorph
