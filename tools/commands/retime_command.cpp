#include "tools/commands/retime_command.h"

#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/default_output.h"
#include "tools/job/limit_threads.h"
#include "tools/job/retime_job.h"
#include "tools/job/run_retime.h"

namespace slicemorph {
namespace {

void runRetimeCommand(OptionSet& options) {
  const JobOptions& given = options.values();
  DefaultOutput fresh(kRetime, options);
  const RetimeJob job = retimeJob(options);
  const auto limit = limitThreads(given.threads);
  job.settings.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  events.notes(fresh.notes());
  runRetime(job, events);
}

}  // namespace

void addRetimeCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "retime",
      "Show a sequence of VDB files slower, faster or along a curve, with frames between the files");
  const auto options = addOptions(*command, kRetime);
  command->callback([options] { runRetimeCommand(*options); });
}

}  // namespace slicemorph
