#pragma once

#include "slicemorph/note.h"

#include <memory>
#include <string>

/// What several commands share.
namespace slicemorph {

/// Limits TBB for as long as the result lives; 0: no limit.
std::shared_ptr<void> limitThreads(int threads);

/// Prints what was found or chosen, one line each, on stderr: `note: ABOUT...`, or `warning: ABOUT...`. How
/// decisions were reached (Severity::kDetail) is for `verbose` alone.
void printNotes(const std::string& about, const Notes& notes, bool quiet, bool verbose = false);

}  // namespace slicemorph
