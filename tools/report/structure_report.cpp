#include "tools/report/structure_report.h"

#include "engine/measure/measure.h"
#include "engine/volume/mesh_measures.h"
#include "io/atomic_file.h"
#include "slicemorph/io/output.h"

#include <nlohmann/json.hpp>

namespace slicemorph {
namespace {

using RowJson = nlohmann::ordered_json;

RowJson jsonOf(const StructureRow& row) {
  const auto orNull = [](const std::optional<int>& value) {
    return value ? RowJson(*value) : RowJson(nullptr);
  };
  const Vec3d& e = row.extents;
  return {{"label", row.label},
          {"name", row.name},
          {"file", row.file},
          {"volumeMl", row.volume / 1000},
          {"areaMm2", row.area},
          {"extentsMm", {e[0], e[1], e[2]}},
          {"pieces", orNull(row.pieces)},
          {"genus", orNull(row.genus)}};
}

/// JSON text; what is not UTF-8, for example in names of files, is replaced.
std::string spelled(const RowJson& json, int indent = -1) {
  return json.dump(indent, ' ', false, RowJson::error_handler_t::replace);
}

std::string lineOf(const RowJson& row) {
  std::string line;
  const auto add = [&](const RowJson& value) {
    line += (line.empty() ? "" : ",") + (value.is_null() ? std::string() : spelled(value));
  };
  for (const auto& [key, value] : row.items()) {
    if (value.is_array())
      for (const RowJson& part : value) add(part);
    else
      add(value);
  }
  return line + "\n";
}

}  // namespace

StructureRow rowOf(std::int64_t label, const std::string& name, const Mesh& mesh, const std::string& file) {
  const ShapeMeasures m = measureMesh(mesh);
  return {label, name, file, m.volume, m.area, boundsOf(mesh.points).extents(), m.pieces, m.genus};
}

StructureRow rowOf(const LabelMeasures& m, const std::string& file) {
  return {m.label, std::to_string(m.label), file, m.volume, m.area, m.extents, std::nullopt, std::nullopt};
}

void writeStructureReports(const std::vector<std::string>& paths, const std::string& input,
                           const std::vector<StructureRow>& rows, const Notes& notes) {
  RowJson structures = RowJson::array();
  for (const StructureRow& row : rows) structures.push_back(jsonOf(row));
  for (const std::string& path : paths) {
    if (OutputName(path).extension() == ".json") {
      const RowJson report = {{"input", input}, {"notes", sentencesOf(notes)}, {"structures", structures}};
      writeTextFile(path, spelled(report, 2) + "\n");
      continue;
    }
    std::string table =
        "label,name,file,volume_ml,area_mm2,extent_x_mm,extent_y_mm,extent_z_mm,pieces,genus\n";
    for (const RowJson& row : structures) table += lineOf(row);
    writeTextFile(path, table);
  }
}

}  // namespace slicemorph
