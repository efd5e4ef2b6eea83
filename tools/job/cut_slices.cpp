#include "tools/job/cut_slices.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/load_settings.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"

namespace slicemorph {
namespace {

/// Throws InputError for options of voxelising that would have no effect, since grids of VDB files are sliced
/// as they are.
void checkVoxels(const CutJob& job) {
  const bool voxels = job.load.voxelSize > 0 || job.load.resolution > 0;
  const bool vdb = (job.held ? job.held->spec : parseInput(job.input)).isGrids();
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

CutJob cutJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  CutJob job;
  job.input = given.input, job.output = given.output;
  if (!given.held.empty()) job.held = given.held[0];
  job.slices = checkedSlices(options), job.load = loadSettings(options);
  if (options.given("t")) job.slices.exr.t = given.sliceTime;
  if (options.given("grids")) job.grids = parseNames("--grids", given.grids);
  return job;
}

CutVolume volumeToCut(const CutJob& job, JobEvents& events) {
  if (!job.held) checkInputExists(job.input);
  checkVoxels(job);
  CutVolume volume;
  volume.input = job.held ? readInputGrids(*job.held, job.grids, job.load, job.slices.spine)
                          : readInputGrids(parseInput(job.input), job.grids, job.load, job.slices.spine);
  events.notes(about(job.input, volume.input.notes));
  Notes notes;
  volume.planes = placeSlices(job.slices, baresOf(volume.input.grids), volume.input.shape, notes);
  events.notes(about(job.input, notes));
  require(job.load.memory, job.output, needOfSlices(volume.planes, volume.input.grids.size()));
  return volume;
}

void cutSlices(const CutJob& job, JobEvents& events) {
  const CutVolume volume = volumeToCut(job, events);
  const InputGrids& input = volume.input;
  const std::vector<SectionPlane>& planes = volume.planes;
  SliceExrOptions exr = job.slices.exr;
  exr.units = input.units;
  takeTime(input.metadata, exr);
  const OutputName name(job.output);
  if (name.isSequence())
    writeSliceFiles([&](size_t n) { return name.path(int(n) + 1); }, input.grids, planes, exr, events);
  else
    writeSlicesExr(name.path(1), input.grids, planes, exr, events);
  for (int i = 1; i <= (name.isSequence() ? int(planes.size()) : 1); ++i)
    events.fileWritten(name.path(i), false);
}

}  // namespace slicemorph
