#include "tools/commands/render_command.h"

#include "slicemorph/errors.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/default_output.h"
#include "tools/job/limit_threads.h"
#include "tools/job/option_values.h"
#include "tools/job/render_pictures.h"

#include <optional>

namespace slicemorph {
namespace {

void runRender(OptionSet& options) {
  const JobOptions& given = options.values();
  if (given.inputs.empty())
    throw InputError("render needs an input; for example: slicemorph render a.vdb -o a.png");
  std::optional<DefaultOutput> fresh;
  if (given.contactSheet.empty()) fresh.emplace(kRender, options);
  const RenderJob job = renderJob(options);
  checkRenderOutputs(job);
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  if (fresh) events.notes(fresh->notes());
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
