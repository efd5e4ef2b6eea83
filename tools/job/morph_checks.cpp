#include "tools/job/morph_checks.h"

#include "io/sequence.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/formats.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/image_lattice.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

bool onlySurface(const MorphSettings& s) {
  return std::all_of(s.grids.begin(), s.grids.end(), [](const std::string& g) { return g == "surface"; });
}

/// An option as it was given: `--ease in`, `[[region]]`.
std::string saidOption(const OptionRow& row, const OptionSet& options) {
  if (!row.field) return "[[" + row.name + "]]";
  const std::vector<std::string> texts = options.texts(row.name);
  return spelledName(row) + (texts.empty() ? "" : " " + texts.back());
}

/// Whether an option was given another value than its default.
bool isChanged(const OptionRow& row, const OptionSet& options) {
  const std::vector<std::string> texts = options.texts(row.name);
  return options.given(row.name) && (texts.empty() || texts.back() != defaultOf(row));
}

void checkMethods(const MorphSettings& s, const OptionSet& options) {
  for (const OptionRow* row : options.rows())
    if (row->needs && !(s.can().*row->needs) && isChanged(*row, options))
      options.refuse(row->name, saidOption(*row, options) + " is for " + methodsThat(row->needs) +
                                    ", not for " + s.method);
}

void checkTarget(const OptionSet& options, OptionTarget target, const std::string& what) {
  const OptionSet::Pairs given = options.givenFor(target);
  if (!given.empty()) options.refuse(given[0].first, "--" + given[0].first + what);
}

/// --grids needs an output and a method that have grids.
void checkGrids(const MorphSettings& s, const OptionSet& options) {
  if (onlySurface(s) || isImageOutput(s.output)) return;
  const std::string said = "--grids " + options.values().grids + ": ";
  if (!s.holdsGrids()) options.refuse("grids", said + s.output + " holds the surface alone");
  if (!s.can().grids) options.refuse("grids", said + "this --method makes the surface alone");
}

/// Pictures and slices need a shape or values to show.
void checkFrameImages(const MorphSettings& s, const OptionSet& options) {
  if (s.exrContent == ExrContent::kSlices && s.exrSlices.spine && !s.can().surface)
    options.refuse("exr-spine",
                   "--exr-spine: --method " + s.method + " makes no shape whose spine slices could follow");
  if (!s.toPictures()) return;
  if (s.allImages() && !s.can().surface)
    options.refuse("method", "--method " + s.method +
                                 " of images makes no surface that could be drawn; the output can be "
                                 "--exr slices or an image");
  if (options.given("velocity"))
    options.refuse("velocity", "--velocity " + options.values().velocity +
                                   " is for outputs that hold grids; " + s.output + " is a picture");
}

/// Outputs that are no images.
std::string shapesAndPictures() {
  return writableList(Contents::kGrids) + " " + writableList(Contents::kMesh) + " .exr .png";
}

/// In-between images need images as inputs.
void checkImages(const MorphSettings& s, const OptionSet& options) {
  const bool images = s.allImages(), imageOutput = isImageOutput(s.output);
  if (imageOutput && !images) {
    size_t other = 0;
    while (s.input(other).isImage()) ++other;
    options.refuse("output", "-o " + s.output + ": in-between images need images on all sides, and " +
                                 s.inputs[other] + " is none; the output can be " + shapesAndPictures());
  }
  if (!s.plan.regions.empty() && images && (imageOutput || s.holdsGrids()) &&
      s.grids != std::vector<std::string>{"surface"})
    options.refuse("region",
                   "[[region]] is for shapes and grids, not for in-between images: make a mesh, or a file of "
                   "grids (" +
                       writableList(Contents::kGrids) + ") with --grids surface");
  if (!s.like.empty() && !imageOutput && !(images && s.holdsGrids()))
    options.refuse("like",
                   "--like " + s.like + " is for in-between images; the output " + s.output + " is none");
}

/// A surface needs a method that makes surfaces, an image one that makes images.
void checkMethodOutput(const MorphSettings& s, const OptionSet& options) {
  const bool imageOutput = isImageOutput(s.output);
  if (!s.can().surface && !s.holdsGrids() && !imageOutput)
    options.refuse("method",
                   "--method " + s.method + " blends values and makes no surface; the output must be " +
                       writableList(Contents::kGrids, ", ") + ", .exr, .png or an image, not " + s.output);
  if (!s.can().images && imageOutput)
    options.refuse("method", "--method " + s.method + " makes surfaces, no images; the output must be " +
                                 shapesAndPictures() + ", not " + s.output);
}

}  // namespace

