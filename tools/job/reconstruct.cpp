#include "tools/job/reconstruct.h"

#include "io/paths.h"
#include "slicemorph/io/input.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct_contours.h"
#include "tools/job/reconstruct_labels.h"
#include "tools/job/reconstruct_slices.h"

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

}  // namespace

void reconstruct(const ReconstructJob& job, JobEvents& events) {
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
