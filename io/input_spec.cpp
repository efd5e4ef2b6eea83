#include "slicemorph/io/input_spec.h"

#include "io/format.h"
#include "io/paths.h"
#include "io/sequence.h"
#include "slicemorph/errors.h"

#include <algorithm>
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

/// Splits the text into path and selection.
void splitSelection(InputSpec& spec) {
  if (isThere(spec.text)) return;
  size_t colon = colonBehindImage(spec.text);
  const bool grid = colon == std::string::npos;
  if (grid) colon = colonBehindVdb(spec.text);
  if (colon == std::string::npos) return;
  spec.path = spec.text.substr(0, colon);
  spec.selection = spec.text.substr(colon + 1);
  if (spec.selection.empty())
    throw InputError(spec.text,
                     grid ? "no grid is named after the colon" : "nothing is named after the colon");
}

}  // namespace

InputSpec parseInput(const std::string& text) {
  InputSpec spec;
  spec.text = spec.path = text;
  splitSelection(spec);
  spec.isSequence = isNumbered(spec.path);
  spec.format = formatToRead(spec.path);
  if (spec.format) spec.contents = spec.format->contents;
  return spec;
}

std::vector<InputFrame> framesOf(const InputSpec& input) {
  std::vector<InputFrame> frames;
  for (const SequenceFile& file : findSequence(input.path)) {
    InputSpec one = input;
    one.path = file.path;
    one.text = input.selection.empty() ? file.path : file.path + ":" + input.selection;
    one.isSequence = false;
    frames.push_back({file.number, std::move(one)});
  }
  return frames;
}

std::vector<std::string> filesOfInput(const InputSpec& input) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  std::error_code error;
  if (input.isSequence) {
    for (const SequenceFile& file : findSequence(input.path)) files.push_back(file.path);
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
