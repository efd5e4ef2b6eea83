#pragma once

#include "tools/job/option_set.h"
#include "tools/python/long_call.h"

#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// An input as Python has it: in memory, or, where nothing is held, by its name.
struct PyInput {
  std::string name;
  std::shared_ptr<const HeldInput> held;
};

/// The name by which tables of a job file are among options; its text is TOML.
constexpr const char* kTablesName = "options";

/// Options of a command by their names, with their texts.
using GivenOptions = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// The options of a command, with inputs in its row `row`. Throws InputError for options that it does not have.
OptionSet optionsOf(Command command, const std::string& row, const std::vector<PyInput>& inputs,
                    const GivenOptions& given);

/// The image as an input.
PyInput inputOf(const std::string& name, Image image, bool labels);

void addInput(py::module_& module);

}  // namespace slicemorph
