#include "tools/render_command.h"

#include "engine/errors.h"
#include "engine/render/contact_sheet.h"
#include "engine/render/render.h"
#include "io/exr_writer.h"
#include "io/output.h"
#include "io/png_writer.h"
#include "io/video_writer.h"
#include "tools/common_options.h"
#include "tools/render_shots.h"
#include "tools/terminal_progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct RenderSettings {
  std::vector<std::string> inputs;
  std::string output, sheet, size = "640x480", sizeOption = "--size";
  std::string view, up, light, camera, lookAt, albedo;
  int columns = 0, threads = 0, turntable = 0;
  double fov = 25, framesPerSecond = 24, extinction = 0, emission = 1;
  RenderOptions render;
  FrameAllOptions framing;
  LoadOptions load;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *fovGiven = nullptr, *turntableGiven = nullptr,
              *extinctionGiven = nullptr;
  bool ortho = false, surface = false, transparent = false, quiet = false;
};

/// One picture to make.
struct Shot {
  size_t input = 0;
  int number = 1;
  double angle = 0;  ///< radians, of the turntable
  std::string caption;
};

/// All inputs, or a full turn during which they play once.
std::vector<Shot> listShots(const std::vector<RenderInput>& inputs, int turntable) {
  std::vector<Shot> shots;
  for (size_t i = 0; turntable == 0 && i < inputs.size(); ++i)
    shots.push_back({i, inputs[i].number, 0, inputs[i].caption});
  for (int n = 0; n < turntable; ++n) {
    const size_t input = size_t(n) * inputs.size() / size_t(turntable);
    shots.push_back({input, n + 1, 2 * kPi * n / turntable, formatNumber(360.0 * n / turntable, 4) + " deg"});
  }
  return shots;
}

/// Takes the pictures as they are made: numbered files, or one that moves.
class PictureOutput {
 public:
  explicit PictureOutput(const RenderSettings& settings) : settings_(settings) {
    const std::string& output = settings.output;
    if (isVideoExtension(OutputName(output).extension()))
      video_ = std::make_unique<VideoWriter>(output, settings.render.width, settings.render.height,
                                             settings.framesPerSecond);
  }

  /// Returns the file that is complete; empty: none yet.
  std::string add(const Picture& picture, int number) {
    if (video_) return video_->add(picture), "";
    return settings_.output.empty() ? "" : writeImage(OutputName(settings_.output).path(number), picture);
  }
  std::string finish() {
    if (!video_) return "";
    video_->commit();
    return settings_.output;
  }

  static std::string writeImage(const std::string& path, const Picture& picture) {
    if (OutputName(path).extension() == ".exr")
      writePictureExr(path, picture);
    else
      writePng(path, picture);
    return path;
  }

 private:
  const RenderSettings& settings_;
  std::unique_ptr<VideoWriter> video_;
};

Vec3d parsePoint(const std::string& option, const std::string& text) {
  const std::vector<double> v = parseNumbers(option, text);
  if (v.size() != 3) throw InputError(option + " " + text + ": expected a place, X,Y,Z");
  return Vec3d(v[0], v[1], v[2]);
}

