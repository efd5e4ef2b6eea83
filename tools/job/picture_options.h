#pragma once

#include "engine/render/render_fog.h"

#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

class OptionSet;

/// Options of pictures, as typed and, once checked, in the renderer's terms.
struct PictureOptions {
  std::string size = "640x480", sizeOption = "--size";
  std::string view, up, light, camera, lookAt, albedo;
  double fov = 25, extinction = 0, emission = 1;  ///< degrees; 0: found from the fog; factor
  bool ortho = false, transparent = false;
  RenderOptions render;
  FrameAllOptions framing;
};

/// The command's picture options, checked. Throws InputError naming the option, its value and what would be
/// right.
PictureOptions checkedPicture(const OptionSet& options);
/// The same for options that a command has changed; positions in a file come from the set.
PictureOptions checkedPicture(PictureOptions picture, const OptionSet& options);

struct PictureSize {
  int width = 0, height = 0;
};
/// Parses WIDTHxHEIGHT; none for any other text.
std::optional<PictureSize> parseSize(const std::string& text);

/// A camera at the given position, or one that shows all boxes completely. Throws InputError for a camera at
/// the point that it looks at.
Camera cameraFor(const std::vector<openvdb::BBoxd>& boxes, const PictureOptions& options);
/// One look for all fog; what the options leave open follows from the measures.
FogLook lookFor(const std::vector<FogMeasure>& measures, const PictureOptions& options);

/// Writes .exr by extension, else .png. Throws IoError.
void writePicture(const std::string& path, const Picture& picture);

}  // namespace slicemorph
