#pragma once

#include "engine/measure/label_measures.h"
#include "slicemorph/mesh.h"
#include "slicemorph/note.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// One label or structure of a report; lengths in millimetres.
struct StructureRow {
  std::int64_t label = 0;
  std::string name, file;
  double volume = 0, area = 0;
  Vec3d extents{0, 0, 0};
  std::optional<int> pieces, genus;  ///< of surfaces
};

/// The row of a closed surface.
StructureRow rowOf(std::int64_t label, const std::string& name, const Mesh& mesh, const std::string& file);
/// The row of a label of a dense map, named by its number.
StructureRow rowOf(const LabelMeasures& measures, const std::string& file);

/// Writes the reports of a reconstruction by extension, .json or .csv, each whole or not at
/// all. Throws IoError.
void writeStructureReports(const std::vector<std::string>& paths, const std::string& input,
                           const std::vector<StructureRow>& rows, const Notes& notes);

}  // namespace slicemorph
