#include "tools/commands/render_command.h"

#include "slicemorph/errors.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/limit_threads.h"
#include "tools/job/option_values.h"
#include "tools/job/render_pictures.h"

namespace slicemorph {
namespace {

void runRender(const OptionSet& options) {
  const JobOptions& given = options.values();
  if (given.inputs.empty())
    throw InputError("render needs an input; for example: slicemorph render a.vdb -o a.png");
  const RenderJob job = renderJob(options);
  if (job.output.empty() && job.sheet.empty())
    throw InputError("render needs an output: -o name.png, or --contact-sheet sheet.png");
  checkRenderOutputs(job);
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  renderPictures(job, events);
}

}  // namespace

void addRenderCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("render", "Pictures of shapes, fog and sequences, seen by one camera");
  const auto options = addOptions(*command, kRender);
  command->callback([options] { runRender(*options); });
}

}  // namespace slicemorph
