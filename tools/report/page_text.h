#pragma once

#include <string>

/// Texts of pages and tables.
namespace slicemorph {

/// A text as HTML and SVG have it, also between quotation marks.
std::string escapedForPage(const std::string& text);

/// A number with at most so many significant digits, without trailing zeros.
std::string shownNumber(double value, int digits = 6);

/// Colours that lines and shapes are told apart by; the n-th one, after the last the first again.
constexpr size_t kSeriesColours = 8;
std::string seriesColour(size_t n);

}  // namespace slicemorph
