#include "tools/commands/terminal_events.h"

#include "tools/commands/common_options.h"

#include <cstdio>

namespace slicemorph {

TerminalEvents::TerminalEvents(bool quiet, bool verbose)
    : quiet_(quiet), verbose_(verbose), progress_(quiet) {
  cancelOnInterrupt();
}

void TerminalEvents::note(const Note& note) {
  if (quiet_) return;
  progress_.clear();
  printNotes("", {note}, quiet_, verbose_);
}

void TerminalEvents::fileWritten(const std::string& path, bool kept) {
  progress_.clear();
  if (!quiet_) std::printf("%s%s\n", path.c_str(), kept ? " (kept)" : "");
  std::fflush(stdout);
}

}  // namespace slicemorph
