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
  char* end = nullptr;
  const std::string given = text("NDims");
  const long dimensions = std::strtol(given.c_str(), &end, 10);
  if (*end || dimensions < 1 || dimensions > 10)
    throw IoError(path, "its NDims is '" + given + "'; there are 1 to 10 dimensions");
  std::istringstream sizes(text("DimSize"));
  for (long d = 0; d < dimensions; ++d) {
    long long size = 0;
    if (!(sizes >> size) || size < 1 || size > (1LL << 31) - 1)
      throw IoError(path, "its DimSize '" + text("DimSize") + "' is not " + given + " sizes");
  }
  scale(path);
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
