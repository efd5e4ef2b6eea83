#include "tools/commands/morph_command.h"

#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/default_output.h"
#include "tools/job/job_file.h"
#include "tools/job/limit_threads.h"
#include "tools/job/morph_checks.h"
#include "tools/job/morph_job.h"
#include "tools/job/plan_file.h"
#include "tools/job/run_morph.h"

#include <cstdio>

namespace slicemorph {
namespace {

/// Reads the job file, checks everything that can be checked without reading the inputs, and morphs; with
/// --print-config prints a job file instead.
void runMorphCommand(OptionSet& options) {
  const JobOptions& given = options.values();
  printNotes("", applyPlanFile(options), given.quiet, given.verbose);
  if (!given.config.empty()) applyJobFile(given.config, options);
  DefaultOutput fresh(kMorph, options);
  MorphJob job;
  // --print-config alone prints an empty job file to be filled in, for which no inputs are needed.
  if (!given.printConfig || !given.config.empty() || !given.inputs.empty()) job = morphJob(options);
  printNotes("", job.notes, given.quiet, given.verbose);
  if (given.printConfig) {
    std::fputs(jobText(options, job.tables).c_str(), stdout);
    return;
  }
  checkMorphFiles(job.settings, options);
  const auto limit = limitThreads(given.threads);
  job.settings.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  events.notes(fresh.notes());
  runMorph(job.settings, events);
}

}  // namespace

void addMorphCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "morph", "Morph shapes, fog volumes or images into each other: a sequence, or one blend");
  const auto options = addOptions(*command, kMorph);
  command->callback([options] { runMorphCommand(*options); });
}

}  // namespace slicemorph
