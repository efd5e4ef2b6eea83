#include "tools/commands/common_options.h"

#include <tbb/global_control.h>

#include <cstdio>

namespace slicemorph {

std::shared_ptr<void> limitThreads(int threads) {
  if (threads == 0) return nullptr;
  return std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism, size_t(threads));
}

void printNotes(const std::string& about, const Notes& notes, bool quiet, bool verbose) {
  if (quiet) return;
  for (const Note& note : notes) {
    if (note.severity == Severity::kDetail && !verbose) continue;
    std::fprintf(stderr, "%s: %s%s\n", note.severity == Severity::kWarning ? "warning" : "note",
                 about.c_str(), note.sentence().c_str());
  }
}

}  // namespace slicemorph
