#pragma once

#include "tools/job/option_set.h"

#include <optional>
#include <string>
#include <utility>

namespace slicemorph {

/// A job file by its path, or with its content where that is in memory; the path is then its name.
struct JobFile {
  JobFile(std::string path, std::optional<std::string> text = std::nullopt)
      : path(std::move(path)), text(std::move(text)) {}
  explicit JobFile(const JobOptions& options) : JobFile(options.config, options.configText) {}
  std::string path;
  std::optional<std::string> text;
};

/// Reads a TOML job file of `key = value` lines. Sets the options that are neither set nor silenced by the
/// command line, and remembers for each its position in the file. kNumbers takes a number, a list of numbers,
/// which are joined by commas, or a text; kTexts also a single text; kLandmarks a text, or a list of lists of
/// x,y,z, joined as "x,y,z=x,y,z;...". Throws IoError where the file cannot be read; InputError for syntax
/// errors, unknown keys and wrong values, with `file:line:column`.
void applyJobFile(const JobFile& file, OptionSet& options);

}  // namespace slicemorph
