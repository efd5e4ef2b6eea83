#include "tools/job/surface_writer.h"

#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"

namespace slicemorph {

SurfaceWriter::SurfaceWriter(const ReconstructJob& job, size_t count, const std::string& list,
                             JobEvents& events)
    : job_(job), events_(events), name_(job.output) {
  if (toGrids() || count < 2 || name_.isSequence()) return;
  throw InputError(
      "-o " + job.output + " is one file for " + std::to_string(count) +
      " surfaces; put #### where their number belongs (name.####.stl), write a .vdb, or choose one: " + list);
}

bool SurfaceWriter::toGrids() const { return isGridOutput(job_.output); }

void SurfaceWriter::add(const Structure& structure) {
  if (job_.takeSurface) return job_.takeSurface(structure.name, structure.mesh);
  const std::string path = toGrids() ? job_.output : name_.path(structure.number);
  if (toGrids()) {
    structure.grid->setName(structure.name);
    grids_.push_back(structure.grid);
  } else {
    writeMesh(path, structure.mesh, job_.space);
    events_.fileWritten(path, false);
  }
  if (!job_.reports.empty()) rows_.push_back(rowOf(structure.number, structure.name, structure.mesh, path));
}

std::vector<StructureRow> SurfaceWriter::finish() {
  if (!grids_.empty()) {
    writeGridFile(job_.output, grids_, {});
    events_.fileWritten(job_.output, false);
  }
  return rows_;
}

}  // namespace slicemorph
