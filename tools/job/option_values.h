#pragma once

#include "slicemorph/conventions.h"

#include <string>
#include <vector>

/// Formats, parses and checks values of options and paths. The functions that parse or check throw InputError
/// naming the option, its value and what would be right.
namespace slicemorph {

/// A number with at most `digits` significant digits, without trailing zeros.
std::string formatNumber(double value, int digits = 6);
/// The shortest text that is read back as the same number.
std::string formatExactly(double value);

/// The parts of a text between marks.
std::vector<std::string> parted(const std::string& text, char mark);
/// Numbers separated by commas.
std::vector<double> parseNumbers(const std::string& option, const std::string& text);
/// Names separated by commas, one at least.
std::vector<std::string> parseNames(const std::string& option, const std::string& text);
/// `x`, `y`, `z` or three numbers that are not all zero.
Vec3d parseDirection(const std::string& option, const std::string& text);
/// A whole number within limits.
void checkRange(const std::string& option, long value, long low, long high);
void checkPositive(const std::string& option, double value);

/// Throws IoError where an input (also `file.vdb:grid`) is missing or empty; to be called before long work.
void checkInputExists(const std::string& input);
/// Throws IoError where the folder of an output is missing or cannot be written to, or the path is a folder.
void checkOutputPath(const std::string& path);
/// Throws InputError where the path's extension is none of those listed (lower case, with the dot).
void checkExtension(const std::string& path, const std::vector<std::string>& extensions);

}  // namespace slicemorph
