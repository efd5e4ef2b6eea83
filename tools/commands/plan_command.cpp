#include "tools/commands/plan_command.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/job_file.h"
#include "tools/job/limit_threads.h"
#include "tools/job/morph_checks.h"
#include "tools/job/morph_job.h"
#include "tools/job/option_values.h"
#include "tools/job/run_plan.h"

namespace slicemorph {
namespace {

void runPlanCommand(OptionSet& options) {
  const JobOptions& given = options.values();
  if (!given.planFile.empty())
    options.refuse("plan", "--plan " + given.planFile + " is for morph; -o names the plan that is written");
  if (!given.config.empty()) applyJobFile(given.config, options);
  if (given.output.empty()) options.refuse("output", "plan needs an output; for example: -o morph.plan");
  checkEssentials(options);
  const std::string output = given.output;
  if (extensionOf(output) != ".plan")
    options.refuse(
        "output",
        "-o " + output + ": a plan is a file name.plan; `slicemorph morph --plan` makes frames of it");
  checkOutputPath(output);
  // Plans are made as for a sequence of grids; of fog other outputs ask for a finer shape.
  options.set(options.row("output"), {output + ".####.vdb"});
  const PlanFile like = planFileOf(options);
  const MorphJob job = morphJob(options);
  printNotes("", job.notes, given.quiet, given.verbose);
  if (!job.settings.can().guided)
    options.refuse("method",
                   "--method " + job.settings.method + " plans nothing that a file could hold; leave it out");
  const auto limit = limitThreads(given.threads);
  job.settings.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  runPlan(job.settings, like, output, events);
}

}  // namespace

void addPlanCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "plan",
      "Decide how shapes belong together, once, as a file by which `morph --plan` makes frames at once");
  const auto options = addOptions(*command, kMorph);
  command->callback([options] { runPlanCommand(*options); });
}

}  // namespace slicemorph
