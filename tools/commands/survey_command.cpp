#include "tools/commands/survey_command.h"

#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/limit_threads.h"
#include "tools/job/survey_job.h"

namespace slicemorph {
namespace {

void runSurveyCommand(const OptionSet& options) {
  const SurveyJob job = surveyJob(options);
  const JobOptions& given = options.values();
  printNotes("", job.morph.notes, given.quiet, given.verbose);
  const auto limit = limitThreads(given.threads);
  job.morph.settings.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  runSurvey(job, events);
}

}  // namespace

void addSurveyCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "survey", "Every method on the same objects, side by side on one page, with figures and a score");
  const auto options = addOptions(*command, kSurvey);
  command->callback([options] { runSurveyCommand(*options); });
}

}  // namespace slicemorph