/// The camera's place is given, or found so that all boxes are seen whole.
Camera cameraFor(const std::vector<openvdb::BBoxd>& boxes, const RenderSettings& s) {
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

/// One look for all fog; what is not given follows from all frames.
FogLook lookFor(const std::vector<FogMeasure>& measures, const RenderSettings& s) {
  FogLook look = lookOf(measures);
  if (s.extinctionGiven->count()) look.extinction = s.extinction;
  look.emission *= s.emission;
  if (!s.albedo.empty()) {
    const std::vector<double> v = parseNumbers("--albedo", s.albedo);
    look.albedo = v.size() == 1 ? Colour(float(v[0])) : Colour(float(v[0]), float(v[1]), float(v[2]));
  }
  return look;
}

/// What is wrong with a file's grid is told with the file's name.
template <typename Action>
auto ofFile(const std::string& path, const Action& action) {
  try {
    return action();
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  } catch (const GeometryError& error) {
    throw GeometryError(path + ": " + error.what());
  }
}

void renderAll(const std::vector<RenderInput>& inputs, const RenderSettings& s) {
  TerminalProgress progress(s.quiet);
  const auto report = [&](const char* stage, double fraction) {
    if (progress.cancelled()) throw Cancelled();
    progress.report(stage, fraction);
  };
  const auto tell = [&](const std::string& path) {
    progress.clear();
    if (!path.empty() && !s.quiet) std::printf("%s\n", path.c_str());
  };
  PictureOutput output(s);
  RenderSubjects subjects(inputs, s.load, s.surface);
  std::vector<openvdb::BBoxd> boxes;
  std::vector<FogMeasure> fogs;
  for (size_t i = 0; i < inputs.size(); ++i) {
    report("reading", 0.3 * double(i) / double(inputs.size()));
    const RenderSubject subject = subjects.get(i);
    ofFile(inputs[i].path, [&] {
      if (subject.fog) {
        fogs.push_back(measureFog(*subject.fog));
        // A simulation may begin without any.
        if (!fogs.back().box.empty()) boxes.push_back(fogs.back().box);
      } else {
        boxes.push_back(surfaceBox(*subject.surface));
      }
    });
  }
  if (boxes.empty())
    throw GeometryError(inputs[0].path + (inputs.size() > 1 ? " and all others are" : " is") +
                        " fog without an active voxel: there is nothing to see");
  const Camera camera = cameraFor(boxes, s);
  const FogLook look = lookFor(fogs, s);
  if (!fogs.empty() && !s.extinctionGiven->count()) {
    progress.clear();
    printNotes(
        "fog: ",
        {"extinction " + formatNumber(look.extinction, 4) + " per world unit (--extinction sets another)"},
        s.quiet);
  }

  std::vector<Tile> tiles;
  const std::vector<Shot> shots = listShots(inputs, s.turntable);
  for (size_t i = 0; i < shots.size(); ++i) {
    report("rendering", 0.3 + 0.7 * double(i) / double(shots.size()));
    const Shot& shot = shots[i];
    const RenderSubject subject = subjects.get(shot.input);
    const Camera from = turned(camera, shot.angle);
    Picture picture = ofFile(inputs[shot.input].path, [&] {
      return subject.fog ? renderFog(*subject.fog, look, from, s.render)
                         : renderSurface(*subject.surface, from, s.render);
    });
    tell(output.add(picture, shot.number));
    if (!s.sheet.empty()) tiles.push_back({std::move(picture), shot.caption});
  }
  tell(output.finish());
  if (!s.sheet.empty()) tell(PictureOutput::writeImage(s.sheet, contactSheet(tiles, s.columns)));
}

bool parseSize(const std::string& text, int& width, int& height) {
  char rest = 0;
  return std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) == 2;
}

