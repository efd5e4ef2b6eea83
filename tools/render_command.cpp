#include "tools/render_command.h"

#include "engine/errors.h"
#include "engine/render/contact_sheet.h"
#include "engine/render/render.h"
#include "io/exr_writer.h"
#include "io/output.h"
#include "io/png_writer.h"
#include "io/sequence.h"
#include "tools/common_options.h"
#include "tools/terminal_progress.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace slicemorph {
namespace {

struct RenderSettings {
  std::vector<std::string> inputs;
  std::string output, sheet, size = "640x480", view;
  int columns = 0, threads = 0;
  RenderOptions render;
  FrameAllOptions framing;
  LoadOptions load;
  SamplingOptions sampling;
  CLI::Option* threadsGiven = nullptr;
  bool transparent = false, quiet = false;
};

/// One picture to make.
struct Shot {
  int number = 1;
  std::string input, caption;
};

std::vector<Shot> listShots(const std::vector<std::string>& inputs) {
  std::vector<Shot> shots;
  for (const std::string& input : inputs) {
    if (OutputName(input).isSequence()) {
      for (const SequenceFile& file : findSequence(input))
        shots.push_back({file.number, file.path, std::to_string(file.number)});
    } else {
      checkInputExists(input);
      shots.push_back({1, input, std::filesystem::path(input).stem().string()});
    }
  }
  // A single sequence keeps its own numbers.
  if (inputs.size() > 1)
    for (size_t i = 0; i < shots.size(); ++i) shots[i].number = int(i) + 1;
  return shots;
}

/// Level sets of the shots: read twice, for the camera and for the picture, where they are too many to keep.
class ShotGrids {
 public:
  ShotGrids(const std::vector<Shot>& shots, const RenderSettings& settings)
      : shots_(shots), settings_(settings), kept_(shots.size()) {}

  FloatGrid::ConstPtr get(size_t i) {
    if (kept_[i]) return kept_[i];
    const LoadedObject loaded = loadObject(shots_[i].input, settings_.load);
    const size_t bytes = loaded.object.levelSet->memUsage();
    if (keptBytes_ + bytes < kMostBytes) {
      keptBytes_ += bytes;
      kept_[i] = loaded.object.levelSet;
    }
    return loaded.object.levelSet;
  }

 private:
  static constexpr size_t kMostBytes = size_t(1) << 30;
  const std::vector<Shot>& shots_;
  const RenderSettings& settings_;
  std::vector<FloatGrid::ConstPtr> kept_;
  size_t keptBytes_ = 0;
};

void writeImage(const std::string& path, const Picture& image) {
  if (OutputName(path).extension() == ".exr")
    writePictureExr(path, image);
  else
    writePng(path, image);
}

void renderShots(const std::vector<Shot>& shots, const RenderSettings& s) {
  TerminalProgress progress(s.quiet);
  const auto report = [&](const char* stage, double fraction) {
    if (progress.cancelled()) throw Cancelled();
    progress.report(stage, fraction);
  };
  ShotGrids grids(shots, s);
  std::vector<openvdb::BBoxd> boxes;
  for (size_t i = 0; i < shots.size(); ++i) {
    report("reading", 0.3 * double(i) / double(shots.size()));
    boxes.push_back(surfaceBox(*grids.get(i)));
  }
  const Camera camera = frameAll(boxes, s.framing);
  std::vector<Tile> tiles;
  for (size_t i = 0; i < shots.size(); ++i) {
    report("rendering", 0.3 + 0.7 * double(i) / double(shots.size()));
    Picture image = renderSurface(*grids.get(i), camera, s.render);
    if (!s.output.empty()) {
      const std::string path = OutputName(s.output).path(shots[i].number);
      writeImage(path, image);
      progress.clear();
      if (!s.quiet) std::printf("%s\n", path.c_str());
    }
    if (!s.sheet.empty()) tiles.push_back({std::move(image), shots[i].caption});
  }
  if (s.sheet.empty()) return;
  writeImage(s.sheet, contactSheet(tiles, s.columns));
  progress.clear();
  if (!s.quiet) std::printf("%s\n", s.sheet.c_str());
}

void parseSize(RenderSettings& s) {
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(s.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2)
    throw InputError("--size " + s.size + " is not a size; expected WIDTHxHEIGHT, for example 640x480");
  checkRange("--size", width, 1, 16384);
  checkRange("--size", height, 1, 16384);
  s.render.width = width, s.render.height = height;
  s.framing.aspect = double(width) / height;
}

void runRender(RenderSettings& s) {
  if (s.inputs.empty())
    throw InputError("render needs an input; for example: slicemorph render a.vdb -o a.png");
  if (s.output.empty() && s.sheet.empty())
    throw InputError("render needs an output: -o name.png, or --contact-sheet sheet.png");
  checkSampling(s.load, s.sampling);
  checkRange("--samples", s.render.samples, 1, 64);
  checkRange("--columns", s.columns, 0, 1000);
  parseSize(s);
  if (!s.view.empty()) s.framing.direction = parseDirection("--view", s.view);
  // Straight up or down, the picture's top has to be another direction.
  if (s.framing.direction.cross(s.framing.up).length() < 1e-6 * s.framing.direction.length())
    s.framing.up = Vec3d(0, 0, -1);
  s.render.background = !s.transparent;
  for (const std::string& path : {s.output, s.sheet}) {
    if (path.empty()) continue;
    checkExtension(path, {".png", ".exr"});
    checkOutputPath(OutputName(path).path(1));
  }
  const std::vector<Shot> shots = listShots(s.inputs);
  if (shots.size() > 1 && !s.output.empty() && !OutputName(s.output).isSequence())
    throw InputError("-o " + s.output + " is one file for " + std::to_string(shots.size()) +
                     " pictures; put #### where the number belongs (name.####.png)");
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  cancelOnInterrupt();
  renderShots(shots, s);
}

}  // namespace

void addRenderCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("render", "Pictures of shapes and sequences, seen by one camera");
  const auto s = std::make_shared<RenderSettings>();
  command->add_option("INPUT", s->inputs,
                      "Shapes; name.####.vdb stands for all files of that name that are there");
  command->add_option("-o,--output", s->output, "Pictures: .png or .exr; #### stands for the number")
      ->type_name("OUTPUT");
  command->add_option("--contact-sheet", s->sheet, "All pictures on one sheet, with captions: .png or .exr")
      ->type_name("FILE");
  command->add_option("--columns", s->columns, "Columns of the contact sheet (0: about as wide as high)")
      ->type_name("N");
  command->add_option("--size", s->size, "Pixels of a picture (640x480)")->type_name("WxH");
  command->add_option("--view", s->view, "Direction from the camera into the scene (-0.55,-0.3,-1)")
      ->type_name("DX,DY,DZ");
  command->add_option("--samples", s->render.samples, "Rays per pixel, 1 to 64 (4)")->type_name("N");
  command->add_flag("--transparent", s->transparent, "No background");
  s->sampling = addSamplingOptions(*command, s->load);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runRender(*s); });
}

}  // namespace slicemorph
