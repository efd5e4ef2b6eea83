#pragma once

#include "slicemorph/conventions.h"

#include <charconv>
#include <optional>
#include <string>
#include <utility>

/// Pieces of USD's text form (`.usda`), in the order and layout of OpenUSD's own `usdcat`.
namespace slicemorph {

/// How a stage lies in space and time. Points are written as they are in the world; the stage says what that means.
struct UsdaStage {
  double framesPerSecond = 24;  ///< time codes are numbers of frames
  double metres = 1;            ///< a world unit (`metersPerUnit`)
  bool zUp = false;             ///< the world's Z points up, not its Y (`upAxis`)
};

/// The first line and the stage's metadata. `frames`: numbers of the first and the last one; none: a still.
std::string usdaHeader(const UsdaStage& stage, const std::string& defaultPrim,
                       const std::optional<std::pair<int, int>>& frames);

/// A prim's name made of any text: letters, digits and `_`, not beginning with a digit, not empty.
std::string usdaName(const std::string& text);
/// The name of the prim that a file's content is: of the file without folder and extension.
std::string usdaNameOfFile(const std::string& path);
/// A text in quotes.
std::string usdaString(const std::string& text);
/// The name of a file beside the stage, as an asset: `@./x.vdb@`.
std::string usdaAsset(const std::string& file);

/// Appends a number in the shortest form that is read back as the same.
template <typename Number>
void addNumber(std::string& text, Number value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

/// Appends `(x, y, z)`.
template <typename Vector>
void addVector(std::string& text, const Vector& v) {
  text += '(', addNumber(text, v[0]), text += ", ", addNumber(text, v[1]), text += ", ";
  addNumber(text, v[2]), text += ')';
}

/// An extent of one box, `[(...), (...)]`; of an empty one `None`: it has no value then.
std::string usdaExtent(const openvdb::BBoxd& box);

}  // namespace slicemorph
