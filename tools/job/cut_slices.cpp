#include "tools/job/cut_slices.h"

#include "io/input_grids.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"

namespace slicemorph {
namespace {

/// Throws InputError for options of voxelising that would have no effect, since grids of VDB files are sliced
/// as they are.
void checkVoxels(const CutJob& job) {
  const bool voxels = job.load.voxelSize > 0 || job.load.resolution > 0;
  const bool vdb = parseInput(job.input).isGrids();
  if (voxels && vdb && !job.load.isoGiven && !job.slices.spine)
    throw InputError(
        job.input +
        " is sliced as it is; --voxel-size and --resolution are for meshes; --pixel-size sets the pixels");
}

openvdb::GridCPtrVec baresOf(const std::vector<SliceGrid>& grids) {
  openvdb::GridCPtrVec bare;
  for (const SliceGrid& grid : grids) bare.push_back(grid.grid);
  return bare;
}

/// Takes frame number and frames per second from a file's metadata.
void takeTime(const openvdb::MetaMap& metadata, SliceExrOptions& exr) {
  if (const auto frame = metadata.getMetadata<openvdb::Int32Metadata>("frame")) exr.frame = frame->value();
  if (const auto fps = metadata.getMetadata<openvdb::FloatMetadata>("fps"); fps && fps->value() > 0)
    exr.framesPerSecond = double(fps->value());
}

}  // namespace

void cutSlices(const CutJob& job, JobEvents& events) {
  checkInputExists(job.input);
  checkVoxels(job);
  const InputGrids input = readInputGrids(parseInput(job.input), job.grids, job.load, job.slices.spine);
  events.notes(about(job.input, input.notes));
  SliceExrOptions exr = job.slices.exr;
  exr.units = input.units;
  takeTime(input.metadata, exr);
  Notes notes;
  const std::vector<SectionPlane> planes = placeSlices(job.slices, baresOf(input.grids), input.shape, notes);
  events.notes(about(job.input, notes));
  require(job.load.memory, job.output, needOfSlices(planes, input.grids.size()));
  const OutputName name(job.output);
  if (name.isSequence())
    writeSliceFiles([&](size_t n) { return name.path(int(n) + 1); }, input.grids, planes, exr, events);
  else
    writeSlicesExr(name.path(1), input.grids, planes, exr, events);
  for (int i = 1; i <= (name.isSequence() ? int(planes.size()) : 1); ++i)
    events.fileWritten(name.path(i), false);
}

}  // namespace slicemorph
