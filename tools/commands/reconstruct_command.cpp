#include "tools/commands/reconstruct_command.h"

#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/default_output.h"
#include "tools/job/limit_threads.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct.h"
#include "tools/job/write_structures.h"

namespace slicemorph {
namespace {

void runReconstruct(OptionSet& options) {
  const JobOptions& given = options.values();
  DefaultOutput fresh(kReconstruct, options);
  const ReconstructJob job = reconstructJob(options);
  checkStudyOutput(job.output, job.source, job.names);
  for (const std::string& report : job.reports) {
    checkExtension(report, {".json", ".csv"});
    checkOutputPath(report);
  }
  const auto limit = limitThreads(given.threads);
  job.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  events.notes(fresh.notes());
  reconstruct(job, events);
}

}  // namespace

void addReconstructCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "reconstruct", "A dense label map or closed surfaces from slices or contours, grids from EXR slices");
  const auto options = addOptions(*command, kReconstruct);
  command->callback([options] { runReconstruct(*options); });
}

}  // namespace slicemorph
