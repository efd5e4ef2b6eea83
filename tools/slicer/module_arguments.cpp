#include "tools/slicer/module_arguments.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// All that a command line may set, in the order of the panel.
std::vector<const ModuleParameter*> settable(const SlicerModule& module) {
  std::vector<const ModuleParameter*> all;
  for (const ParameterGroup& group : module.groups)
    for (const ModuleParameter& parameter : group.parameters)
      if (parameter.kind != ParameterKind::kRemark) all.push_back(&parameter);
  return all;
}

[[noreturn]] void refuseWord(const SlicerModule& module, const std::string& word) {
  std::string names;
  for (const ModuleParameter* parameter : settable(module))
    names += (names.empty() ? "--" : " --") + parameter->name;
  throw InputError("'" + word + "' is no parameter of " + module.name + "; there are " + names);
}

}  // namespace

ModuleArguments readArguments(const SlicerModule& module, const std::vector<std::string>& words) {
  using Wanted = ModuleArguments::Wanted;
  ModuleArguments arguments{Wanted::kRun, ModuleValues(module.groups), ""};
  const std::vector<const ModuleParameter*> known = settable(module);
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--xml") arguments.wanted = Wanted::kXml;
    if (word == "--help" || word == "-h") arguments.wanted = Wanted::kHelp;
    if (word == "--version") arguments.wanted = Wanted::kVersion;
    if (arguments.wanted != Wanted::kRun) return arguments;
    if (word.compare(0, 2, "--") != 0) refuseWord(module, word);
    const size_t equals = word.find('=');
    const std::string name = word.substr(2, equals == std::string::npos ? equals : equals - 2);
    const auto value = [&] {
      if (equals != std::string::npos) return word.substr(equals + 1);
      if (i + 1 == words.size()) throw InputError("--" + name + " needs a value");
      return words[++i];
    };
    if (name == "returnparameterfile") {
      arguments.returnFile = value();
    } else if (name == "processinformationaddress") {
      value();
    } else {
      const auto found =
          std::find_if(known.begin(), known.end(), [&](const ModuleParameter* p) { return p->name == name; });
      if (found == known.end()) refuseWord(module, word);
      const bool flag = (*found)->kind == ParameterKind::kFlag && equals == std::string::npos;
      arguments.values.set(name, flag ? "true" : value());
    }
  }
  return arguments;
}

std::string usageOf(const SlicerModule& module) {
  std::string text = module.description +
                     "\n\nA command-line module of 3D Slicer; --xml prints its description for Slicer.\n";
  for (const ParameterGroup& group : module.groups) {
    text += "\n" + group.label + ":\n";
    for (const ModuleParameter& parameter : group.parameters)
      if (parameter.kind != ParameterKind::kRemark)
        text += "  --" + parameter.name + "  " + parameter.help + "\n";
  }
  return text;
}

}  // namespace slicemorph
