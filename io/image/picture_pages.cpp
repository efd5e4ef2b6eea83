#include "io/image/picture_pages.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace slicemorph {
namespace {

void copyText(const std::string& text, char (&to)[32]) { std::strncpy(to, text.c_str(), sizeof to - 1); }

/// Of a file, and so of slices, channels and times alike; a TIFF file has far fewer.
constexpr int kMostPages = 10000000;

int countOf(const std::map<std::string, std::string>& values, const char* key) {
  const auto at = values.find(key);
  if (at == values.end()) return 0;
  const long n = std::strtol(at->second.c_str(), nullptr, 10);
  if (n < 1 || n > kMostPages)
    throw std::runtime_error(std::string("its ") + key + " '" + at->second + "' makes no sense");
  return int(n);
}

/// Throws where pages are too many to be numbered.
void checkCount(const SlicemorphPages& pages) {
  const double all = double(pages.slices) * pages.channels * pages.times;
  if (all > kMostPages)
    throw std::runtime_error("its description (" + std::string(pages.program) + ") tells of " +
                             std::to_string(pages.slices) + " slices x " + std::to_string(pages.channels) +
                             " channels x " + std::to_string(pages.times) + " times, which makes no sense");
}

double numberOf(const std::map<std::string, std::string>& values, const char* key) {
  const auto at = values.find(key);
  const double v = at == values.end() ? 0 : std::strtod(at->second.c_str(), nullptr);
  return std::isfinite(v) ? v : 0;
}

/// Pages of ImageJ: channels follow each other first, then slices, then times.
SlicemorphPages pagesOfImageJ(const std::string& description, const double resolution[2]) {
  std::map<std::string, std::string> values;
  std::istringstream lines(description);
  for (std::string line; std::getline(lines, line);) {
    const size_t mark = line.find('=');
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (mark != std::string::npos && mark < line.size()) values[line.substr(0, mark)] = line.substr(mark + 1);
  }
  SlicemorphPages pages{};
  copyText("ImageJ", pages.program);
  const int images = std::max(1, countOf(values, "images"));
  pages.channels = std::max(1, countOf(values, "channels")),
  pages.times = std::max(1, countOf(values, "frames"));
  pages.slices = countOf(values, "slices");
  if (pages.slices == 0)
    pages.slices = int(std::max<std::int64_t>(1, images / (std::int64_t(pages.channels) * pages.times)));
  if (double(pages.slices) * pages.channels * pages.times != images)
    throw std::runtime_error("its ImageJ description has " + std::to_string(images) + " images, but " +
                             std::to_string(pages.channels) + " channels x " + std::to_string(pages.slices) +
                             " slices x " + std::to_string(pages.times) + " frames");
  pages.channelStride = 1, pages.sliceStride = pages.channels,
  pages.timeStride = pages.channels * pages.slices;
  const std::string unit = values.count("unit") ? values["unit"] : "";
  if (unit.empty() || unit == "pixel" || unit == "pixels") return pages;
  copyText(unit, pages.unit);
  for (int d = 0; d < 2; ++d) pages.spacing[d] = resolution[d] > 0 ? 1 / resolution[d] : 0;
  // ImageJ leaves out what is 1.
  pages.spacing[2] = values.count("spacing") ? std::abs(numberOf(values, "spacing")) : 1;
  const char* const origins[] = {"xorigin", "yorigin", "zorigin"};
  for (int d = 0; d < 3; ++d) pages.origin[d] = 0 - numberOf(values, origins[d]);
  return pages;
}

/// Pages of OME-TIFF, by the attributes of its first image.
SlicemorphPages pagesOfOme(const std::string& description) {
  const size_t begin = description.find("<Pixels"), end = description.find('>', begin);
  if (end == std::string::npos) throw std::runtime_error("its OME description has no Pixels");
  if (description.find("<Pixels", end) != std::string::npos)
    throw std::runtime_error("its OME description has several images; save one alone");
  const std::string text = description.substr(begin, end - begin);
  std::map<std::string, std::string> values;
  const std::regex attribute("([A-Za-z]+)\\s*=\\s*[\"']([^\"']*)[\"']");
  for (std::sregex_iterator at(text.begin(), text.end(), attribute), none; at != none; ++at)
    values[(*at)[1]] = (*at)[2];
  SlicemorphPages pages{};
  copyText("OME", pages.program);
  pages.slices = std::max(1, countOf(values, "SizeZ"));
  pages.channels = std::max(1, countOf(values, "SizeC")), pages.times = std::max(1, countOf(values, "SizeT"));
  checkCount(pages);
  int stride = 1;
  const std::string order = values.count("DimensionOrder") ? values["DimensionOrder"] : "XYZCT",
                    axes = order.substr(std::min<size_t>(2, order.size())), all = "ZCT";
  if (!std::is_permutation(axes.begin(), axes.end(), all.begin(), all.end()))
    throw std::runtime_error("its DimensionOrder '" + order + "' is none of OME, as XYZCT");
  for (const char axis : axes) {
    if (axis == 'Z') pages.sliceStride = stride, stride *= pages.slices;
    if (axis == 'C') pages.channelStride = stride, stride *= pages.channels;
    if (axis == 'T') pages.timeStride = stride, stride *= pages.times;
  }
  const char* const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
  std::string unit;
  for (int d = 0; d < 3; ++d) {
    pages.spacing[d] = numberOf(values, sizes[d]);
    const std::string key = std::string(sizes[d]) + "Unit", own = values.count(key) ? values[key] : "um";
    if (d > 0 && own != unit) throw std::runtime_error("its OME description has several units of length");
    unit = own;
  }
  copyText(unit, pages.unit);
  return pages;
}

/// Pages of Python's tifffile, whose last two axes (before the colours of a pixel) are the picture's.
SlicemorphPages pagesOfShape(const std::string& description) {
  SlicemorphPages pages{};
  std::smatch found;
  if (!std::regex_search(description, found, std::regex("\"shape\": *\\[([0-9, ]+)\\]"))) return pages;
  if (description.find("\"truncated\": true") == std::string::npos) return pages;
  copyText("tifffile", pages.program);
  std::istringstream numbers(found[1]);
  std::vector<int> shape;
  for (std::string n; std::getline(numbers, n, ',');) shape.push_back(std::atoi(n.c_str()));
  double planes = 1;
  for (size_t i = 0; i + 2 < shape.size(); ++i) planes *= shape[i];
  if (!(planes >= 1 && planes <= kMostPages)) throw std::runtime_error("its shape makes no sense");
  pages.slices = int(planes), pages.channels = pages.times = 1;
  pages.sliceStride = 1, pages.channelStride = pages.timeStride = int(planes);
  return pages;
}

}  // namespace

SlicemorphPages pagesFromDescription(const std::string& description, const double resolution[2]) {
  if (description.compare(0, 7, "ImageJ=") == 0) return pagesOfImageJ(description, resolution);
  if (description.find("<OME") != std::string::npos && description.find("<Pixels") != std::string::npos)
    return pagesOfOme(description);
  if (description.compare(0, 1, "{") == 0) return pagesOfShape(description);
  return {};
}

}  // namespace slicemorph
