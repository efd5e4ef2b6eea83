#include "tools/commands/slice_command.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/cut_slices.h"

namespace slicemorph {
namespace {

struct SliceSettings {
  CutJob job;
  std::string grids;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *timeGiven = nullptr, *gridsGiven = nullptr;
  double t = 0;
  int threads = 0;
  bool quiet = false;
};

void checkSettings(SliceSettings& s) {
  checkSliceOptions(s.job.slices);
  checkSampling(s.job.load, s.sampling);
  if (s.timeGiven->count()) {
    if (!(s.t >= 0 && s.t <= 1))
      throw InputError("--t " + formatNumber(s.t) + " is out of range; it must be 0 to 1");
    s.job.slices.exr.t = s.t;
  }
  if (s.gridsGiven->count()) s.job.grids = parseNames("--grids", s.grids);
  checkExtension(s.job.output, {".exr"});
  checkOutputPath(OutputName(s.job.output).path(1));
}

void runSlice(SliceSettings& s) {
  checkSettings(s);
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  TerminalEvents events(s.quiet);
  cutSlices(s.job, events);
}

}  // namespace

void addSliceCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("slice", "Oriented slices of any volume, all its grids, as EXR images");
  const auto s = std::make_shared<SliceSettings>();
  command
      ->add_option("INPUT", s->job.input,
                   "Volume: .vdb (all grids; file.vdb:grid one), .obj .ply .stl .off .glb, an image (.nii "
                   ".nii.gz .nrrd "
                   ".nhdr .mha .mhd, a DICOM folder, name.####.tif|png)")
      ->required();
  command
      ->add_option("-o,--output", s->job.output,
                   "Images: name.####.exr, one a slice from 1, or name.exr, one file of several parts")
      ->required()
      ->type_name("OUTPUT");
  addSliceOptions(*command, s->job.slices);
  s->gridsGiven =
      command->add_option("--grids", s->grids, "Only these grids (all)")->type_name("NAME[,NAME...]");
  s->timeGiven =
      command->add_option("--t", s->t, "Time of the volume in its morph, 0 to 1, for the attribute sliceT")
          ->type_name("T");
  s->sampling = addSamplingOptions(*command, s->job.load);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runSlice(*s); });
}

}  // namespace slicemorph
