#include "tools/commands/slice_command.h"

#include "slicemorph/io/output.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/cut_slices.h"
#include "tools/job/default_output.h"
#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"

namespace slicemorph {
namespace {

void runSlice(OptionSet& options) {
  const JobOptions& given = options.values();
  DefaultOutput fresh(kSlice, options);
  const CutJob job = cutJob(options);
  checkExtension(job.output, {".exr"});
  checkOutputPath(OutputName(job.output).path(1));
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  events.notes(fresh.notes());
  cutSlices(job, events);
}

}  // namespace

void addSliceCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("slice", "Oriented slices of any volume, all its grids, as EXR images");
  const auto options = addOptions(*command, kSlice);
  command->callback([options] { runSlice(*options); });
}

}  // namespace slicemorph
