#include "tools/job/picture_options.h"

#include "io/exr/exr_writer.h"
#include "io/image/png_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
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

void checkSize(PictureOptions& s) {
  int width = 0, height = 0;
  if (!parseSize(s.size, width, height))
    throw InputError("--size " + s.size + " is not a size; expected WIDTHxHEIGHT, for example 640x480");
  for (const int side : {width, height}) {
    if (side < 1 || side > 16384)
      throw InputError(s.sizeOption + " " + s.size +
                       " is out of range; width and height must be 1 to 16384 pixels");
  }
  s.render.width = width, s.render.height = height;
  s.framing.aspect = double(width) / height;
}

void checkCamera(PictureOptions& s) {
  if (s.ortho && s.fovGiven->count())
    throw InputError("--ortho and --fov exclude each other; give one of them");
  if (!(s.fov >= 1 && s.fov <= 170))
    throw InputError("--fov " + formatNumber(s.fov) + " is out of range; it must be 1 to 170 degrees");
  s.framing.verticalFov = s.ortho ? 0 : s.fov;
  if (!s.camera.empty() && !s.view.empty())
    throw InputError("--camera and --view exclude each other; give one of them (--look-at with --camera)");
  if (s.camera.empty() && !s.lookAt.empty())
    throw InputError("--look-at " + s.lookAt + " needs --camera X,Y,Z");
  if (!s.view.empty()) s.framing.direction = parseDirection("--view", s.view);
  if (!s.up.empty()) s.framing.up = parseDirection("--up", s.up);
  const Vec3d &view = s.framing.direction, &up = s.framing.up;
  if (s.camera.empty() && view.cross(up).length() < 1e-6 * view.length() * up.length()) {
    if (!s.up.empty())
      throw InputError("--view " + s.view + " is along --up " + s.up + "; choose another for one of them");
    // Straight up or down, the picture's top has to be another direction.
    s.framing.up = Vec3d(0, 0, -1);
  }
}

void checkLook(PictureOptions& s) {
  if (!s.light.empty()) s.render.light = parseDirection("--light", s.light);
  if (!(s.render.intensity >= 0) || !std::isfinite(s.render.intensity))
    throw InputError("--light-intensity " + formatNumber(s.render.intensity) + " must be 0 or more");
  if (s.extinctionGiven->count()) checkPositive("--extinction", s.extinction);
  if (!(s.emission >= 0) || !std::isfinite(s.emission))
    throw InputError("--emission " + formatNumber(s.emission) + " must be 0 or more");
  if (s.albedo.empty()) return;
  const std::vector<double> v = parseNumbers("--albedo", s.albedo);
  const bool inside = std::all_of(v.begin(), v.end(), [](double share) { return share >= 0 && share <= 1; });
  if ((v.size() != 1 && v.size() != 3) || !inside)
    throw InputError("--albedo " + s.albedo + ": expected one share from 0 to 1, or three (red,green,blue)");
}

}  // namespace

bool parseSize(const std::string& text, int& width, int& height) {
  char rest = 0;
  return std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) == 2;
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
  if (s.extinctionGiven->count()) look.extinction = s.extinction;
  look.emission *= s.emission;
  if (!s.albedo.empty()) {
    const std::vector<double> v = parseNumbers("--albedo", s.albedo);
    look.albedo = v.size() == 1 ? Colour(float(v[0])) : Colour(float(v[0]), float(v[1]), float(v[2]));
  }
  return look;
}

void checkPictureOptions(PictureOptions& s) {
  checkSize(s);
  checkCamera(s);
  checkLook(s);
  s.render.background = !s.transparent;
}

void writePicture(const std::string& path, const Picture& picture) {
  if (OutputName(path).extension() == ".exr")
    writePictureExr(path, picture);
  else
    writePng(path, picture);
}

std::vector<JobOption> addPictureOptions(CLI::App& command, PictureOptions& s) {
  std::vector<JobOption> options;
  const auto add = [&](const std::string& name, auto& value, JobType type, const std::string& help,
                       const std::string& typeName) {
    const std::string fallback = fallbackOf(value);
    CLI::Option* option = command.add_option("--" + name, value, help)->type_name(typeName);
    options.push_back({name, type, option, {}, fallback});
    return option;
  };
  const auto flag = [&](const std::string& name, bool& value, const std::string& help) {
    options.push_back({name, JobType::kFlag, command.add_flag("--" + name, value, help)});
  };
  add("size", s.size, JobType::kText, "Pixels of a picture (640x480)", "WxH");
  add("view", s.view, JobType::kNumbers, "Direction from the camera into the scene (-0.55,-0.3,-1)",
      "DX,DY,DZ");
  add("up", s.up, JobType::kNumbers, "Direction that is up in the picture, and the turntable's axis (y)",
      "x|y|z|DX,DY,DZ");
  add("camera", s.camera, JobType::kNumbers, "Place of the camera, world units (all is seen whole)", "X,Y,Z");
  add("look-at", s.lookAt, JobType::kNumbers,
      "Place that --camera looks at (middle of all that is to be seen)", "X,Y,Z");
  s.fovGiven =
      add("fov", s.fov, JobType::kNumber, "Angle seen from bottom to top, 1 to 170 degrees (25)", "DEG");
  flag("ortho", s.ortho, "Parallel rays, no perspective");
  add("light", s.light, JobType::kNumbers,
      "Direction in which the main light shines (from the camera's upper left)", "DX,DY,DZ");
  add("light-intensity", s.render.intensity, JobType::kNumber, "Of the main light, 0 or more (1)", "F");
  s.extinctionGiven = add("extinction", s.extinction, JobType::kNumber,
                          "Of fog: per world unit at density 1 (its thickest is just opaque)", "F");
  add("albedo", s.albedo, JobType::kNumbers, "Of fog: share of the light that is scattered (0.85)",
      "A|R,G,B");
  add("emission", s.emission, JobType::kNumber,
      "Of fog: strength of the glow of its flame or temperature, 0 or more (1)", "F");
  flag("transparent", s.transparent, "No background");
  return options;
}

}  // namespace slicemorph
