#include "tools/job/reconstruct.h"

#include "io/paths.h"
#include "slicemorph/io/input.h"
#include "tools/job/image_lattice.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct_contours.h"
#include "tools/job/reconstruct_labels.h"
#include "tools/job/reconstruct_slices.h"

#include <cmath>

namespace slicemorph {
namespace {

/// EXR images are slices with planes of their own, unless --spacing says that they are a stack of labels.
bool isOfSlices(const ReconstructJob& job, const InputSpec& input) {
  return extensionOf(input.path) == ".exr" && job.image.spacing[0] == 0;
}

/// Throws InputError for braces behind slices and contours, whose own attributes say where they lie.
void refusePlacing(const InputSpec& input) {
  if (input.placing.given())
    throw InputError(
        input.text +
        ": slices and contours are put where their file says that they lie; leave the braces out, "
        "and give them to the file that is made, as convert made.vdb{scale=2}");
}

/// Throws InputError for options that have no effect on EXR slices.
void refuseForSlices(const ReconstructJob& job) {
  const std::vector<std::pair<bool, std::string>> others = {
      {job.every > 0, "--every"}, {job.between > 0, "--between"}, {!job.given.empty(), "--given"},
      {job.axis >= 0, "--axis"},  {!job.like.empty(), "--like"},  {!job.reports.empty(), "--report"}};
  for (const auto& [given, option] : others)
    if (given)
      throw InputError(option + " is for label maps and contours; " + job.input + " are slices of grids");
}

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

}  // namespace

ReconstructJob reconstructJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  ReconstructJob job;
  job.input = given.input, job.output = given.output;
  if (!given.held.empty()) job.held = given.held[0];
  if (given.axis != "auto") job.axis = int(std::string("ijk").find(given.axis));
  job.given = sliceNumbers(given.givenSlices);
  job.every = given.every, job.between = given.between, job.voxelSize = given.load.voxelSize;
  job.space = meshSpace(options, job.output, MeshSpace::kLps);
  job.like = given.like, job.source = given.source, job.names = given.names, job.reports = given.reports;
  const LoadOptions load = loadSettings(options);
  job.image = load.image, job.imageKind = load.imageKind;
  job.memory = memorySettings(options);
  if (options.given("grids")) job.grids = parseNames("--grids", given.grids);
  return job;
}

void reconstruct(const ReconstructJob& job, JobEvents& events) {
  if (job.held) {
    if (!job.held->spec.isImage())
      throw InputError(job.input, "is no image; of what is in memory only images can be reconstructed");
    return reconstructImage(job, events);
  }
  const InputSpec input = parseInput(job.input);
  if (isOfSlices(job, input)) {
    refuseForSlices(job);
    refusePlacing(input);
    return reconstructSlices(job, events);
  }
  if (job.grids) throw InputError("--grids is for EXR slices; " + job.input + " are none");
  if (!input.isImage() && input.contents != Contents::kContours)
    filesOfInput(input);  // says so where the file is missing, which helps more
  if (input.contents == Contents::kContours) {
    refusePlacing(input);
    return reconstructContours(job, stillInput(input), events);
  }
  if (!input.isImage())
    throw InputError(
        job.input +
        " is neither a label map (.nii .nii.gz .nrrd .nhdr .mha .mhd, name.####.png|tif) nor contours (.csl, "
        "a DICOM RT structure set) nor EXR slices (name.####.exr, name.exr)");
  checkInputExists(job.input);
  reconstructImage(job, events);
}

}  // namespace slicemorph
