#include "io/atomic_file.h"
#include "slicemorph/errors.h"
#include "tools/slicer/module_arguments.h"
#include "tools/slicer/module_xml.h"
#include "tools/slicer/slicer_events.h"

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <vector>

namespace {

using namespace slicemorph;

constexpr int kDone = 0, kFailed = 1, kWrongUsage = 2;
constexpr const char* kOutOfMemory = "out of memory: choose a larger voxel size or a smaller resolution";

int fail(int code, const std::string& name, const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", name.c_str(), message.c_str());
  return code;
}

/// Where memory ends in a place that no exception may leave, there is a message, too, and no abort.
[[noreturn]] void endModule() {
  removeOpenFiles();
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    std::_Exit(fail(kFailed, "slicemorph", kOutOfMemory));
  } catch (...) {
  }
  std::abort();
}

int runModule(const SlicerModule& module, const std::vector<std::string>& words) {
  const ModuleArguments arguments = readArguments(module, words);
  switch (arguments.wanted) {
    case ModuleArguments::Wanted::kXml:
      std::fputs(xmlOf(module).c_str(), stdout);
      return kDone;
    case ModuleArguments::Wanted::kHelp:
      std::fputs(usageOf(module).c_str(), stdout);
      return kDone;
    case ModuleArguments::Wanted::kVersion:
      std::printf("%s %s\n", module.name.c_str(), SLICEMORPH_VERSION);
      return kDone;
    case ModuleArguments::Wanted::kRun:
      break;
  }
  openvdb::initialize();
  SlicerEvents events("Slicemorph: " + module.title);
  WholeImages whole(events);
  module.run(arguments.values, whole);
  if (!arguments.returnFile.empty())
    writeTextFile(arguments.returnFile, "remarks = " + events.remarks() + "\n");
  events.finish();
  return kDone;
}

/// Runs the module of that name with exit codes for what goes wrong.
int runNamed(const std::string& name, const std::vector<std::string>& words) {
  std::string names;
  for (SlicerModule (*const make)() : {morphModule, fillModule, surfaceModule}) {
    const SlicerModule module = make();
    if (module.name == name) return runModule(module, words);
    names += (names.empty() ? "" : ", ") + module.name;
  }
  throw InputError("there is no module '" + name + "'; there are " + names);
}

}  // namespace

/// slicemorph_slicer MODULE ARGUMENT...
int main(int argc, char** argv) {
  std::set_terminate(endModule);
  const std::string name = argc > 1 ? argv[1] : "";
  try {
    return runNamed(name, {argv + std::min(argc, 2), argv + argc});
  } catch (const InputError& error) {
    return fail(kWrongUsage, name, error.what());
  } catch (const std::bad_alloc&) {
    return fail(kFailed, name, kOutOfMemory);
  } catch (const std::exception& error) {
    return fail(kFailed, name, error.what());
  }
}
