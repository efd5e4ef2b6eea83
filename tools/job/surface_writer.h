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

/// Writes the surfaces of a reconstruction as meshes, a file each, or as level sets of one VDB.
class SurfaceWriter {
 public:
  /// `count`: of all surfaces; `list`: their names, for the message. Throws InputError where one file is to
  /// hold several meshes.
  SurfaceWriter(const ReconstructJob& job, size_t count, const std::string& list, JobEvents& events);

  void add(const Structure& structure);
  /// Ends the VDB. Returns the rows of the report; none where none is asked for.
  std::vector<StructureRow> finish();

 private:
  bool toVdb() const;

  const ReconstructJob& job_;
  JobEvents& events_;
  OutputName name_;
  openvdb::GridCPtrVec grids_;
  std::vector<StructureRow> rows_;
};

}  // namespace slicemorph
