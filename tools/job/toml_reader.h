#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/note.h"
#include "tools/job/job_file.h"

#include <toml++/toml.h>

#include <string>
#include <vector>

/// Values of a TOML file and their positions in it. Compiles slowly: include only in sources that
/// read such files.
namespace slicemorph {

/// `file:line:column: `
std::string positionOf(const std::string& path, const toml::source_region& source);

/// Throws IoError where the file cannot be read, InputError for syntax errors, with their position.
toml::table parseToml(const JobFile& file);

/// Reads the tables of a file. All functions throw InputError `file:line:column: ABOUT: ...` with the value
/// and what would be right. `what`: names the value in messages.
class TomlReader {
 public:
  explicit TomlReader(const std::string& path) : path_(path) {}
  /// ABOUT of the messages: `feature 'nose'`; empty: none.
  void setAbout(const std::string& about) { about_ = about; }

  [[noreturn]] void refuse(const toml::node& at, const std::string& message) const;
  std::string where(const toml::node& at) const;  ///< `file:line:column: ABOUT: `
  void checkKeys(const toml::table& table, const std::vector<std::string>& known) const;
  /// Which one of these keys a table has. Throws unless it is exactly one.
  std::string onlyOne(const toml::table& table, const std::vector<std::string>& keys) const;
  const toml::node& needed(const toml::table& table, const std::string& key,
                           const std::string& example) const;
  const toml::table& table(const toml::node& node, const std::string& what, const std::string& example) const;
  const toml::array& array(const toml::node& node, const std::string& what, const std::string& example) const;
  /// A list with one item per input.
  const toml::array& perInput(const toml::node& node, const std::string& what, size_t inputs) const;
  std::string text(const toml::node& node, const std::string& what) const;
  double number(const toml::node& node, const std::string& what) const;  ///< finite
  std::vector<double> numbers(const toml::node& node, const std::string& what) const;
  Vec3d vector(const toml::node& node, const std::string& what) const;
  void addNote(const Note& note) { notes_.push_back(note); }
  const Notes& notes() const { return notes_; }

 private:
  const std::string path_;
  std::string about_;
  Notes notes_;
};

/// A value on one line, shortened if it is long.
std::string shortText(const toml::node& node);

}  // namespace slicemorph
