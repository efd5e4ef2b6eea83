#include "tools/commands/slice_command.h"

#include "slicemorph/io/output.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/cut_slices.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"

namespace slicemorph {
namespace {

CutJob cutJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  CutJob job;
  job.input = given.input, job.output = given.output;
  job.slices = checkedSlices(options), job.load = loadSettings(options);
  if (options.given("t")) job.slices.exr.t = given.sliceTime;
  if (options.given("grids")) job.grids = parseNames("--grids", given.grids);
  checkExtension(job.output, {".exr"});
  checkOutputPath(OutputName(job.output).path(1));
  return job;
}

void runSlice(const OptionSet& options) {
  const JobOptions& given = options.values();
  const CutJob job = cutJob(options);
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
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
