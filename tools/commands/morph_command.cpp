#include "tools/commands/morph_command.h"

#include "tools/commands/morph_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/run_morph.h"

namespace slicemorph {

void addMorphCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "morph", "Morph shapes, fog volumes or images into each other: a sequence, or one blend");
  const auto options = std::make_shared<MorphOptionSet>(*command);
  command->callback([options] {
    const MorphSettings settings = options->settings();
    TerminalEvents events(settings.quiet);
    runMorph(settings, events);
  });
}

}  // namespace slicemorph
