#include "tools/report/report_page.h"

#include "engine/follow/moving_mesh.h"
#include "engine/render/contact_sheet.h"
#include "engine/render/render.h"
#include "engine/volume/level_set.h"
#include "engine/volume/surface_colors.h"
#include "io/image/png_writer.h"
#include "io/mesh/glb_writer.h"
#include "slicemorph/errors.h"
#include "tools/report/dump_slices.h"

#include <algorithm>
#include <cmath>
#include <string_view>

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
namespace {

using Json = nlohmann::ordered_json;

/// Most frames and pictures on the page, and voxels along the longest side of a shape: they keep a page
/// below 20 MB.
constexpr size_t kMostFrames = 24, kMostPictures = 12;
constexpr double kVoxels = 72;
constexpr int kWidth = 320, kHeight = 260;  // of a picture, pixels

/// At most `most` of the indices 0 to `count` - 1, evenly spread, with the first and the last.
std::vector<size_t> spread(size_t count, size_t most) {
  const size_t n = std::min(count, most);
  std::vector<size_t> indices;
  for (size_t i = 0; i < n; ++i) indices.push_back(n > 1 ? (i * (count - 1) + (n - 1) / 2) / (n - 1) : 0);
  return indices;
}

std::string base64(std::string_view bytes) {
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

std::string script(const std::string& id, const std::string& type, const std::string& text) {
  return "<script id=\"" + id + "\" type=\"" + type + "\">" + text + "</script>\n";
}

/// JSON for a script element of a page: what could end the element is escaped.
std::string inPage(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) text.insert(at + 1, 1, '\\');
  for (size_t at = 0; (at = text.find("<!", at)) != std::string::npos; at += 7)
    text.replace(at, 1, "\\u003c");
  return text;
}

}  // namespace

PageShapes::PageShapes(PageJob job) : job_(std::move(job)), shown_(spread(job_.frames, kMostFrames)) {}

bool PageShapes::has(size_t frame) const { return std::binary_search(shown_.begin(), shown_.end(), frame); }

void PageShapes::add(const PageFrame& frame) {
  if (!frame.surface || frame.surface->empty()) return;
  PageFrame coarse = frame;
  try {
    const Vec3d size = surfaceBox(*frame.surface).extents();
    const double voxel =
        std::max(frame.surface->voxelSize()[0], std::max({size[0], size[1], size[2]}) / kVoxels);
    coarse.surface = toLevelSet(frame.surface->copy(), voxel).grid;
    coarse.colors = frame.colors ? colorsAround(*coarse.surface, *frame.colors) : nullptr;
  } catch (const GeometryError&) {
    return;  // too thin to be seen at this size
  }
  added_.push_back(std::move(coarse));
}

PageParts PageShapes::finish(const MorphPlan* plan, Progress& progress) const {
  PageParts parts;
  if (plan) parts.slices = drawSlices(plan->slicePictures(), job_.inputs);
  if (added_.empty()) return parts;
  std::vector<SurfaceFrame> frames;
  std::vector<openvdb::BBoxd> boxes;
  for (const PageFrame& frame : added_) {
    parts.frames.push_back(frame.index);
    frames.push_back({frame.surface, frame.weights, frame.colors});
    boxes.push_back(surfaceBox(*frame.surface));
  }
  parts.glb = encodeGlb(followSurfaces(frames, plan, {}, &progress), 1, job_.space);
  FrameAllOptions framing;
  framing.aspect = double(kWidth) / kHeight;
  if (job_.space.zUp) framing.direction = {-0.55, 1, -0.3}, framing.up = {0, 0, 1};
  const Camera camera = frameAll(boxes, framing);
  RenderOptions options;
  options.width = kWidth, options.height = kHeight;
  std::vector<Tile> tiles;
  for (size_t i : spread(added_.size(), kMostPictures))
    tiles.push_back(
        {renderSurface(*added_[i].surface, camera, options, added_[i].colors.get()), added_[i].caption});
  parts.sheet = encodePng(contactSheet(tiles));
  return parts;
}

std::string pageOf(const Json& report, const PageParts& parts) {
  Json figures = report;
  figures["viewer"] = {{"frames", parts.frames}};
  std::string data = script("report", "application/json", inPage(figures));
  if (!parts.glb.empty()) data += script("glb", "text/plain", base64(parts.glb));
  if (!parts.sheet.empty())
    data += script("sheetData", "text/plain", "data:image/png;base64," + base64(parts.sheet));
  if (!parts.slices.empty()) data += script("slices", "application/json", inPage(parts.slices));
  const std::string_view page(slicemorphPage, size_t(slicemorphPageEnd - slicemorphPage)),
      mark = "<!--DATA-->";
  const size_t at = page.find(mark);
  return std::string(page.substr(0, at)) + data + std::string(page.substr(at + mark.size()));
}

}  // namespace slicemorph
