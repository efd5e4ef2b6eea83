#include "tools/job/reconstruct_slices.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/voxelise.h"
#include "io/exr/exr_slice_reader.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/job/image_lattice.h"
#include "tools/job/option_values.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// The size of voxels: that of a pixel, or smaller if a level set needs it; if so, the notes say it.
struct VoxelChoice {
  double size = 0;
  Notes notes;
};

VoxelChoice voxelSizeFor(const ExrSlices& slices, const SlicedGrid& sliced, const ReconstructJob& job) {
  if (job.voxelSize > 0) return {job.voxelSize, {}};
  double pixel = slices.planes[0].pixelSize;
  for (const SectionPlane& plane : slices.planes) pixel = std::min(pixel, plane.pixelSize);
  const double most = mostVoxelSize(*sliced.prototype);
  if (pixel <= most * 1.001) return {pixel, {}};
  return {most,
          {{"reconstruct.finer-voxels", Severity::kNote, job.input,
            "'" + sliced.prototype->getName() + "' gets voxels of " + formatNumber(most) +
                ", finer than the pixels of " + formatNumber(pixel) + ": its distances reach no farther"}}};
}

std::string namesOf(const ExrSlices& slices) {
  std::string names;
  for (const SlicedGrid& sliced : slices.grids)
    names += (names.empty() ? "" : ", ") + sliced.prototype->getName();
  return names;
}

/// Throws InputError for several grids: meshes and images hold one.
void checkOne(const ExrSlices& slices, const ReconstructJob& job) {
  if (slices.grids.size() > 1)
    throw InputError("-o " + job.output + " holds one grid, " + job.input + " has " + namesOf(slices) +
                     "; choose one with --grids, or write a .vdb");
}

void writeGridsTo(const ReconstructJob& job, const openvdb::GridCPtrVec& grids) {
  if (isGridOutput(job.output)) return writeGridFile(job.output, grids, {});
  if (isImageOutput(job.output)) return writeImage(job.output, imageOf(*grids[0]));
  const auto scalars = openvdb::GridBase::grid<FloatGrid>(grids[0]);
  if (!scalars || scalars->getGridClass() != openvdb::GRID_LEVEL_SET)
    throw InputError("-o " + job.output + ": '" + grids[0]->getName() +
                     "' is no level set and has no surface; write a .vdb");
  writeMesh(job.output, surfaceOf(*scalars));
}

}  // namespace

void reconstructSlices(const ReconstructJob& job, JobEvents& events) {
  events.report("reading", 0);
  const ExrSlices slices =
      readSliceExrs(parseInput(job.input), job.grids.value_or(std::vector<std::string>()), job.memory);
  events.notes(about(job.input, slices.notes));
  if (!isGridOutput(job.output)) checkOne(slices, job);
  openvdb::GridCPtrVec grids;
  for (size_t g = 0; g < slices.grids.size(); ++g) {
    events.throwIfCancelled();
    events.report("reconstructing", double(g + 1) / double(slices.grids.size() + 1));
    const VoxelChoice voxel = voxelSizeFor(slices, slices.grids[g], job);
    events.notes(voxel.notes);
    try {
      grids.push_back(gridOfSections(slices.planes, slices.grids[g], voxel.size));
    } catch (const InputError& error) {
      throw InputError(job.input + ": " + error.what());
    }
  }
  writeGridsTo(job, grids);
  events.fileWritten(job.output, false);
}

}  // namespace slicemorph
