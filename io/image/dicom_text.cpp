#include "io/image/dicom_text.h"

#include <iconv.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace slicemorph {
namespace {

constexpr char kEscape = 0x1b;
constexpr const char* kNoSet = "none";  // a name that the library does not know

/// Converts by the C library; what is no letter of the set becomes a question mark. All is lost where the library does
/// not know the set.
DicomText convertedText(std::string text, const char* set) {
  const iconv_t converter = iconv_open("UTF-8", set);
  // The value that stands for failure, by POSIX.
  if (converter == iconv_t(-1)) {
    std::replace_if(
        text.begin(), text.end(),
        [](char c) { return static_cast<unsigned char>(c) >= 0x80 || c == kEscape; }, '?');
    return {text, true};
  }
  DicomText result;
  char* from = text.data();
  size_t left = text.size();
  while (left > 0) {
    char buffer[256];
    char* to = buffer;
    size_t space = sizeof buffer;
    const size_t failed = iconv(converter, &from, &left, &to, &space);
    result.text.append(buffer, to);
    if (failed != size_t(-1) || errno == E2BIG) continue;
    result.text += '?', result.lost = true;
    ++from, --left;
  }
  iconv_close(converter);
  return result;
}

/// The library's name of a set by its number in the ISO registry; empty: it is none of a single byte a letter.
std::string setOfNumber(const std::string& number) {
  constexpr std::pair<const char*, const char*> kSets[] = {
      {"100", "ISO-8859-1"}, {"101", "ISO-8859-2"}, {"109", "ISO-8859-3"},  {"110", "ISO-8859-4"},
      {"144", "ISO-8859-5"}, {"127", "ISO-8859-6"}, {"126", "ISO-8859-7"},  {"138", "ISO-8859-8"},
      {"148", "ISO-8859-9"}, {"166", "TIS-620"},    {"203", "ISO-8859-15"}, {"13", "JIS_X0201"},
      {"192", "UTF-8"},
  };
  for (const auto& [known, name] : kSets)
    if (number == known) return name;
  return "";
}

}  // namespace

DicomText utf8OfDicom(const std::string& text, const std::string& characters) {
  const bool escapes = text.find(kEscape) != std::string::npos;
  if (!escapes &&
      std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; }))
    return {text, false};
  if (escapes) {
    const bool japanese =
        characters.find("IR 87") != std::string::npos || characters.find("IR 159") != std::string::npos;
    return convertedText(text, japanese ? "ISO-2022-JP-2" : kNoSet);
  }
  std::string first = characters.substr(0, characters.find('\\'));
  first.erase(first.find_last_not_of(' ') + 1);
  if (first.empty() || first == "ISO_IR 6" || first == "ISO 2022 IR 6") {
    const DicomText same = convertedText(text, "UTF-8");
    return same.lost ? convertedText(text, "ISO-8859-1") : same;
  }
  if (first == "GB18030" || first == "GBK") return convertedText(text, first.c_str());
  const std::string set = setOfNumber(first.substr(first.find_last_of(' ') + 1));
  return convertedText(text, set.empty() ? kNoSet : set.c_str());
}

}  // namespace slicemorph
