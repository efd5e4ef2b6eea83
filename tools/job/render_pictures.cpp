#include "tools/job/render_pictures.h"

#include "engine/render/contact_sheet.h"
#include "engine/render/render.h"
#include "io/image/video_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/load_settings.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"
#include "tools/job/render_shots.h"

#include <cstdio>
#include <memory>

namespace slicemorph {
namespace {

constexpr double kHalfTurn = 3.14159265358979323846;
/// Share of the first reading in the job; only the progress display depends on it.
constexpr double kLooked = 0.3;

/// One picture to make.
struct Shot {
  size_t input = 0;
  int number = 1;
  double angle = 0;  ///< radians, of the turntable
  std::string caption;
};

/// One shot per input, or the shots of a full turn during which the inputs play once.
std::vector<Shot> listShots(const std::vector<RenderInput>& inputs, int turntable) {
  std::vector<Shot> shots;
  for (size_t i = 0; turntable == 0 && i < inputs.size(); ++i)
    shots.push_back({i, inputs[i].number, 0, inputs[i].caption});
  for (int n = 0; n < turntable; ++n) {
    const size_t input = size_t(n) * inputs.size() / size_t(turntable);
    shots.push_back(
        {input, n + 1, 2 * kHalfTurn * n / turntable, formatNumber(360.0 * n / turntable, 4) + " deg"});
  }
  return shots;
}

/// Writes pictures as they are made: numbered files, or one video.
class PictureOutput {
 public:
  explicit PictureOutput(const RenderJob& job) : job_(job) {
    const std::string& output = job.output;
    if (isVideoExtension(OutputName(output).extension()))
      video_ = std::make_unique<VideoWriter>(output, job.picture.render.width, job.picture.render.height,
                                             job.framesPerSecond);
  }

  /// Returns the file that is complete now; empty: none.
  std::string add(const Picture& picture, int number) {
    if (video_) return video_->add(picture), "";
    if (job_.output.empty()) return "";
    const std::string path = OutputName(job_.output).path(number);
    writePicture(path, picture);
    return path;
  }
  std::string finish() {
    if (!video_) return "";
    video_->commit();
    return job_.output;
  }

 private:
  const RenderJob& job_;
  std::unique_ptr<VideoWriter> video_;
};

/// Runs `action`, and adds the file's name to its errors.
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

/// Boxes and fog of everything that is to be seen.
struct Scene {
  std::vector<openvdb::BBoxd> boxes;
  std::vector<FogMeasure> fogs;
};

Scene lookAround(const std::vector<RenderInput>& inputs, RenderSubjects& subjects, JobEvents& events) {
  Scene scene;
  for (size_t i = 0; i < inputs.size(); ++i) {
    events.throwIfCancelled();
    events.report("reading", kLooked * double(i) / double(inputs.size()));
    const RenderSubject subject = subjects.get(i);
    ofFile(inputs[i].path, [&] {
      if (subject.fog) {
        scene.fogs.push_back(measureFog(*subject.fog));
        // The first frames of a simulation may have no fog yet.
        if (!scene.fogs.back().box.empty()) scene.boxes.push_back(scene.fogs.back().box);
      } else if (subject.surface) {
        scene.boxes.push_back(surfaceBox(*subject.surface));
      }
    });
  }
  if (scene.boxes.empty())
    throw GeometryError(inputs[0].path + (inputs.size() > 1 ? " and all others are" : " is") +
                        " without an active voxel: there is nothing to see");
  return scene;
}

Fog nothingToSee() {
  Fog none;
  none.density = FloatGrid::create(0.f);
  return none;
}

/// Throws InputError where several pictures would go into one file that is no video.
void checkCount(const RenderJob& job, size_t inputs) {
  const size_t pictures = job.turntable > 0 ? size_t(job.turntable) : inputs;
  const OutputName name(job.output);
  if (pictures > 1 && !job.output.empty() && !isVideoExtension(name.extension()) && !name.isSequence())
    throw InputError("-o " + job.output + " is one file for " + std::to_string(pictures) +
                     " pictures; put #### where the number belongs (name.####.png)");
}

/// --resolution means two sizes: WIDTHxHEIGHT that of the picture, one number that of a mesh in voxels.
RenderJob withResolution(RenderJob job, const std::string& text) {
  if (text.empty()) return job;
  int used = 0;
  if (parseSize(text)) {
    job.picture.size = text;
    job.picture.sizeOption = "--resolution";
  } else if (std::sscanf(text.c_str(), "%d%n", &job.load.resolution, &used) == 1 &&
             size_t(used) == text.size()) {
    checkRange("--resolution", job.load.resolution, 8, 4096);
  } else {
    throw InputError("--resolution " + text +
                     ": expected pixels, for example 640x480, or a number of voxels");
  }
  return job;
}

}  // namespace

RenderJob renderJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  RenderJob job;
  job.inputs = given.inputs, job.held = given.held, job.output = given.output, job.sheet = given.contactSheet;
  job.columns = given.columns, job.turntable = given.turntable;
  job.framesPerSecond = given.framesPerSecond, job.asSurface = given.fogAsSurface;
  job.picture = given.picture, job.load = loadSettings(options);
  job = withResolution(std::move(job), given.pictureResolution);
  job.picture.framing.allRound = job.turntable > 0;
  job.picture = checkedPicture(job.picture, options);
  job.picture.render.channels = OutputName(job.output).extension() == ".exr";
  return job;
}