size_t lengthOfInputs(const OptionSet& options) {
  size_t length = 1;
  if (options.values().printConfig) return length;
  for (size_t k = 0; k < options.values().inputs.size(); ++k)
    if (const std::string& input = options.values().inputs[k];
        !heldAt(options.values().held, k) && isMovingInput(input))
      length = std::max(length, options.about("inputs", [&] { return framesOf(parseInput(input)).size(); }));
  return length;
}

void checkEssentials(const OptionSet& options) {
  const JobOptions& given = options.values();
  if (given.inputs.size() < 2)
    options.refuse("inputs", "morph needs at least two inputs, not " + std::to_string(given.inputs.size()) +
                                 "; for example: slicemorph morph a.obj b.obj -o morph.####.vdb");
  if (given.output.empty()) options.refuse("output", "morph needs an output; for example: -o morph.####.vdb");
  options.checkExclusions();
}

void checkPurposes(const MorphSettings& s, const OptionSet& options) {
  checkMethods(s, options);
  if (!s.planFile.empty() && !s.sliceFolder.empty())
    options.refuse("dump-slices", "--dump-slices " + s.sliceFolder +
                                      ": a --plan holds no contours; draw them where it is planned anew");
  if (!s.planFile.empty() && OutputName(s.planFile).isSequence() != s.moving())
    options.refuse("plan",
                   "--plan " + s.planFile +
                       (s.moving() ? ": of inputs that are sequences each frame has a plan (name.####.plan)"
                                   : ": one plan serves all frames; give that file"));
  const bool slices = s.exrContent == ExrContent::kSlices;
  if (!s.toPictures())
    checkTarget(options, OptionTarget::kPictures,
                " is for pictures, .exr or .png, not for " + (s.toFrameImages() ? "--exr slices" : s.output));
  if (!s.toFrameImages() || !slices)
    checkTarget(options, OptionTarget::kExrSlices, " is for outputs that are .exr, with --exr slices");
  if (slices && OutputName(s.output).extension() != ".exr")
    options.refuse("exr", "--exr slices is for outputs that are .exr, not for " + s.output);
}

void checkOutputKind(const MorphSettings& s, const OptionSet& options) {
  checkFrameImages(s, options);
  checkGrids(s, options);
  if (s.frames.size() > 1 && !OutputName(s.output).isSequence() && !s.oneFile())
    options.refuse("output",
                   "-o " + s.output + " is one file for " + std::to_string(s.frames.size()) +
                       " frames; put #### where the frame number belongs (name.####.vdb), or ask for one "
                       "frame by --at T or --weights; a .glb or .usda holds all frames, and of images a .nii "
                       "or .nii.gz");
  checkImages(s, options);
  checkMethodOutput(s, options);
}

void checkMethodInputs(const MorphSettings& s, const OptionSet& options) {
  const std::string method = "--method " + s.method;
  const size_t most = s.can().mostInputs;
  if (!s.can().anyTime && lengthOfInputs(options) > 1)
    options.refuse("method", method + " takes no sequences, only still inputs");
  if (most > 0 && s.inputs.size() > most)
    options.refuse("method", method + " takes " + (most == 2 ? "two" : std::to_string(most)) +
                                 " inputs, not " + std::to_string(s.inputs.size()));
  if (!s.can().anyTime && (options.given("at") || options.given("weights") || s.frames.size() < 2))
    options.refuse("method",
                   method + " has no times or weights, only steps; ask for --frames N of at least 2");
}

void checkMorphFiles(const MorphSettings& s, const OptionSet& options) {
  options.about("output", [&] {
    s.toFrameImages() ? checkOutputPath(s.frames[0].path) : checkOutput(s.frames[0].path);
    if (!s.usdVolume.empty()) checkOutputPath(s.usdVolume);
  });
  for (const std::string& report : s.reports)
    options.about("report", [&] {
      checkExtension(report, {".json", ".csv", ".html"});
      checkOutputPath(report);
    });
  if (!s.sliceFolder.empty()) {
    const auto parent = std::filesystem::absolute(s.sliceFolder).lexically_normal();
    if (!std::filesystem::is_directory(parent))
      options.about("dump-slices", [&] { checkOutputPath(parent.string()); });
  }
  for (size_t k = 0; k < s.inputs.size(); ++k)
    if (!heldAt(s.held, k)) options.about("inputs", [&] { checkInputExists(s.inputs[k]); });
  if (!s.like.empty()) options.about("like", [&] { checkInputExists(s.like); });
}

}  // namespace slicemorph
