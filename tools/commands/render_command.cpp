#include "tools/commands/render_command.h"

#include "engine/render/contact_sheet.h"
#include "engine/render/render.h"
#include "io/image/video_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_progress.h"
#include "tools/job/picture_options.h"
#include "tools/job/render_shots.h"

#include <cstdio>
#include <memory>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct RenderSettings {
  std::vector<std::string> inputs;
  std::string output, sheet;
  int columns = 0, threads = 0, turntable = 0;
  double framesPerSecond = 24;
  PictureOptions picture;
  LoadOptions load;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *turntableGiven = nullptr;
  bool surface = false, quiet = false;
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
      video_ = std::make_unique<VideoWriter>(output, settings.picture.render.width,
                                             settings.picture.render.height, settings.framesPerSecond);
  }

  /// Returns the file that is complete; empty: none yet.
  std::string add(const Picture& picture, int number) {
    if (video_) return video_->add(picture), "";
    if (settings_.output.empty()) return "";
    const std::string path = OutputName(settings_.output).path(number);
    writePicture(path, picture);
    return path;
  }
  std::string finish() {
    if (!video_) return "";
    video_->commit();
    return settings_.output;
  }

 private:
  const RenderSettings& settings_;
  std::unique_ptr<VideoWriter> video_;
};

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
  const Camera camera = cameraFor(boxes, s.picture);
  const FogLook look = lookFor(fogs, s.picture);
  if (!fogs.empty() && !s.picture.extinctionGiven->count()) {
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
      return subject.fog ? renderFog(*subject.fog, look, from, s.picture.render)
                         : renderSurface(*subject.surface, from, s.picture.render, subject.colors.get());
    });
    tell(output.add(picture, shot.number));
    if (s.sheet.empty()) continue;
    for (auto* unused : {&picture.mask, &picture.depth, &picture.normal}) *unused = {};
    tiles.push_back({std::move(picture), shot.caption});
  }
  tell(output.finish());
  if (s.sheet.empty()) return;
  writePicture(s.sheet, contactSheet(tiles, s.columns));
  tell(s.sheet);
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
  checkRange("--samples", s.picture.render.samples, 1, 64);
  checkRange("--columns", s.columns, 0, 1000);
  if (s.turntableGiven->count()) checkRange("--turntable", s.turntable, 1, 100000);
  s.picture.framing.allRound = s.turntable > 0;
  checkPictureOptions(s.picture);
  checkOutputs(s);
  const std::string extension = OutputName(s.output).extension();
  s.picture.render.channels = extension == ".exr";
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
      s.picture.size = text;
      s.picture.sizeOption = "--resolution";
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
  command
      ->add_option("--samples", s->picture.render.samples,
                   "Rays per pixel, 1 to 64 (4); of surfaces only where these end or turn")
      ->type_name("N");
  addPictureOptions(*command, s->picture);
  s->turntableGiven =
      command
          ->add_option("--turntable", s->turntable,
                       "Pictures of a full turn around the up axis, during which a sequence plays once")
          ->type_name("N");
  command->add_flag("--surface", s->surface, "Fog is drawn as the shape in it, at --iso");
  s->sampling = addSamplingOptions(*command, s->load);
  addResolutionOption(*command, *s);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runRender(*s); });
}

}  // namespace slicemorph
