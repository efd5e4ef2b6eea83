#include "tools/report/page_template.h"

#include <cstdint>

// The page without its data, linked into the program; tools/dev/make_viewer.sh makes it.
extern "C" const char slicemorphPage[], slicemorphPageEnd[];
__asm__(
    ".section .rodata\n"
    "slicemorphPage:\n"
    ".incbin \"" SLICEMORPH_PAGE
    "\"\n"
    "slicemorphPageEnd:\n"
    ".byte 0\n"
    ".previous\n");

namespace slicemorph {

std::string base64Of(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() * 4 / 3 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

std::string pageData(const std::string& id, const std::string& type, const std::string& text) {
  return "<script id=\"" + id + "\" type=\"" + type + "\">" + text + "</script>\n";
}

std::string pageData(const std::string& id, const nlohmann::ordered_json& json) {
  std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  for (size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) text.insert(at + 1, 1, '\\');
  for (size_t at = 0; (at = text.find("<!", at)) != std::string::npos; at += 7)
    text.replace(at, 1, "\\u003c");
  return pageData(id, "application/json", text);
}

std::string pageWith(const std::string& data) {
  const std::string_view page(slicemorphPage, size_t(slicemorphPageEnd - slicemorphPage)),
      mark = "<!--DATA-->";
  const size_t at = page.find(mark);
  return std::string(page.substr(0, at)) + data + std::string(page.substr(at + mark.size()));
}

}  // namespace slicemorph
