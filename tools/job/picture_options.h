#pragma once

#include "engine/render/render_fog.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

class OptionSet;

/// How pictures of shapes and fog are taken, as typed and, once checked, as the renderer wants it.
struct PictureOptions {
  std::string size = "640x480", sizeOption = "--size";
  std::string view, up, light, camera, lookAt, albedo;
  double fov = 25, extinction = 0, emission = 1;  ///< an extinction of 0 is found from the fog
  bool ortho = false, transparent = false;
  RenderOptions render;
  FrameAllOptions framing;
};

/// The command's picture options, checked. Throws InputError naming the option, its value and what would be
/// right.
PictureOptions checkedPicture(const OptionSet& options);
/// The same of options that a command has changed; places in a file come from the set.
PictureOptions checkedPicture(PictureOptions picture, const OptionSet& options);

struct PictureSize {
  int width = 0, height = 0;
};
/// Of a text that is WIDTHxHEIGHT and nothing else.
std::optional<PictureSize> parseSize(const std::string& text);

/// The camera's position is given, or found so that all boxes are seen whole.
Camera cameraFor(const std::vector<openvdb::BBoxd>& boxes, const PictureOptions& options);
/// One look for all fog; what is not given follows from all frames.
FogLook lookFor(const std::vector<FogMeasure>& measures, const PictureOptions& options);

/// By extension, .exr or .png.
void writePicture(const std::string& path, const Picture& picture);

}  // namespace slicemorph
