#include "tools/report/page_text.h"

#include <cstdio>

namespace slicemorph {
namespace {

/// Six colours of Okabe and Ito's palette for colour-blind readers, and two more.
constexpr const char* kColours[kSeriesColours] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                  "#e69f00", "#56b4e9", "#7b4ab8", "#8c6d31"};

}  // namespace

std::string escapedForPage(const std::string& text) {
  std::string escaped;
  for (const char c : text)
    escaped += c == '&'   ? "&amp;"
               : c == '<' ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '"' ? "&quot;"
                          : std::string(1, c);
  return escaped;
}

std::string shownNumber(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string seriesColour(size_t n) { return kColours[n % kSeriesColours]; }

}  // namespace slicemorph
