#include "tools/slicer/slicer_module.h"

#include "tools/job/option_values.h"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <stdexcept>

namespace slicemorph {
namespace {

bool isNumeric(ParameterKind kind) {
  return kind == ParameterKind::kInteger || kind == ParameterKind::kNumber;
}

std::optional<double> numberIn(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !std::isfinite(value)) return std::nullopt;
  return value;
}

ParameterKind kindOf(const OptionRow& row) {
  if (!row.choices.empty()) return ParameterKind::kChoice;
  switch (row.type) {
    case OptionType::kFlag:
      return ParameterKind::kFlag;
    case OptionType::kInteger:
      return ParameterKind::kInteger;
    case OptionType::kNumber:
      return ParameterKind::kNumber;
    default:
      return ParameterKind::kText;
  }
}

/// The formats of a kind that both Slicer and io/formats.cpp have; first what Slicer prefers of them.
std::vector<std::string> extensionsOf(ParameterKind kind, bool output) {
  if (kind == ParameterKind::kPoints) return {};
  if (kind == ParameterKind::kModel && output) return {".vtp", ".ply", ".stl", ".obj"};
  if (kind == ParameterKind::kModel) return {".ply", ".stl", ".obj"};
  return {".nrrd", ".nii.gz", ".nii", ".mha"};
}

}  // namespace

ModuleValues::ModuleValues(const std::vector<ParameterGroup>& groups) {
  for (const ParameterGroup& group : groups)
    for (const ModuleParameter& parameter : group.parameters)
      parameters_[parameter.name] = parameter, texts_[parameter.name] = parameter.value;
}

const ModuleParameter& ModuleValues::parameter(const std::string& name) const {
  const auto found = parameters_.find(name);
  if (found == parameters_.end()) throw std::logic_error("the module has no parameter named " + name);
  return found->second;
}

void ModuleValues::set(const std::string& name, const std::string& text) {
  const ModuleParameter& known = parameter(name);
  if (isNumeric(known.kind)) {
    const std::optional<double> value = numberIn(text);
    if (!value) throw InputError("--" + name + " " + text + " is not a number");
    if (*value < known.range.least || *value > known.range.most)
      throw InputError("--" + name + " " + text + " is out of range; it must be " +
                       formatNumber(known.range.least) + " to " + formatNumber(known.range.most, 9));
  }
  std::string& value = texts_[name];
  if (known.kind == ParameterKind::kPoints) {
    if (parseNumbers("--" + name, text).size() != 3)
      throw InputError("--" + name + " " + text + " is no point; expected x,y,z");
    value += (value.empty() ? "" : ";") + text;
  } else {
    value = text;
  }
}

const std::string& ModuleValues::text(const std::string& name) const {
  return texts_.at(parameter(name).name);
}

double ModuleValues::number(const std::string& name) const { return numberIn(text(name)).value(); }

bool ModuleValues::given(const std::string& name) const {
  const std::string& value = text(name);
  if (isNumeric(parameter(name).kind)) return numberIn(value) != numberIn(parameter(name).value);
  return !value.empty() && value != parameter(name).value;
}

void ModuleValues::apply(OptionSet& options) const {
  for (const auto& [name, parameter] : parameters_)
    if (!parameter.option.empty() && given(name)) options.set(options.row(parameter.option), {text(name)});
}

std::string parameterName(const std::string& option) {
  std::string name;
  bool begins = false;
  for (const char c : option) {
    if (c != '-') name += begins ? char(std::toupper(static_cast<unsigned char>(c))) : c;
    begins = c == '-';
  }
  return name;
}

ModuleParameter ofOption(Command command, const std::string& option) {
  const OptionSet options(command);
  const OptionRow& row = options.row(option);
  ModuleParameter parameter;
  parameter.kind = kindOf(row);
  parameter.name = parameterName(option);
  parameter.label = option;
  for (char& c : parameter.label) c = c == '-' ? ' ' : c;
  parameter.label[0] = char(std::toupper(static_cast<unsigned char>(parameter.label[0])));
  parameter.help = helpOf(row);
  parameter.value = parameter.kind == ParameterKind::kFlag ? "false" : defaultOf(row);
  parameter.range = row.range;
  parameter.choices = row.choices;
  parameter.option = option;
  if (isNumeric(parameter.kind) && parameter.value.empty()) {
    parameter.value = "0";
    parameter.help += "; 0 stands for the default";
    parameter.range.least = std::fmin(parameter.range.least, 0);
  }
  return parameter;
}

ModuleParameter inputOf(ParameterKind kind, const std::string& name, const std::string& label,
                        const std::string& help) {
  ModuleParameter parameter;
  parameter.kind = kind, parameter.name = name, parameter.label = label, parameter.help = help;
  parameter.extensions = extensionsOf(kind, false);
  return parameter;
}

ModuleParameter outputOf(ParameterKind kind, const std::string& name, const std::string& label,
                         const std::string& help, const std::string& beside) {
  ModuleParameter parameter = inputOf(kind, name, label, help);
  parameter.extensions = extensionsOf(kind, true);
  parameter.output = true, parameter.beside = beside;
  return parameter;
}

ModuleParameter folderOf(const std::string& name, const std::string& label, const std::string& help) {
  ModuleParameter parameter;
  parameter.kind = ParameterKind::kFolder, parameter.output = true;
  parameter.name = name, parameter.label = label, parameter.help = help;
  return parameter;
}

ParameterGroup executionGroup(Command command) {
  ModuleParameter remarks;
  remarks.kind = ParameterKind::kRemark, remarks.output = true;
  remarks.name = "remarks", remarks.label = "Remarks";
  remarks.help = "What was found, decided or left out in the last run";
  return {"Execution",
          "How much of the machine is used, and what there was to say.",
          true,
          {ofOption(command, "threads"), ofOption(command, "memory"), remarks}};
}

}  // namespace slicemorph
