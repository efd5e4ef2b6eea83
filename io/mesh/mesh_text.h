#pragma once

#include "slicemorph/errors.h"

#include <openvdb/math/Vec3.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

/// Helpers that the checks and readers of mesh files share.
namespace slicemorph {

[[noreturn]] inline void refuse(const std::string& path, const std::string& why) { throw IoError(path, why); }

[[noreturn]] inline void refuseTruncated(const std::string& path, const std::string& why) {
  refuse(path, "is truncated: " + why);
}

/// `face`, `point`: indices from 0; the message counts from 1.
[[noreturn]] inline void refuseCorner(const std::string& path, size_t face, std::uint64_t point,
                                      size_t points) {
  refuse(path, "face " + std::to_string(face + 1) + " refers to point " + std::to_string(point + 1) +
                   ", the mesh has " + std::to_string(points));
}

inline bool isFinite(const openvdb::math::Vec3s& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

/// `what`: names a point or a colour.
[[noreturn]] inline void refuseNotFinite(const std::string& path, const std::string& what,
                                         const openvdb::math::Vec3s& v) {
  std::ostringstream why;
  why << what << " is not finite (" << v[0] << ", " << v[1] << ", " << v[2] << ")";
  refuse(path, why.str());
}

inline bool isSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && isSpace(text.back())) text.remove_suffix(1);
  return text;
}

/// Tokens and lines of a text, front to back. Lines end with LF, CR LF or CR.
class Text {
 public:
  explicit Text(std::string_view bytes) : rest_(bytes) {}

  bool done() const { return rest_.empty(); }
  size_t lineNumber() const { return line_; }
  std::string_view rest() const { return rest_; }

  /// The next line without its end. Lines that a backslash continues are not joined.
  std::string_view line() {
    const size_t end = rest_.find_first_of("\r\n");
    const std::string_view result = rest_.substr(0, end);
    const bool pair = end != std::string_view::npos && rest_.substr(end, 2) == "\r\n";
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1 + pair);
    ++line_;
    return result;
  }

  /// The next token, over any number of lines; empty at the end.
  std::string_view token() {
    while (!rest_.empty() && isSpace(rest_.front())) rest_.remove_prefix(1);
    size_t size = 0;
    while (size < rest_.size() && !isSpace(rest_[size])) ++size;
    const std::string_view result = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return result;
  }

 private:
  std::string_view rest_;
  size_t line_ = 0;
};

inline std::string lowerCase(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return result;
}

/// The bytes of a text without a byte order mark; UTF-16, which some editors save, becomes UTF-8 in `memory`
/// (other characters than ASCII become '?': they are only in names and comments).
inline std::string_view plainText(std::string_view bytes, std::string& memory) {
  if (bytes.substr(0, 3) == "\xef\xbb\xbf") return bytes.substr(3);
  const std::string_view mark = bytes.substr(0, 2);
  if (mark != "\xff\xfe" && mark != "\xfe\xff") return bytes;
  const size_t low = mark[0] == '\xff' ? 0 : 1;  // place of a character's lower byte
  memory.clear();
  for (size_t i = 2; i + 1 < bytes.size(); i += 2)
    memory += bytes[i + 1 - low] == 0 && std::uint8_t(bytes[i + low]) < 128 ? bytes[i + low] : '?';
  return memory;
}

/// False where a token does not begin with a number. A number that is out of range counts as one but leaves
/// `value` unchanged, so initialise it.
template <typename Number>
bool parse(std::string_view token, Number& value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  const auto result = std::from_chars(token.data(), token.data() + token.size(), value);
  return result.ec == std::errc() || result.ec == std::errc::result_out_of_range;
}

/// Parses a token that is a number from end to end; none otherwise. Beyond the range of doubles it is infinite
/// or 0.
inline std::optional<double> wholeNumber(std::string_view token) {
  if (token.size() > 1 && token.front() == '+' && token[1] != '-') token.remove_prefix(1);
  double value = 0;
  const auto result = std::from_chars(token.data(), token.data() + token.size(), value);
  if (result.ptr != token.data() + token.size() || token.empty()) return std::nullopt;
  if (result.ec == std::errc()) return value;
  if (result.ec != std::errc::result_out_of_range) return std::nullopt;
  const bool small = lowerCase(token).find("e-") != std::string::npos;
  return small ? 0 : token.front() == '-' ? -HUGE_VAL : HUGE_VAL;
}

/// Parses a count of a header. Throws IoError where it is no number or more than a file of `fileSize`
/// bytes can hold.
inline std::uint64_t parseCount(const std::string& path, std::string_view token, const char* what,
                                size_t fileSize) {
  std::uint64_t count = 0;
  if (!parse(token, count)) refuse(path, "is damaged: its header gives no number of " + std::string(what));
  if (count > fileSize) {
    refuseTruncated(path, "the header says " + std::to_string(count) + " " + what + ", the file has only " +
                              std::to_string(fileSize) + " bytes");
  }
  return count;
}

}  // namespace slicemorph
