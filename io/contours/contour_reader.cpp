#include "io/contours/contour_reader.h"

#include "io/contours/csl_reader.h"
#include "io/contours/rtstruct_reader.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace slicemorph {

namespace {

bool isCsl(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".csl";
}

}  // namespace

bool isContourFile(const std::string& path) { return isCsl(path) || isRtStructureSet(path); }

ContourFile readContours(const std::string& path) {
  return isCsl(path) ? readCsl(path) : readRtStructureSet(path);
}

}  // namespace slicemorph
