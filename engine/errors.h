#pragma once

#include <stdexcept>
#include <string>

namespace slicemorph {

/// An option or a call that cannot be carried out: the message names it, its value and what would be right.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file that cannot be read or written: the message names the file and the reason.
struct IoError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Data that is readable but is no usable shape (open, empty, not orientable ...).
struct GeometryError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The caller's cancel token was set.
struct Cancelled : std::runtime_error {
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace slicemorph
