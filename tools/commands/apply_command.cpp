#include "tools/commands/apply_command.h"

#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/apply_map.h"
#include "tools/job/default_output.h"
#include "tools/job/limit_threads.h"
#include "tools/job/plan_file.h"

namespace slicemorph {
namespace {

void runApply(OptionSet& options) {
  const JobOptions& given = options.values();
  printNotes("", applyPlanFile(options, given.field ? 0 : 1), given.quiet, given.verbose);
  DefaultOutput fresh(kApply, options);
  const ApplyJob job = applyJob(options);
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  events.notes(fresh.notes());
  applyMap(job, events);
}

}  // namespace

void addApplyCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "apply",
      "Carry points, meshes, curves or an image along a morph, or write its map as a displacement field");
  const auto options = addOptions(*command, kApply);
  command->callback([options] { runApply(*options); });
}

}  // namespace slicemorph