void checkRenderOutputs(const RenderJob& job) {
  if (!job.output.empty()) checkExtension(job.output, {".png", ".exr", ".gif", ".mp4"});
  if (!job.sheet.empty()) checkExtension(job.sheet, {".png", ".exr"});
  for (const std::string& path : {job.output, job.sheet})
    if (!path.empty()) checkOutputPath(OutputName(path).path(1));
  if (!isVideoExtension(OutputName(job.output).extension())) return;
  if (OutputName(job.output).isSequence())
    throw InputError("-o " + job.output + " is one file for all pictures; leave out the ####");
  VideoWriter::checkAvailable(job.output);
}

void renderPictures(const RenderJob& job, JobEvents& events) {
  const std::vector<RenderInput> inputs = listRenderInputs(job.inputs, job.held);
  checkCount(job, inputs.size());
  require(job.load.memory, job.output, needOfPicture(job.picture.render));
  PictureOutput output(job);
  RenderSubjects subjects(inputs, job.load, job.asSurface);
  const Scene scene = lookAround(inputs, subjects, events);
  const Camera camera = cameraFor(scene.boxes, job.picture);
  const FogLook look = lookFor(scene.fogs, job.picture);
  if (!scene.fogs.empty() && job.picture.extinction == 0)
    events.note(Note(
        "render.extinction", Severity::kNote, "fog",
        "extinction " + formatNumber(look.extinction, 4) + " per world unit (--extinction sets another)"));

  const auto written = [&](const std::string& path) {
    if (!path.empty()) events.fileWritten(path, false);
  };
  std::vector<Tile> tiles;
  const std::vector<Shot> shots = listShots(inputs, job.turntable);
  for (size_t i = 0; i < shots.size(); ++i) {
    events.throwIfCancelled();
    events.report("rendering", kLooked + (1 - kLooked) * double(i) / double(shots.size()));
    const Shot& shot = shots[i];
    const RenderSubject subject = subjects.get(shot.input);
    const Camera from = turned(camera, shot.angle);
    Picture picture = ofFile(inputs[shot.input].path, [&] {
      if (!subject.fog && !subject.surface) return renderFog(nothingToSee(), look, from, job.picture.render);
      return subject.fog ? renderFog(*subject.fog, look, from, job.picture.render)
                         : renderSurface(*subject.surface, from, job.picture.render, subject.colors.get());
    });
    if (job.take) job.take(picture, shot.number);
    written(output.add(picture, shot.number));
    if (job.sheet.empty()) continue;
    for (auto* unused : {&picture.mask, &picture.depth, &picture.normal}) *unused = {};
    tiles.push_back({std::move(picture), shot.caption});
  }
  written(output.finish());
  if (job.sheet.empty()) return;
  writePicture(job.sheet, contactSheet(tiles, job.columns));
  written(job.sheet);
}

}  // namespace slicemorph
