#include "io/mesh/ply_check.h"

#include "io/mesh/mesh_text.h"

#include <algorithm>
#include <cstring>

namespace slicemorph {
namespace {

/// Some writers count with floats. What is no count is more than any file holds.
std::uint64_t plyRealLength(std::string_view bytes, bool bigEndian) {
  char raw[8] = {};
  std::memcpy(raw, bytes.data(), bytes.size());
  if (bigEndian) std::reverse(raw, raw + bytes.size());
  float single = 0;
  double length = 0;
  std::memcpy(&single, raw, sizeof single), std::memcpy(&length, raw, sizeof length);
  if (bytes.size() == 4) length = double(single);
  return length >= 0 && length < 1e12 ? std::uint64_t(length) : ~std::uint64_t(0);
}

std::uint64_t plyListLength(std::string_view bytes, const PlyType& type, bool bigEndian) {
  if (type.real) return plyRealLength(bytes, bigEndian);
  std::uint64_t value = 0;
  for (size_t i = 0; i < bytes.size(); ++i) {
    value = value << 8 | std::uint8_t(bytes[bigEndian ? i : bytes.size() - 1 - i]);
  }
  return value;
}

/// False where the body ends inside this element. `at`: byte offset of the element, moved to the next one.
bool skipBinary(std::string_view bytes, const PlyElement& element, bool bigEndian, std::uint64_t& at) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t items = 1;
      if (property.isList()) {
        if (at + std::uint64_t(property.count.size) > bytes.size()) return false;
        items = plyListLength(bytes.substr(at, size_t(property.count.size)), property.count, bigEndian);
        at += std::uint64_t(property.count.size);
        if (items > bytes.size()) return false;
      }
      at += items * std::uint64_t(property.type.size);
      if (at > bytes.size()) return false;
    }
  }
  return true;
}

bool skipText(Text& text, const PlyElement& element) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t items = 1;
      if (property.isList() && !parse(text.token(), items)) return false;
      for (std::uint64_t k = 0; k < items; ++k) {
        if (text.token().empty()) return false;
      }
    }
  }
  return true;
}

}  // namespace

void checkPlyBody(const std::string& path, std::string_view bytes, const PlyHeader& header) {
  Text body(bytes.substr(header.size));
  std::uint64_t at = header.size;
  for (const PlyElement& element : header.elements) {
    const bool whole =
        header.text ? skipText(body, element) : skipBinary(bytes, element, header.bigEndian, at);
    if (!whole) {
      refuseTruncated(path, "the header says " + std::to_string(element.count) + " elements '" +
                                element.name + "', the file ends before the last of them");
    }
  }
}

}  // namespace slicemorph
