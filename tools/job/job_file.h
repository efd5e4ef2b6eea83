#pragma once

#include <CLI/CLI.hpp>

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// kTables: read by others (guidance_file.h), only known here.
enum class JobType { kInteger, kNumber, kText, kFlag, kNumbers, kTexts, kPlaces, kTables };

/// An option of a command that a job file may give.
struct JobOption {
  std::string key;  ///< the long option's name without its dashes, or `inputs`, `output`
  JobType type;
  CLI::Option* option;                      ///< null for tables that no option can say
  std::vector<std::string> silencers = {};  ///< on the command line these silence the file's
  std::string fallback = {};  ///< what holds where it is not given, as the command line has it; empty: none
};

/// Spells defaults for JobOption; 0 and an empty text stand for none.
std::string fallbackOf(double value);
inline std::string fallbackOf(const std::string& value) { return value; }
inline std::string fallbackOf(const std::vector<std::string>&) { return ""; }

/// Reads a TOML job file of `key = value` lines and gives its values to the options that the command line has
/// not set. kNumbers takes a number, several, which are joined by commas, or a text; kTexts also a single
/// text; kPlaces a text, or a list of lists of x,y,z, joined as "x,y,z=x,y,z;...". Returns the place,
/// `file:line:column: `, of every key that holds. Throws IoError where the file cannot be read, InputError
/// for syntax errors, unknown keys and wrong types, with the place.
std::map<std::string, std::string> applyJobFile(const std::string& path,
                                                const std::vector<JobOption>& options);

}  // namespace slicemorph
