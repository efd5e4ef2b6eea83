#include "tools/report/dump_slices.h"

#include "io/atomic_file.h"
#include "slicemorph/errors.h"
#include "tools/report/page_text.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec2d;
using Contour = SlicePicture::Contour;

constexpr double kPanel = 360, kMargin = 20, kHeader = 28;  // pixels
constexpr const char* kGrey = "#999999";

/// Maps chart coordinates to pixels, with one scale for all slices, so that they can be flipped through.
struct View {
  Vec2d centre{0, 0};
  double scale = 1;

  Vec2d operator()(const Vec2d& p, size_t panel) const {
    return {kPanel * (double(panel) + 0.5) + (p[0] - centre[0]) * scale,
            kHeader + kPanel / 2 - (p[1] - centre[1]) * scale};
  }
};

View fitView(const std::vector<SlicePicture>& slices) {
  Vec2d low(1e300, 1e300), high(-1e300, -1e300);
  for (const auto& slice : slices)
    for (const auto& object : slice.objects)
      for (const auto& contour : object)
        for (const Vec2d& p : contour.points)
          for (int i = 0; i < 2; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
  const double size = std::max(high[0] - low[0], high[1] - low[1]);
  if (!(size > 0)) return {};
  return {(low + high) / 2, (kPanel - 2 * kMargin) / size};
}

Vec2d centroid(const Contour& contour) {
  Vec2d sum(0, 0);
  for (const Vec2d& p : contour.points) sum += p;
  return sum / double(std::max<size_t>(contour.points.size(), 1));
}

/// A colour per contour: paired contours have the same colour on all objects, those without a pair are grey.
std::vector<std::vector<std::string>> chooseColours(const SlicePicture& slice) {
  std::vector<std::vector<std::string>> colours;
  for (const auto& object : slice.objects) colours.emplace_back(object.size(), kGrey);
  size_t next = 0;
  for (size_t k = 0; k + 1 < slice.objects.size(); ++k)
    for (size_t i = 0; i < slice.objects[k].size(); ++i) {
      const int partner = slice.objects[k][i].partner;
      if (partner < 0 || size_t(partner) >= slice.objects[k + 1].size()) continue;
      if (colours[k][i] == kGrey) colours[k][i] = seriesColour(next++);
      colours[k + 1][size_t(partner)] = colours[k][i];
    }
  return colours;
}

void drawContour(std::ostream& svg, const Contour& contour, const std::string& colour, const View& view,
                 size_t panel) {
  svg << "<polygon points=\"";
  for (const Vec2d& p : contour.points) {
    const Vec2d pixel = view(p, panel);
    svg << pixel[0] << ',' << pixel[1] << ' ';
  }
  svg << "\" fill=\"" << (contour.hole ? "#ffffff" : colour) << "\" fill-opacity=\""
      << (contour.hole ? 0.7 : 0.15) << "\" stroke=\"" << colour << "\" stroke-width=\""
      << (contour.hole ? 1 : 2) << "\"" << (colour == kGrey ? " stroke-dasharray=\"5 4\"" : "") << "/>\n";
}

/// The last part of a path: whole paths would overlap in the drawing.
std::string withoutFolder(const std::string& path) {
  const size_t slash = path.find_last_of('/', path.size() < 2 ? 0 : path.size() - 2);
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

std::string drawSlice(const SlicePicture& slice, size_t number, size_t count, const View& view,
                      const std::vector<std::string>& names) {
  const auto colours = chooseColours(slice);
  const size_t panels = slice.objects.size();
  std::ostringstream svg;
  svg << std::fixed;
  svg.precision(2);
  const double width = kPanel * double(panels), height = kPanel + kHeader;
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height
      << "\" viewBox=\"0 0 " << width << " " << height << "\" font-family=\"sans-serif\" font-size=\"13\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  for (size_t k = 0; k < panels; ++k) {
    svg << "<text x=\"" << kPanel * double(k) + 8 << "\" y=\"18\">"
        << escapedForPage(k < names.size() ? withoutFolder(names[k]) : "");
    if (k == 0) svg << " - slice " << number << " of " << count << ", u = " << slice.u;
    svg << "</text>\n";
    // Outer contours first, so that holes are drawn over them.
    for (bool hole : {false, true})
      for (size_t i = 0; i < slice.objects[k].size(); ++i)
        if (slice.objects[k][i].hole == hole) drawContour(svg, slice.objects[k][i], colours[k][i], view, k);
  }
  for (size_t k = 0; k + 1 < panels; ++k)
    for (const Contour& contour : slice.objects[k]) {
      if (contour.partner < 0 || size_t(contour.partner) >= slice.objects[k + 1].size()) continue;
      const Vec2d from = view(centroid(contour), k);
      const Vec2d to = view(centroid(slice.objects[k + 1][size_t(contour.partner)]), k + 1);
      svg << "<line x1=\"" << from[0] << "\" y1=\"" << from[1] << "\" x2=\"" << to[0] << "\" y2=\"" << to[1]
          << "\" stroke=\"#333333\" stroke-width=\"0.8\"/>\n";
    }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace

std::vector<std::string> drawSlices(const std::vector<SlicePicture>& slices,
                                    const std::vector<std::string>& objectNames) {
  const View view = fitView(slices);
  std::vector<std::string> drawings;
  for (size_t i = 0; i < slices.size(); ++i)
    drawings.push_back(drawSlice(slices[i], i + 1, slices.size(), view, objectNames));
  return drawings;
}

void dumpSlices(const std::string& folder, const std::vector<SlicePicture>& slices,
                const std::vector<std::string>& objectNames) {
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (!std::filesystem::is_directory(folder))
    throw IoError(folder + ": cannot make the folder: " + error.message());
  const std::vector<std::string> drawings = drawSlices(slices, objectNames);
  for (size_t i = 0; i < drawings.size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "slice.%04zu.svg", i + 1);
    writeTextFile((std::filesystem::path(folder) / name).string(), drawings[i]);
  }
}

}  // namespace slicemorph
