#include "tools/job/picture_options.h"

#include "io/exr/exr_writer.h"
#include "io/image/png_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/option_set.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

Vec3d parsePoint(const std::string& option, const std::string& text) {
  const std::vector<double> v = parseNumbers(option, text);
  if (v.size() != 3) throw InputError(option + " " + text + ": expected a place, X,Y,Z");
  return Vec3d(v[0], v[1], v[2]);
}

/// Pixels; the limit of RenderOptions.
constexpr int kLargestSide = 16384;

PictureSize checkedSize(const PictureOptions& s) {
  const std::optional<PictureSize> size = parseSize(s.size);
  if (!size)
    throw InputError("--size " + s.size + " is not a size; expected WIDTHxHEIGHT, for example 640x480");
  for (const int side : {size->width, size->height})
    if (side < 1 || side > kLargestSide)
      throw InputError(s.sizeOption + " " + s.size + " is out of range; width and height must be 1 to " +
                       std::to_string(kLargestSide) + " pixels");
  return *size;
}

std::vector<double> parseAlbedo(const std::string& text) {
  const std::vector<double> v = parseNumbers("--albedo", text);
  const bool inside = std::all_of(v.begin(), v.end(), [](double share) { return share >= 0 && share <= 1; });
  if ((v.size() != 1 && v.size() != 3) || !inside)
    throw InputError("--albedo " + text + ": expected one share from 0 to 1, or three (red,green,blue)");
  return v;
}

/// Throws InputError for --camera and --look-at that are no points, and for --look-at without --camera.
void checkPosition(const PictureOptions& s, const OptionSet& options) {
  if (!s.camera.empty()) options.about("camera", [&] { parsePoint("--camera", s.camera); });
  if (s.lookAt.empty()) return;
  if (s.camera.empty()) options.refuse("look-at", "--look-at " + s.lookAt + " needs --camera X,Y,Z");
  options.about("look-at", [&] { parsePoint("--look-at", s.lookAt); });
}

FrameAllOptions checkedFraming(const PictureOptions& s, const OptionSet& options) {
  FrameAllOptions framing = s.framing;
  framing.aspect = double(s.render.width) / s.render.height;
  framing.verticalFov = s.ortho ? 0 : s.fov;
  if (!s.view.empty())
    framing.direction = options.about("view", [&] { return parseDirection("--view", s.view); });
  if (!s.up.empty()) framing.up = options.about("up", [&] { return parseDirection("--up", s.up); });
  const Vec3d &view = framing.direction, &up = framing.up;
  if (!s.camera.empty() || view.cross(up).length() >= 1e-6 * view.length() * up.length()) return framing;
  if (!s.up.empty())
    options.refuse("view",
                   "--view " + s.view + " is along --up " + s.up + "; choose another for one of them");
  // The view is straight up or down: another direction has to be up in the picture.
  framing.up = Vec3d(0, 0, -1);
  return framing;
}

}  // namespace

std::optional<PictureSize> parseSize(const std::string& text) {
  PictureSize size;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2) return std::nullopt;
  return size;
}

Camera cameraFor(const std::vector<openvdb::BBoxd>& boxes, const PictureOptions& s) {
  FrameAllOptions framing = s.framing;
  if (s.camera.empty()) return frameAll(boxes, framing);
  openvdb::BBoxd all;
  for (const openvdb::BBoxd& box : boxes) all.expand(box);
  const Vec3d position = parsePoint("--camera", s.camera);
  const Vec3d target = s.lookAt.empty() ? all.getCenter() : parsePoint("--look-at", s.lookAt);
  framing.direction = target - position;
  if (framing.direction.length() == 0)
    throw InputError("--camera " + s.camera + " is where it looks at; give another place, or --look-at");
  Camera camera = frameAll(boxes, framing);
  camera.position = position;
  camera.target = target;
  return camera;
}

FogLook lookFor(const std::vector<FogMeasure>& measures, const PictureOptions& s) {
  FogLook look = lookOf(measures);
  if (s.extinction > 0) look.extinction = s.extinction;
  look.emission *= s.emission;
  if (!s.albedo.empty()) {
    const std::vector<double> v = parseAlbedo(s.albedo);
    look.albedo = v.size() == 1 ? Colour(float(v[0])) : Colour(float(v[0]), float(v[1]), float(v[2]));
  }
  return look;
}

PictureOptions checkedPicture(PictureOptions s, const OptionSet& options) {
  const PictureSize size = options.about("size", [&] { return checkedSize(s); });
  s.render.width = size.width, s.render.height = size.height;
  checkPosition(s, options);
  s.framing = checkedFraming(s, options);
  if (!s.light.empty())
    s.render.light = options.about("light", [&] { return parseDirection("--light", s.light); });
  if (!s.albedo.empty()) options.about("albedo", [&] { parseAlbedo(s.albedo); });
  s.render.background = !s.transparent;
  return s;
}

PictureOptions checkedPicture(const OptionSet& options) {
  return checkedPicture(options.values().picture, options);
}

void writePicture(const std::string& path, const Picture& picture) {
  if (OutputName(path).extension() == ".exr")
    writePictureExr(path, picture);
  else
    writePng(path, picture);
}

}  // namespace slicemorph
