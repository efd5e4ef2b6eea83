#pragma once

#include "slicemorph/errors.h"
#include "tools/job/option_row.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// The options of one command: their values, which of them were given, and where. Filled by the command line
/// and then by a job file; a program in another language fills it itself. Names are those of the table; one
/// that the command does not have throws std::logic_error.
class OptionSet {
 public:
  explicit OptionSet(Command command);

  /// The command's rows in the table's order.
  const std::vector<const OptionRow*>& rows() const { return rows_; }
  const OptionRow& row(const std::string& name) const;
  const JobOptions& values() const { return values_; }

  /// Gives an option its value, one text of it or, for kTexts, any number. Throws InputError for what is no
  /// value of the option.
  void set(const OptionRow& row, const std::vector<std::string>& texts);
  /// Remembers where a file says an option: `file:line:column: `. Tables are given by this alone.
  void setPlace(const std::string& name, const std::string& place) { places_[name] = place; }

  bool given(const std::string& name) const;
  /// The texts that set() was given; empty: none.
  std::vector<std::string> texts(const std::string& name) const;
  /// Empty where the option was not said in a file.
  std::string place(const std::string& name) const;
  /// What is given on the command line wins over a file's value of this option.
  bool silenced(const OptionRow& row) const;

  /// Throws InputError where two that exclude each other are given.
  void checkExclusions() const;
  /// Throws InputError, with the place where a file says that option.
  [[noreturn]] void refuse(const std::string& name, const std::string& message) const;
  /// Runs what reads or checks an option's value; its errors get the place where a file says the option.
  template <typename Action>
  auto about(const std::string& name, const Action& action) const {
    try {
      return action();
    } catch (const InputError& error) {
      if (place(name).empty()) throw;
      throw InputError(place(name) + error.what());
    } catch (const IoError& error) {
      if (place(name).empty()) throw;
      throw IoError(place(name) + error.what());
    }
  }

  using Pairs = std::vector<std::pair<std::string, std::string>>;
  /// Options with a value, given or by default, on which frames depend.
  Pairs frameSettings() const;
  /// Options that were given and are for that kind of output, with their texts.
  Pairs givenFor(OptionTarget target) const;

 private:
  std::vector<const OptionRow*> rows_;
  JobOptions values_;
  std::map<std::string, std::vector<std::string>> texts_;
  std::map<std::string, std::string> places_;
};

}  // namespace slicemorph
