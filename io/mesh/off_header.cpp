#include "io/mesh/off_header.h"

#include "io/mesh/mesh_text.h"

namespace slicemorph {
namespace {

/// `text` without blank lines, blanks and comments at its beginning.
std::string_view pastComments(std::string_view text) {
  while (!text.empty()) {
    while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
    if (text.empty() || text.front() != '#') break;
    Text lines(text);
    lines.line();
    text = lines.rest();
  }
  return text;
}

bool take(std::string_view& text, std::string_view word) {
  if (text.substr(0, word.size()) != word) return false;
  text.remove_prefix(word.size());
  return true;
}

}  // namespace

OffHeader readOffHeader(const std::string& path, std::string_view bytes) {
  OffHeader header;
  std::string_view text = pastComments(bytes);
  bool manyDimensions = false;
  while (take(text, "ST")  ? (header.texture = true)
         : take(text, "C") ? (header.colors = true)
         : take(text, "N") ? (header.normals = true)
         : take(text, "4") ? (header.weighted = true)
                           : take(text, "n") && (manyDimensions = true)) {
  }
  if (!take(text, "OFF") && !take(text, "off")) {
    const std::string_view whole = pastComments(bytes);
    std::uint64_t count = 0;
    if (!parse(Text(whole).token(), count)) refuse(path, "is no OFF file: it does not begin with 'OFF'");
    header = {};
    header.rest = whole;
    return header;
  }
  if (manyDimensions) refuse(path, "is an nOFF file, whose points have any dimension; use three dimensions");
  Text lines(text);
  const std::string_view first = lines.line();
  if (lowerCase(Text(first).token()) == "binary") {
    header.binary = true;
    header.rest = lines.rest();
  } else {
    header.rest = pastComments(text);
  }
  return header;
}

}  // namespace slicemorph
