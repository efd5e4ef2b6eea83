#pragma once

#include "slicemorph/io/output.h"
#include "slicemorph/mesh.h"
#include "tools/job/reconstruct.h"
#include "tools/report/structure_report.h"

#include <string>
#include <vector>

namespace slicemorph {

/// The surface of one label or structure.
struct Structure {
  int number = 1;
  std::string name;
  Mesh mesh;
  FloatGrid::Ptr grid;  ///< level set, for .vdb outputs
};

/// Writes the surfaces of a reconstruction as meshes, one file each, or as level sets in one VDB.
class SurfaceWriter {
 public:
  /// `count`: number of surfaces; `list`: their names, for the message. Throws InputError where several
  /// meshes would go into one file.
  SurfaceWriter(const ReconstructJob& job, size_t count, const std::string& list, JobEvents& events);

  void add(const Structure& structure);
  /// Writes the VDB, if that is the output. Returns the rows of the report; none where no report is wanted.
  std::vector<StructureRow> finish();

 private:
  bool toGrids() const;

  const ReconstructJob& job_;
  JobEvents& events_;
  OutputName name_;
  openvdb::GridCPtrVec grids_;
  std::vector<StructureRow> rows_;
};

}  // namespace slicemorph
