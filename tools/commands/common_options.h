#pragma once

#include "slicemorph/note.h"

#include <string>

/// Helpers that several commands share.
namespace slicemorph {

/// Prints notes on stderr, one line each: `note: ABOUT...` or `warning: ABOUT...`. Details of how decisions
/// were reached (Severity::kDetail) only with `verbose`.
void printNotes(const std::string& about, const Notes& notes, bool quiet, bool verbose = false);

}  // namespace slicemorph
