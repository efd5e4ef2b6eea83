#include "tools/commands/slice_command.h"

#include "io/input_grids.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_progress.h"
#include "tools/job/slice_options.h"

#include <cstdio>

namespace slicemorph {
namespace {

struct SliceSettings {
  std::string input, output, grids;
  SliceOptions slices;
  LoadOptions load;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *timeGiven = nullptr, *gridsGiven = nullptr;
  double t = 0;
  int threads = 0;
  bool quiet = false;
};

void checkSettings(SliceSettings& s) {
  checkSliceOptions(s.slices);
  checkSampling(s.load, s.sampling);
  if (s.timeGiven->count()) {
    if (!(s.t >= 0 && s.t <= 1))
      throw InputError("--t " + formatNumber(s.t) + " is out of range; it must be 0 to 1");
    s.slices.exr.t = s.t;
  }
  checkExtension(s.output, {".exr"});
  checkOutputPath(OutputName(s.output).path(1));
}

/// Grids of VDB files are sliced as they are: what says how to voxelise would do nothing.
void checkVoxels(const SliceSettings& s) {
  const bool voxels = s.sampling.voxelSize->count() || s.sampling.resolution->count();
  const bool vdb = parseInput(s.input).isGrids();
  if (voxels && vdb && !s.load.isoGiven && !s.slices.spine)
    throw InputError(
        s.input +
        " is sliced as it is; --voxel-size and --resolution are for meshes; --pixel-size sets the pixels");
}

openvdb::GridCPtrVec baresOf(const std::vector<SliceGrid>& grids) {
  openvdb::GridCPtrVec bare;
  for (const SliceGrid& grid : grids) bare.push_back(grid.grid);
  return bare;
}

/// What the file of a frame says of its time.
void takeTime(const openvdb::MetaMap& metadata, SliceExrOptions& exr) {
  if (const auto frame = metadata.getMetadata<openvdb::Int32Metadata>("frame")) exr.frame = frame->value();
  if (const auto fps = metadata.getMetadata<openvdb::FloatMetadata>("fps"); fps && fps->value() > 0)
    exr.framesPerSecond = double(fps->value());
}

void writeFiles(const OutputName& name, const std::vector<SliceGrid>& grids,
                const std::vector<SectionPlane>& planes, const SliceSettings& s) {
  TerminalProgress progress(s.quiet);
  if (!name.isSequence()) return writeSlicesExr(name.path(1), grids, planes, s.slices.exr, progress);
  writeSliceFiles([&](size_t n) { return name.path(int(n) + 1); }, grids, planes, s.slices.exr, progress);
}

void runSlice(SliceSettings& s) {
  checkSettings(s);
  const std::vector<std::string> wanted =
      s.gridsGiven->count() ? parseNames("--grids", s.grids) : std::vector<std::string>();
  checkInputExists(s.input);
  checkVoxels(s);
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  cancelOnInterrupt();

  const InputGrids input = readInputGrids(parseInput(s.input), wanted, s.load, s.slices.spine);
  printNotes(s.input + ": ", input.notes, s.quiet);
  s.slices.exr.units = input.units;
  takeTime(input.metadata, s.slices.exr);
  Notes notes;
  const std::vector<SectionPlane> planes = placeSlices(s.slices, baresOf(input.grids), input.shape, notes);
  printNotes(s.input + ": ", notes, s.quiet);
  const OutputName name(s.output);
  writeFiles(name, input.grids, planes, s);
  if (s.quiet) return;
  for (int i = 1; i <= (name.isSequence() ? int(planes.size()) : 1); ++i)
    std::printf("%s\n", name.path(i).c_str());
}

}  // namespace

void addSliceCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("slice", "Oriented slices of any volume, all its grids, as EXR images");
  const auto s = std::make_shared<SliceSettings>();
  command
      ->add_option("INPUT", s->input,
                   "Volume: .vdb (all grids; file.vdb:grid one), .obj .ply .stl .off .glb, an image (.nii "
                   ".nii.gz .nrrd "
                   ".nhdr .mha .mhd, a DICOM folder, name.####.tif|png)")
      ->required();
  command
      ->add_option("-o,--output", s->output,
                   "Images: name.####.exr, one a slice from 1, or name.exr, one file of several parts")
      ->required()
      ->type_name("OUTPUT");
  addSliceOptions(*command, s->slices);
  s->gridsGiven =
      command->add_option("--grids", s->grids, "Only these grids (all)")->type_name("NAME[,NAME...]");
  s->timeGiven =
      command->add_option("--t", s->t, "Time of the volume in its morph, 0 to 1, for the attribute sliceT")
          ->type_name("T");
  s->sampling = addSamplingOptions(*command, s->load);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runSlice(*s); });
}

}  // namespace slicemorph
