#pragma once

#include "tools/job/option_set.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

class FileClaim;

/// A name for what is made of inputs, by their names without folders, numbers and extensions: "a_to_b"; of more than four
/// only the first and the last one's.
std::string joinedNames(const std::vector<std::string>& inputs, const std::string& between);

/// The first of "name", "name_2", "name_3" ... that `isFree`.
std::string freeName(const std::string& name, const std::function<bool(const std::string&)>& isFree);

/// Where a command writes without -o: beside its first input, or in the current folder where that one cannot be written
/// to, by a name that no file has yet, of two programs each by its own: the name is claimed as long as this lives. Several
/// files get a folder of their own, which is made at once and goes away with this where nothing was written into it.
class DefaultOutput {
 public:
  /// Chooses and sets the option `output` where it is not given and there are inputs to name it by; else does nothing.
  /// To be called when files have given their options. Throws IoError where the input is missing; InputError where neither folder can be written to, or with
  /// --resume, which goes on with an output that is named.
  DefaultOutput(Command command, OptionSet& options);
  ~DefaultOutput();
  DefaultOutput(const DefaultOutput&) = delete;
  DefaultOutput& operator=(const DefaultOutput&) = delete;

  /// What was chosen, to be told; none where nothing was.
  Notes notes() const;

 private:
  std::string output_, folder_;
  std::unique_ptr<FileClaim> claim_;
};

}  // namespace slicemorph
