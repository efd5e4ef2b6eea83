#pragma once

#include "slicemorph/note.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace slicemorph {

/// Base of all exceptions that the library throws on purpose. The note contains the parts of what().
class Error : public std::runtime_error {
 public:
  explicit Error(Note note) : std::runtime_error(note.sentence()), note_(std::move(note)) {
    note_.severity = Severity::kError;
  }
  explicit Error(const std::string& text) : Error(Note(text)) {}
  explicit Error(const char* text) : Error(Note(text)) {}
  /// `about`: the file, option or grid.
  Error(const std::string& about, const std::string& text) : Error(Note("", Severity::kError, about, text)) {}

  const Note& note() const { return note_; }

 private:
  Note note_;
};

/// An option or a call that cannot be carried out. The message names it, its value and what would be right.
struct InputError : Error {
  using Error::Error;
};

/// A file that cannot be read or written. The message names the file and the reason.
struct IoError : Error {
  using Error::Error;
};

/// Data that can be read but is not a usable shape (open, empty, not orientable ...).
struct GeometryError : Error {
  using Error::Error;
};

/// The caller requested cancellation.
struct Cancelled : Error {
  Cancelled() : Error("cancelled") {}
};

}  // namespace slicemorph