void checkSize(RenderSettings& s) {
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

void checkCamera(RenderSettings& s) {
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
  if (s.turntableGiven->count()) checkRange("--turntable", s.turntable, 1, 100000);
  s.framing.allRound = s.turntable > 0;
}

void checkLook(RenderSettings& s) {
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

void checkOutputs(const RenderSettings& s) {
  if (s.output.empty() && s.sheet.empty())
    throw InputError("render needs an output: -o name.png, or --contact-sheet sheet.png");
  if (!s.output.empty()) checkExtension(s.output, {".png", ".exr", ".gif", ".mp4"});
  if (!s.sheet.empty()) checkExtension(s.sheet, {".png", ".exr"});
  for (const std::string& path : {s.output, s.sheet})
    if (!path.empty()) checkOutputPath(OutputName(path).path(1));
  checkPositive("--fps", s.framesPerSecond);
  if (!isVideoExtension(OutputName(s.output).extension())) return;
  if (OutputName(s.output).isSequence())
    throw InputError("-o " + s.output + " is one file for all pictures; leave out the ####");
  VideoWriter::checkAvailable(s.output);
}

void runRender(RenderSettings& s) {
  if (s.inputs.empty())
    throw InputError("render needs an input; for example: slicemorph render a.vdb -o a.png");
  checkSampling(s.load, s.sampling);
  checkRange("--samples", s.render.samples, 1, 64);
  checkRange("--columns", s.columns, 0, 1000);
  checkSize(s);
  checkCamera(s);
  checkLook(s);
  checkOutputs(s);
  s.render.background = !s.transparent;
  const std::string extension = OutputName(s.output).extension();
  s.render.channels = extension == ".exr";
  const std::vector<RenderInput> inputs = listRenderInputs(s.inputs);
  const size_t pictures = s.turntable > 0 ? size_t(s.turntable) : inputs.size();
  if (pictures > 1 && !s.output.empty() && !isVideoExtension(extension) && !OutputName(s.output).isSequence())
    throw InputError("-o " + s.output + " is one file for " + std::to_string(pictures) +
                     " pictures; put #### where the number belongs (name.####.png)");
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  cancelOnInterrupt();
  renderAll(inputs, s);
}

/// One option for two sizes that everybody calls the resolution: of the picture, and of a mesh's voxels.
void addResolutionOption(CLI::App& command, RenderSettings& s) {
  command.remove_option(s.sampling.resolution);
  s.sampling.resolution = nullptr;
  const auto parse = [&s](const std::string& text) {
    int width = 0, height = 0, used = 0;
    if (parseSize(text, width, height)) {
      s.size = text;
      s.sizeOption = "--resolution";
    } else if (std::sscanf(text.c_str(), "%d%n", &s.load.resolution, &used) == 1 &&
               size_t(used) == text.size()) {
      checkRange("--resolution", s.load.resolution, 8, 4096);
    } else {
      throw InputError("--resolution " + text +
                       ": expected pixels, for example 640x480, or a number of voxels");
    }
  };
  command
      .add_option_function<std::string>(
          "--resolution", parse,
          "Pixels of a picture, as --size; or one number: voxels along the longest side of a "
          "mesh, 8 to 4096 (256)")
      ->type_name("WxH|N");
}

void addCameraOptions(CLI::App& command, RenderSettings& s) {
  command.add_option("--view", s.view, "Direction from the camera into the scene (-0.55,-0.3,-1)")
      ->type_name("DX,DY,DZ");
  command.add_option("--up", s.up, "Direction that is up in the picture, and the turntable's axis (y)")
      ->type_name("x|y|z|DX,DY,DZ");
  command.add_option("--camera", s.camera, "Place of the camera, world units (all is seen whole)")
      ->type_name("X,Y,Z");
  command
      .add_option("--look-at", s.lookAt, "Place that --camera looks at (middle of all that is to be seen)")
      ->type_name("X,Y,Z");
  s.fovGiven = command.add_option("--fov", s.fov, "Angle seen from bottom to top, 1 to 170 degrees (25)")
                   ->type_name("DEG");
  command.add_flag("--ortho", s.ortho, "Parallel rays, no perspective");
  s.turntableGiven =
      command
          .add_option("--turntable", s.turntable,
                      "Pictures of a full turn around the up axis, during which a sequence plays once")
          ->type_name("N");
}

void addLookOptions(CLI::App& command, RenderSettings& s) {
  command
      .add_option("--light", s.light,
                  "Direction in which the main light shines (from the camera's upper left)")
      ->type_name("DX,DY,DZ");
  command.add_option("--light-intensity", s.render.intensity, "Of the main light, 0 or more (1)")
      ->type_name("F");
  s.extinctionGiven = command
                          .add_option("--extinction", s.extinction,
                                      "Of fog: per world unit at density 1 (its thickest is just opaque)")
                          ->type_name("F");
  command.add_option("--albedo", s.albedo, "Of fog: share of the light that is scattered (0.85)")
      ->type_name("A|R,G,B");
  command
      .add_option("--emission", s.emission,
                  "Of fog: strength of the glow of its flame or temperature, 0 or more (1)")
      ->type_name("F");
  command.add_flag("--surface", s.surface, "Fog is drawn as the shape in it, at --iso");
  command.add_flag("--transparent", s.transparent, "No background");
}

}  // namespace

void addRenderCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("render", "Pictures of shapes, fog and sequences, seen by one camera");
  const auto s = std::make_shared<RenderSettings>();
  command->add_option("INPUT", s->inputs,
                      "Shapes and fog; name.####.vdb stands for all files of that name that are there");
  command
      ->add_option("-o,--output", s->output,
                   "Pictures: .png, .exr (with mask, Z and N); #### stands for the number; a preview: .gif, "
                   ".mp4 (needs ffmpeg)")
      ->type_name("OUTPUT");
  command->add_option("--contact-sheet", s->sheet, "All pictures on one sheet, with captions: .png or .exr")
      ->type_name("FILE");
  command->add_option("--columns", s->columns, "Columns of the contact sheet (0: about as wide as high)")
      ->type_name("N");
  command->add_option("--fps", s->framesPerSecond, "Pictures a second of a preview (24)")->type_name("F");
  command->add_option("--size", s->size, "Pixels of a picture (640x480)")->type_name("WxH");
  command->add_option("--samples", s->render.samples, "Rays per pixel, 1 to 64 (4)")->type_name("N");
  addCameraOptions(*command, *s);
  addLookOptions(*command, *s);
  s->sampling = addSamplingOptions(*command, s->load);
  addResolutionOption(*command, *s);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runRender(*s); });
}

}  // namespace slicemorph
