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
#include "tools/report/page_template.h"

#include <algorithm>
#include <cmath>

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
  std::string data = pageData("report", figures);
  if (!parts.glb.empty()) data += pageData("glb", "text/plain", base64Of(parts.glb));
  if (!parts.sheet.empty())
    data += pageData("sheetData", "text/plain", "data:image/png;base64," + base64Of(parts.sheet));
  if (!parts.slices.empty()) data += pageData("slices", parts.slices);
  return pageWith(data + parts.pick);
}

}  // namespace slicemorph
