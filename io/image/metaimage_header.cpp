#include "io/image/metaimage_header.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

namespace slicemorph {
namespace {

constexpr const char *kSlope = "ElementToIntensityFunctionSlope",
                     *kOffset = "ElementToIntensityFunctionOffset";

/// Of sizes and channels, as ITK keeps them.
constexpr std::int64_t kMostOfASize = (1LL << 31) - 1;

std::string withoutSpaceAtTheEnds(std::string text) {
  text.erase(0, std::min(text.find_first_not_of(" \t"), text.size()));
  text.erase(text.find_last_not_of(" \t\r") + 1);
  return text;
}

}  // namespace

void MetaHeader::check(const std::string& path) const {
  for (const char* key : {"NDims", "DimSize", "ElementType"})
    if (!has(key)) throw IoError(path, std::string("its MetaImage header has no ") + key);
  // The library does not end with less than one dimension.
  const std::int64_t dimensions = whole(path, "NDims", 0, 1, 10);
  std::istringstream sizes(text("DimSize"));
  for (std::int64_t d = 0; d < dimensions; ++d) {
    std::int64_t size = 0;
    if (!(sizes >> size) || size < 1 || size > kMostOfASize)
      throw IoError(path, "its DimSize '" + text("DimSize") + "' is not " + text("NDims") + " sizes");
  }
  whole(path, "ElementNumberOfChannels", 1, 1, kMostOfASize);
  skipped(path);
  scale(path);
}

std::int64_t MetaHeader::whole(const std::string& path, const char* key, std::int64_t otherwise,
                               std::int64_t least, std::int64_t most) const {
  if (!has(key)) return otherwise;
  const std::string given = text(key);
  char* end = nullptr;
  const std::int64_t number = std::strtoll(given.c_str(), &end, 10);
  if (given.empty() || *end || number < least || number > most)
    throw IoError(path, std::string("its ") + key + " '" + given + "' is no whole number from " +
                            std::to_string(least) + " to " + std::to_string(most));
  return number;
}

std::int64_t MetaHeader::skipped(const std::string& path) const {
  const std::int64_t bytes = whole(path, "HeaderSize", 0, -1, std::int64_t(1) << 62);
  if (bytes < 0 && (is("CompressedData") || !is("BinaryData")))
    throw IoError(path, "its HeaderSize -1 needs data that are neither compressed nor text");
  return bytes;
}

bool MetaHeader::is(const char* key) const {
  const std::string said = text(key);
  return !said.empty() && (said[0] == 'T' || said[0] == 't' || said[0] == '1');
}

bool MetaHeader::isLocal() const {
  const std::string name = text("ElementDataFile");
  return name == "LOCAL" || name == "Local" || name == "local";
}

std::pair<double, double> MetaHeader::scale(const std::string& path) const {
  const auto number = [&](const char* key, double otherwise) {
    if (!has(key)) return otherwise;
    char* end = nullptr;
    const double number = std::strtod(value.at(key).c_str(), &end);
    if (end == value.at(key).c_str() || !std::isfinite(number))
      throw IoError(path, std::string("its ") + key + " '" + value.at(key) + "' is no number");
    return number;
  };
  const double slope = number(kSlope, 1), offset = number(kOffset, 0);
  if (slope == 0) throw IoError(path, std::string("its ") + kSlope + " is 0, which leaves no values");
  return {slope, offset};
}

Note MetaHeader::scaleNote() const {
  return {"image.rescaled", Severity::kNote, "",
          "its values are stored as others: multiplied by " + (has(kSlope) ? text(kSlope) : "1") + ", plus " +
              (has(kOffset) ? text(kOffset) : "0") + " (" + kSlope + ", " + kOffset + ")"};
}

MetaHeader metaHeaderOf(const std::string& path) {
  MetaHeader header;
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    const size_t mark = line.find('=');
    if (mark == std::string::npos) continue;
    const std::string key = withoutSpaceAtTheEnds(line.substr(0, mark));
    header.value[key] = withoutSpaceAtTheEnds(line.substr(mark + 1));
    if (key == "ElementDataFile") break;
  }
  if (!header.has("ElementDataFile"))
    throw IoError(path, "is no MetaImage file, or its header is damaged: it has no ElementDataFile");
  header.bytes = std::uint64_t(file.tellg());
  if (header.text("ElementDataFile").compare(0, 4, "LIST") == 0)
    header.list.assign(std::istreambuf_iterator<char>(file), {});
  return header;
}

}  // namespace slicemorph
