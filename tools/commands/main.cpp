#include "io/atomic_file.h"
#include "slicemorph/errors.h"
#include "tools/commands/apply_command.h"
#include "tools/commands/compare_command.h"
#include "tools/commands/convert_command.h"
#include "tools/commands/demo_command.h"
#include "tools/commands/info_command.h"
#include "tools/commands/manual.h"
#include "tools/commands/morph_command.h"
#include "tools/commands/pick_command.h"
#include "tools/commands/plan_command.h"
#include "tools/commands/reconstruct_command.h"
#include "tools/commands/render_command.h"
#include "tools/commands/retime_command.h"
#include "tools/commands/slice_command.h"
#include "tools/commands/survey_command.h"

#include <openvdb/openvdb.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <system_error>

namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUsage = 2;

constexpr const char* kOutOfMemory =
    "out of memory: choose a larger --voxel-size or a smaller --resolution, or let it take more (--memory)";

int fail(int code, const std::string& message) {
  std::fprintf(stderr, "slicemorph: %s\n", message.c_str());
  return code;
}

/// The message of an error that is none of the library's own. Threads and their stacks, too, are refused where memory ends.
const char* messageOf(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error)) return kOutOfMemory;
  const auto* refused = dynamic_cast<const std::system_error*>(&error);
  return refused && refused->code() == std::errc::resource_unavailable_try_again ? kOutOfMemory
                                                                                 : error.what();
}

/// Where something fails in a place that no exception may leave, there is a message, too, and no abort. (Where memory
/// ends, TBB fails while it ends its threads.)
[[noreturn]] void endProgram() {
  slicemorph::removeOpenFiles();
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::exception& error) {
    fail(kFailed, messageOf(error));
    std::_Exit(kFailed);
  } catch (...) {
  }
  std::abort();
}

/// Reports an error of the command line and names the command whose help lists the options.
int failUsage(const CLI::App& program, const CLI::ParseError& error) {
  std::string command = "slicemorph";
  for (const CLI::App* sub : program.get_subcommands()) command += " " + sub->get_name();
  return fail(kWrongUsage, std::string(error.what()) + "\nRun '" + command + " --help' for the options.");
}

int run(int argc, char** argv) {
  CLI::App program("Morphs volumes through oriented slices.\nExit code: 0 done, 1 failed, 2 wrong usage.",
                   "slicemorph");
  program.set_version_flag("--version", "slicemorph " SLICEMORPH_VERSION);
  program.set_help_all_flag("--help-all", "Print every option and exit");
  const auto writeManual = [&program](const std::string& folder) {
    slicemorph::writeManual(program, folder);
    throw CLI::Success();
  };
  program
      .add_option_function<std::string>("--manual", writeManual,
                                        "Write man pages and the completion for bash into a folder")
      ->type_name("FOLDER")
      ->trigger_on_parse();
  program.require_subcommand(1);
  program.get_formatter()->column_width(34);
  slicemorph::addMorphCommand(program);
  slicemorph::addPlanCommand(program);
  slicemorph::addPickCommand(program);
  slicemorph::addApplyCommand(program);
  slicemorph::addRetimeCommand(program);
  slicemorph::addConvertCommand(program);
  slicemorph::addCompareCommand(program);
  slicemorph::addSurveyCommand(program);
  slicemorph::addInfoCommand(program);
  slicemorph::addReconstructCommand(program);
  slicemorph::addRenderCommand(program);
  slicemorph::addSliceCommand(program);
  slicemorph::addDemoCommand(program);
  try {
    program.parse(argc, argv);
    return kDone;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    return failUsage(program, error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::set_terminate(endProgram);
  try {
    openvdb::initialize();
    return run(argc, argv);
  } catch (const slicemorph::InputError& error) {
    return fail(kWrongUsage, error.what());
  } catch (const std::exception& error) {
    return fail(kFailed, messageOf(error));
  }
}
