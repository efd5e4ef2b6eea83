#pragma once

#include "slicemorph/errors.h"
#include "tools/job/option_row.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// The options of one command: their values, which of them were given, and where. Filled from the
/// command line and then from a job file. Names are those of the table; one that the command does not
/// have throws std::logic_error.
class OptionSet {
 public:
  explicit OptionSet(Command command);

  /// The command's rows in the table's order.
  const std::vector<const OptionRow*>& rows() const { return rows_; }
  const OptionRow& row(const std::string& name) const;
  const JobOptions& values() const { return values_; }

  /// Sets an option's value from one text or, for kTexts, any number of them. Throws InputError for texts
  /// that are no value of the option.
  void set(const OptionRow& row, const std::vector<std::string>& texts);
  /// Gives the content of inputs that no file holds; their names are set as those of files are.
  void hold(HeldInputs held) { values_.held = std::move(held); }
  /// Gives a job file that is in memory, as if --config named it.
  void holdJobFile(const std::string& name, const std::string& text) {
    values_.config = name, values_.configText = text;
  }
  /// Remembers the position of an option in a file: `file:line:column: `. For tables only this is called.
  void setSource(const std::string& name, const std::string& source) { sources_[name] = source; }

  bool given(const std::string& name) const;
  /// The texts that set() was called with; empty: none.
  std::vector<std::string> texts(const std::string& name) const;
  /// Position of the option in a file; empty where no file gives it.
  std::string source(const std::string& name) const;
  /// Whether an option on the command line overrules a file's value of this one.
  bool silenced(const OptionRow& row) const;

  /// Throws InputError where two options that exclude each other are given.
  void checkExclusions() const;
  /// Throws InputError; the message begins with the option's position if a file gives it.
  [[noreturn]] void refuse(const std::string& name, const std::string& message) const;
  /// Runs an action that reads or checks an option's value; its errors get the option's position in the file.
  template <typename Action>
  auto about(const std::string& name, const Action& action) const {
    try {
      return action();
    } catch (const InputError& error) {
      if (source(name).empty()) throw;
      throw InputError(source(name) + error.what());
    } catch (const IoError& error) {
      if (source(name).empty()) throw;
      throw IoError(source(name) + error.what());
    }
  }

  using Pairs = std::vector<std::pair<std::string, std::string>>;
  /// Options on which frames depend, with their values, given or by default.
  Pairs frameSettings() const;
  /// Options for that kind of output that were given, with their texts.
  Pairs givenFor(OptionTarget target) const;

 private:
  std::vector<const OptionRow*> rows_;
  JobOptions values_;
  std::map<std::string, std::vector<std::string>> texts_;
  std::map<std::string, std::string> sources_;
};

}  // namespace slicemorph
