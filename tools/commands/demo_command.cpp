#include "tools/commands/demo_command.h"

#include "engine/numerics/readable.h"
#include "slicemorph/errors.h"
#include "tools/commands/command_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/default_output.h"
#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"
#include "tools/job/run_demo.h"
#include "tools/job/stopwatch.h"
#include "tools/job/work_steps.h"

#include <cstdio>
#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "slicemorph-demo";

/// A file that comes with the program, in its place of installation or of building.
std::string bundled(const std::string& name) {
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::string searched;
  for (const char* share : {SLICEMORPH_SHARE_FROM_PROGRAM, "share"}) {
    const fs::path folder = (program / share / "slicemorph" / "shapes").lexically_normal();
    if (fs::exists(folder / name, ignored)) return (folder / name).string();
    searched += (searched.empty() ? "" : ", ") + folder.string();
  }
  throw IoError(name, "the shape that comes with the program is missing; looked in " + searched +
                          "; `slicemorph demo A B` takes shapes of yours");
}

/// The pairs of shapes to be morphed: those that are named, or bundled ones.
std::vector<std::vector<std::string>> pairsOf(const OptionSet& options) {
  const std::vector<std::string>& inputs = options.values().inputs;
  if (inputs.empty())
    return {{bundled("creature.ply"), bundled("ring.ply")}, {bundled("blade.ply"), bundled("creature.ply")}};
  if (inputs.size() != 2)
    options.refuse("inputs",
                   "demo takes two shapes, or none for bundled ones, not " + std::to_string(inputs.size()));
  for (const std::string& input : inputs) checkInputExists(input);
  return {inputs};
}

/// The folder of all results: that of -o, else one that is not there yet; it is made, so that of two programs each gets its
/// own.
std::string folderOf(const OptionSet& options) {
  const std::string& output = options.values().output;
  std::error_code problem;
  if (output.empty()) {
    const auto isFree = [&](const std::string& name) {
      const bool made = !fs::exists(fs::symlink_status(name)) && fs::create_directory(name, problem);
      if (problem) throw IoError(name, "the folder cannot be made: " + problem.message());
      return made;
    };
    return freeName(kFolder, isFree);
  }
  fs::create_directories(output, problem);
  if (problem) throw IoError(output, "the folder cannot be made: " + problem.message());
  return output;
}

/// Folders that were made here: takes away those, and those within, in which nothing is when it ends.
struct MadeFolders {
  ~MadeFolders() {
    std::error_code ignored;
    std::vector<fs::path> all;
    for (const std::string& folder : folders) {
      all.push_back(folder);
      for (fs::recursive_directory_iterator at(folder, ignored), end; at != end; at.increment(ignored))
        if (at->is_directory(ignored)) all.push_back(at->path());
    }
    // What is within comes behind: removed first. What is not empty stays.
    for (auto path = all.rbegin(); path != all.rend(); ++path) fs::remove(*path, ignored);
  }
  std::vector<std::string> folders;
};

/// "155 files, 23.4 MB, made in 45 s".
std::string summaryOf(const std::vector<DemoJob>& jobs, double seconds) {
  double files = 0, bytes = 0;
  for (const DemoJob& job : jobs)
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(job.folder))
      if (entry.is_regular_file()) ++files, bytes += double(entry.file_size());
  return readableCount(files) + " files, " + readableBytes(bytes) + ", made in " + readableDuration(seconds);
}

void runDemoCommand(const OptionSet& options) {
  const JobOptions& given = options.values();
  const std::vector<std::vector<std::string>> pairs = pairsOf(options);
  const MemoryLimit memory = memorySettings(options);
  const bool there = fs::exists(given.output);
  const std::string folder = folderOf(options);
  MadeFolders made;
  if (!there) made.folders.push_back(folder);
  std::vector<DemoJob> jobs;
  for (const std::vector<std::string>& pair : pairs) {
    const std::string name = joinedNames(pair, "_to_");
    jobs.push_back({pair, (fs::path(folder) / name).string(), name, given.memory});
    const std::string& own = jobs.back().folder;
    if (fs::exists(own))
      options.refuse("output", own + " is there already; name another folder by -o, or remove it");
  }
  const auto limit = limitThreads(given.threads);
  memory.enforce();
  Stopwatch watch;
  std::vector<DemoResult> results;
  TerminalEvents events(given.quiet, given.verbose);
  WorkSteps steps;
  for (size_t i = 0; i < jobs.size(); ++i) steps.add(1);
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (fs::create_directory(jobs[i].folder)) made.folders.push_back(jobs[i].folder);
    StepEvents part(events, steps, i);
    for (DemoResult& result : runDemo(jobs[i], part)) results.push_back(std::move(result));
  }
  events.clear();
  if (given.quiet) return;
  size_t width = 0;
  for (const DemoResult& result : results) width = std::max(width, result.path.size());
  for (const DemoResult& result : results)
    std::printf("%-*s  %s\n", int(width), result.path.c_str(), result.what.c_str());
  std::printf("%s\n", summaryOf(jobs, watch.lap()).c_str());
}

}  // namespace

void addDemoCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "demo", "See what the program makes: bundled shapes as VDB files, meshes, EXR slices and pictures");
  const auto options = addOptions(*command, kDemo);
  command->callback([options] { runDemoCommand(*options); });
}

}  // namespace slicemorph
