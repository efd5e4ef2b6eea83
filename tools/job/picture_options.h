#pragma once

#include "engine/render/render_fog.h"
#include "tools/job/job_file.h"

#include <string>
#include <vector>

namespace slicemorph {

/// How pictures of shapes and fog are taken, as typed and, once checked, as the renderer wants it.
struct PictureOptions {
  std::string size = "640x480", sizeOption = "--size";
  std::string view, up, light, camera, lookAt, albedo;
  double fov = 25, extinction = 0, emission = 1;
  bool ortho = false, transparent = false;
  CLI::Option *fovGiven = nullptr, *extinctionGiven = nullptr;
  RenderOptions render;
  FrameAllOptions framing;
};

/// `--size --view --up --camera --look-at --fov --ortho --light --light-intensity --extinction --albedo
/// --emission --transparent`. Returns them as a job file knows them.
std::vector<JobOption> addPictureOptions(CLI::App& command, PictureOptions& options);
/// Throws InputError naming the option, its value and what would be right.
void checkPictureOptions(PictureOptions& options);

/// WIDTHxHEIGHT and nothing else.
bool parseSize(const std::string& text, int& width, int& height);

/// The camera's place is given, or found so that all boxes are seen whole.
Camera cameraFor(const std::vector<openvdb::BBoxd>& boxes, const PictureOptions& options);
/// One look for all fog; what is not given follows from all frames.
FogLook lookFor(const std::vector<FogMeasure>& measures, const PictureOptions& options);

/// By extension, .exr or .png.
void writePicture(const std::string& path, const Picture& picture);

}  // namespace slicemorph
