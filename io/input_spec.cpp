#include "slicemorph/io/input_spec.h"

#include "io/braces.h"
#include "io/format.h"
#include "io/paths.h"
#include "io/sequence.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace slicemorph {
namespace {

bool isThere(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

/// Position of the colon between file and grid. Both names may hold colons, so it is that of the first
/// `.vdb:` up to which the text names an existing file, else that of the first `.vdb:`.
size_t colonBehindVdb(const std::string& text) {
  const std::string mark = ".vdb:", lower = lowered(text);
  const size_t first = lower.find(mark);
  for (size_t at = first; at != std::string::npos; at = lower.find(mark, at + 1))
    if (isThere(text.substr(0, at + mark.size() - 1))) return at + mark.size() - 1;
  return first == std::string::npos ? first : first + mark.size() - 1;
}

/// Position of the last colon, if the text before it names an image or contours.
size_t colonBehindImage(const std::string& text) {
  const size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return std::string::npos;
  const Format* format = formatToRead(text.substr(0, colon));
  const bool fits =
      format && (format->contents == Contents::kImage || format->contents == Contents::kContours);
  return fits ? colon : std::string::npos;
}

[[noreturn]] void refusePlacing(const InputSpec& spec, const std::string& what) {
  throw InputError(spec.text,
                   what +
                       "; in braces stand scale=FACTOR, upright=x|y|z and fit=none|size|box, with commas "
                       "between them, as {scale=0.001,upright=z}");
}

double scaleOf(const InputSpec& spec, const std::string& value) {
  char* end = nullptr;
  const double scale = std::strtod(value.c_str(), &end);
  if (value.empty() || *end || !(scale > 0) || !std::isfinite(scale))
    refusePlacing(spec, "scale=" + value + " is no number above 0");
  return scale;
}

/// Takes what stands in braces off the end of the path.
void splitPlacing(InputSpec& spec) {
  const BracedText split = splitBraces(spec.path);
  if (split.braces.empty()) return;
  for (const auto& [item, key, value] : split.items) {
    if (key == "scale")
      spec.placing.scale = scaleOf(spec, value);
    else if (key == "upright" && (value == "x" || value == "y" || value == "z"))
      spec.placing.upright = value[0];
    else if (key == "fit" && (value == "none" || value == "size" || value == "box"))
      spec.placing.fit = value;
    else
      refusePlacing(spec, "'" + item + "' is not understood");
  }
  if (!spec.placing.given()) refusePlacing(spec, "nothing stands in the braces");
  spec.placing.text = split.braces;
  spec.path = split.name;
}

/// Whether a path is a file that may hold several images.
bool holdsVolumes(const std::string& path) {
  const Format* format = formatToRead(path);
  return format && format->contents == Contents::kImage && format->openSlices && isThere(path);
}

/// Takes `@10-40x2` out of the path of a sequence, where it may stand before or behind the name of a grid, or off the
/// end of that of an image.
void splitRange(InputSpec& spec) {
  const size_t at = spec.path.rfind('@'), hash = spec.path.rfind('#');
  if (at == std::string::npos) return;
  if ((hash == std::string::npos || at < hash) && !holdsVolumes(spec.path.substr(0, at))) return;
  const size_t end = std::min(spec.path.find(':', at), spec.path.size());
  const std::string before = spec.path.substr(0, at), range = spec.path.substr(at + 1, end - at - 1);
  // Names of files may hold this mark, too.
  if (range.find_first_of("./") != std::string::npos) return;
  // Names of files have no negative numbers.
  const std::vector<int> numbers = numbersOfRange(range);
  if (numbers.empty() || numbers.front() < 0)
    throw InputError(spec.text, "'@" + range +
                                    "' is no range of frames; for example @10-40, each second of these "
                                    "@10-40x2, or @1,5,10-20");
  spec.path = before + spec.path.substr(end);
  spec.range = range;
}

/// Splits the path into path and selection.
void splitSelection(InputSpec& spec) {
  const std::string text = spec.path;
  if (isThere(text)) return;
  size_t colon = colonBehindImage(text);
  const bool grid = colon == std::string::npos;
  if (grid) colon = colonBehindVdb(text);
  if (colon == std::string::npos) return;
  spec.path = text.substr(0, colon);
  spec.selection = text.substr(colon + 1);
  if (spec.selection.empty())
    throw InputError(spec.text,
                     grid ? "no grid is named after the colon" : "nothing is named after the colon");
}

bool isDicom(const InputSpec& spec) { return spec.format && spec.format->name == "dicom"; }

/// Takes several volumes, `2@1-12`, off the selection of a DICOM series; one, `2@3`, remains there.
void splitVolumes(InputSpec& spec) {
  const size_t at = spec.selection.rfind('@');
  if (!isDicom(spec) || at == std::string::npos) return;
  const std::string range = spec.selection.substr(at + 1);
  if (numbersOfRange(range).size() < 2) return;
  spec.selection.resize(at);
  spec.range = range;
}

}  // namespace

InputSpec parseInput(const std::string& text) {
  InputSpec spec;
  spec.text = spec.path = text;
  if (!isThere(text)) splitPlacing(spec);
  if (!isThere(spec.path)) splitRange(spec);
  splitSelection(spec);
  spec.isSequence = isNumbered(spec.path);
  spec.format = formatToRead(spec.path);
  if (spec.format) spec.contents = spec.format->contents;
  splitVolumes(spec);
  return spec;
}

std::vector<InputFrame> framesOf(const InputSpec& input) {
  std::vector<InputFrame> frames;
  if (input.isImage()) {
    if (!isDicom(input) && !input.range.empty() && !input.selection.empty())
      throw InputError(input.text,
                       "'@" + input.range + "' and ':" + input.selection +
                           "' each choose volumes; give one of them (each second volume is @0-8x2)");
    const std::string series = isDicom(input) ? input.selection + "@" : "";
    for (const int volume : numbersOfRange(input.range)) {
      InputSpec one = input;
      one.selection = series + std::to_string(volume);
      one.text = input.path + ":" + one.selection + input.placing.text;
      one.range.clear();
      frames.push_back({volume, std::move(one)});
    }
    return frames;
  }
  for (const SequenceFile& file : findSequence(input.path, input.range)) {
    InputSpec one = input;
    one.path = file.path;
    one.text = input.selection.empty() ? file.path : file.path + ":" + input.selection;
    one.text += input.placing.text;
    one.range.clear();
    one.isSequence = false;
    frames.push_back({file.number, std::move(one)});
  }
  return frames;
}

InputSpec stillInput(const InputSpec& input) {
  if (!input.isMoving()) return input;
  const std::vector<InputFrame> frames = framesOf(input);
  if (frames.size() == 1) return frames[0].input;
  throw InputError(input.text, "is a sequence of " + std::to_string(frames.size()) +
                                   (input.isImage() ? " volumes" : " files") +
                                   ", and one is needed: " + frames[0].input.text + " for example");
}

std::vector<std::string> filesOfInput(const InputSpec& input) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  std::error_code error;
  if (input.isSequence) {
    for (const SequenceFile& file : findSequence(input.path, input.range)) files.push_back(file.path);
  } else if (input.isImage() && fs::is_directory(input.path, error)) {
    for (const auto& entry : fs::directory_iterator(input.path, error))
      if (entry.is_regular_file()) files.push_back(entry.path().string());
    if (error || files.empty()) throw IoError(input.path, "no files in this folder");
    std::sort(files.begin(), files.end());
    return files;
  } else {
    files.push_back(input.path);
  }
  for (const std::string& file : files) sizeOfInput(file);
  return files;
}

}  // namespace slicemorph
