#include "tools/commands/reconstruct_command.h"

#include "slicemorph/io/output.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/image_lattice.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct.h"
#include "tools/job/write_structures.h"

#include <cmath>

namespace slicemorph {
namespace {

/// Throws InputError for what are not two ascending whole numbers or more.
std::vector<int> sliceNumbers(const std::string& text) {
  std::vector<int> slices;
  if (text.empty()) return slices;
  for (const double number : parseNumbers("--given", text)) {
    if (number != std::floor(number) || number < 0 || number > 1e6 ||
        (!slices.empty() && number <= slices.back()))
      throw InputError("--given " + text + ": slices are whole numbers from 0, ascending");
    slices.push_back(int(number));
  }
  if (slices.size() < 2)
    throw InputError("--given " + text + " is one slice; two or more can be filled between");
  return slices;
}

ReconstructJob reconstructJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  ReconstructJob job;
  job.input = given.input, job.output = given.output;
  if (given.axis != "auto") job.axis = int(std::string("ijk").find(given.axis));
  job.given = sliceNumbers(given.givenSlices);
  job.every = given.every, job.between = given.between, job.voxelSize = given.load.voxelSize;
  job.space = meshSpace(options, job.output, MeshSpace::kLps);
  job.like = given.like, job.source = given.source, job.names = given.names, job.reports = given.reports;
  job.image = loadSettings(options).image;
  job.imageKind = loadSettings(options).imageKind;
  job.memory = memorySettings(options);
  if (options.given("grids")) job.grids = parseNames("--grids", given.grids);
  checkStudyOutput(job.output, job.source, job.names);
  for (const std::string& report : job.reports) {
    checkExtension(report, {".json", ".csv"});
    checkOutputPath(report);
  }
  return job;
}

void runReconstruct(const OptionSet& options) {
  const JobOptions& given = options.values();
  const ReconstructJob job = reconstructJob(options);
  const auto limit = limitThreads(given.threads);
  job.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  reconstruct(job, events);
}

}  // namespace

void addReconstructCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "reconstruct", "A dense label map or closed surfaces from slices or contours, grids from EXR slices");
  const auto options = addOptions(*command, kReconstruct);
  command->callback([options] { runReconstruct(*options); });
}

}  // namespace slicemorph
