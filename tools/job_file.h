#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace slicemorph {

enum class JobType { kInteger, kNumber, kText, kFlag, kNumbers, kTexts, kPlaces };

/// An option of a command that a job file may give.
struct JobOption {
  std::string key;  ///< the long option's name without its dashes, or `inputs`, `output`
  JobType type;
  CLI::Option* option;
  std::string
      group;  ///< options of one group exclude each other: one on the command line silences the file's
};

/// Reads a TOML job file of `key = value` lines and gives its values to the options that the command line has
/// not set. kNumbers also takes a single number, and
/// joins several by commas; kTexts a single text; kPlaces a text, or a list of lists of x,y,z, joined as "x,y,z=x,y,z;...". Throws IoError where the file
/// cannot be read, InputError for syntax errors, unknown keys and wrong types, all with `file:line:column`.
void applyJobFile(const std::string& path, const std::vector<JobOption>& options);

}  // namespace slicemorph
