#pragma once

#include "tools/slicer/slicer_module.h"

#include <string>
#include <vector>

namespace slicemorph {

/// A command line as Slicer builds it of a module's description.
struct ModuleArguments {
  enum class Wanted { kRun, kXml, kHelp, kVersion };
  Wanted wanted = Wanted::kRun;
  ModuleValues values;
  std::string returnFile;  ///< of --returnparameterfile: where remarks go; empty: nowhere
};

/// Reads `--name value` and `--name=value`, flags without a value, and what Slicer gives every module:
/// --returnparameterfile, --processinformationaddress (of modules in Slicer's own process; ignored). Throws InputError.
ModuleArguments readArguments(const SlicerModule& module, const std::vector<std::string>& words);

/// The parameters in words, for people.
std::string usageOf(const SlicerModule& module);

}  // namespace slicemorph
