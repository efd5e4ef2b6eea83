#include "tools/commands/common_options.h"

#include <cstdio>

namespace slicemorph {

void printNotes(const std::string& about, const Notes& notes, bool quiet, bool verbose) {
  if (quiet) return;
  for (const Note& note : notes) {
    if (note.severity == Severity::kDetail && !verbose) continue;
    std::fprintf(stderr, "%s: %s%s\n", note.severity == Severity::kWarning ? "warning" : "note",
                 about.c_str(), note.sentence().c_str());
  }
}

}  // namespace slicemorph
