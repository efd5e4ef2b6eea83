#include "tools/commands/pick_command.h"

#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/limit_threads.h"
#include "tools/job/pick_job.h"

namespace slicemorph {
namespace {

void runPickCommand(const OptionSet& options) {
  const PickJob job = pickJob(options);
  const JobOptions& given = job.morph.settings.options;
  printNotes("", job.morph.notes, given.quiet, given.verbose);
  const auto limit = limitThreads(given.threads);
  job.morph.settings.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  runPick(job, events);
}

}  // namespace

void addPickCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "pick", "Point at what belongs together, on a page that shows the shapes; a job file comes out");
  const auto options = addOptions(*command, kPick);
  command->callback([options] { runPickCommand(*options); });
}

}  // namespace slicemorph
