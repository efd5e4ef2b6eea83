#include "tools/commands/morph_command.h"

#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/commands/common_options.h"
#include "tools/commands/morph_options.h"
#include "tools/commands/terminal_progress.h"
#include "tools/job/frame_images.h"
#include "tools/job/frame_maker.h"
#include "tools/job/morph_settings.h"
#include "tools/job/resume_log.h"
#include "tools/job/stopwatch.h"
#include "tools/report/morph_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;
using openvdb::GridBase;

/// Shares of the whole job, for the progress line, where the inputs stay the same.
constexpr double kPlanned = 0.25;
/// And of one frame's share, where they play.
constexpr double kFramePlanned = 0.6;
/// The frames' share where they are then put into one .glb.
constexpr double kFramesMade = 0.5;

GridFigures figuresOf(const GridBase& grid) {
  GridFigures figures{grid.getName(), grid.activeVoxelCount(), {}, {}};
  grid.apply<openvdb::TypeList<FloatGrid, openvdb::DoubleGrid>>([&](const auto& scalars) {
    double total = 0, peak = -std::numeric_limits<double>::infinity();
    for (auto value = scalars.cbeginValueOn(); value; ++value) {
      total += double(*value) * double(value.getVoxelCount());
      peak = std::max(peak, double(*value));
    }
    figures.total = total * std::abs(grid.transform().voxelVolume());
    if (std::isfinite(peak)) figures.peak = peak;
  });
  return figures;
}

Mesh coloredSurface(const MorphFrame& frame) {
  Mesh mesh = surfaceOf(*frame.shape.surface);
  if (frame.colors) mesh.colors = colorsAt(*frame.colors, mesh.points);
  return mesh;
}

/// Makes, measures and writes the frames one after another: each uses all threads, and one at a time bounds
/// the memory.
class FrameRun {
 public:
  FrameRun(const MorphSettings& settings, FrameMaker& maker, TerminalProgress& progress)
      : settings_(settings),
        maker_(maker),
        progress_(progress),
        log_(settings),
        page_(settings),
        images_(settings, progress) {}

  /// Returns the rows of the report, none where none is asked for.
  std::vector<Json> run() {
    std::vector<Json> rows;
    const size_t count = settings_.frames.size();
    const bool moving = settings_.moving();
    for (size_t i = 0; i < count; ++i) {
      const double step = (settings_.oneGlb() ? kFramesMade : 1) / double(count),
                   from = moving ? double(i) * step : 0;
      maker_.moveTo(i, from, moving ? from + kFramePlanned * step : kPlanned);
      if (i == 0 && settings_.toFrameImages()) prepareImages(moving ? from : kPlanned);
      takeNotes();
      if (progress_.cancelled()) throw Cancelled();
      progress_.report("making frames",
                       moving ? from + kFramePlanned * step : kPlanned + (1 - kPlanned) * double(i) * step);
      const FrameJob& job = settings_.frames[i];
      const bool done = isDone(i);
      const Json row = done ? log_.row(job) : makeFrame(i);
      // The frame after the kept ones is compared with the last of these.
      if (done) previous_ = measured() && i + 1 < count && !isDone(i + 1) ? maker_.shape().surface : nullptr;
      if (done && settings_.hasPage() && page_.has(i)) addToPage(i, maker_.coloredShape());
      if (measured()) rows.push_back(row);
      if (!done) log_.add(job, row);
      progress_.clear();
      if (!settings_.oneGlb()) print(job.path, done ? " (kept)" : "");
    }
    if (settings_.oneGlb()) writeMeshes();
    log_.remove();
    return rows;
  }

  const Notes& notes() const { return notes_; }
  PageParts page() {
    PageParts parts;
    if (settings_.hasPage()) parts = page_.finish(commonPlan(), progress_);
    progress_.clear();
    return parts;
  }

 private:
  bool measured() const { return !settings_.reports.empty(); }
  bool isDone(size_t i) const {
    const FrameJob& job = settings_.frames[i];
    return log_.has(job) && (!measured() || log_.row(job).is_object());
  }

  void print(const std::string& path, const char* remark = "") const {
    if (!settings_.quiet) std::printf("%s%s\n", path.c_str(), remark);
    std::fflush(stdout);
  }

  void takeNotes() { takeNotes(maker_.takeNotes()); }
  void takeNotes(const Notes& notes) {
    if (notes.empty()) return;
    progress_.clear();
    printNotes("", notes, settings_.quiet);
    notes_.insert(notes_.end(), notes.begin(), notes.end());
  }

  void prepareImages(double from) {
    PartProgress looking(progress_, from, from);
    images_.prepare(maker_, looking);
    takeNotes(images_.takeNotes());
  }

  Json makeFrame(size_t i) {
    const FrameJob& job = settings_.frames[i];
    FrameFigures figures;
    Stopwatch watch;
    const MorphFrame frame = maker_.make();
    figures.seconds.evaluate = watch.lap();
    if (measured()) measure(frame, figures);
    figures.seconds.measure = watch.lap();
    if (settings_.toFrameImages()) {
      images_.write(job, frame);
      takeNotes(images_.takeNotes());
    } else if (frame.image) {
      writeImage(job.path, *frame.image);
    } else if (settings_.oneGlb()) {
      surfaces_.push_back({frame.shape.surface, job.weights, frame.colors});
    } else if (OutputName(job.path).extension() == ".glb") {
      Mesh mesh = coloredSurface(frame);
      MovingMesh still{0, std::move(mesh.triangles), {std::move(mesh.points)}, {}};
      if (!mesh.colors.empty()) still.colors = {std::move(mesh.colors)};
      writeGlb(job.path, {std::move(still)}, settings_.framesPerSecond, settings_.glb);
    } else if (frame.grids.empty()) {
      writeMesh(job.path, coloredSurface(frame));
    } else {
      VdbOutput options = maker_.fileOptions();
      options.framesPerSecond = settings_.framesPerSecond;
      options.frame = job.number;
      writeVdb(job.path, frame.grids, options);
    }
    figures.seconds.write = watch.lap();
    if (settings_.hasPage() && page_.has(i)) addToPage(i, frame);
    if (!measured()) return Json();
    std::vector<ShapeMeasures> inputs;
    for (const LoadedObject& input : maker_.inputs()) inputs.push_back(measuresOf(input.object.levelSet));
    return describeFrame(job, figures, inputs);
  }

  /// The plan of all frames; null where each has its own, or the method none.
  const MorphPlan* commonPlan() const { return settings_.moving() ? nullptr : maker_.slicePlan(); }

  void addToPage(size_t i, const MorphFrame& frame) {
    const FloatGrid::ConstPtr surface = frame.shape.surface;
    if (surface && !surface->empty()) page_.add(i, *surface, frame.colors.get());
  }

  /// All frames into one file.
  void writeMeshes() {
    PartProgress following(progress_, kPlanned + (1 - kPlanned) * kFramesMade, 1);
    const std::vector<MovingMesh> meshes = followSurfaces(surfaces_, commonPlan(), {}, &following);
    surfaces_.clear();
    progress_.clear();
    takeNotes({describe(meshes)});
    writeGlb(settings_.output, meshes, settings_.framesPerSecond, settings_.glb);
    print(settings_.output);
  }

  std::string describe(const std::vector<MovingMesh>& meshes) const {
    std::string runs;
    for (const MovingMesh& m : meshes) {
      runs += (runs.empty() ? "" : ", ") + std::to_string(m.first + 1);
      if (m.points.size() > 1) runs += "-" + std::to_string(m.first + m.points.size());
    }
    if (meshes.size() == 1)
      return settings_.output + ": one mesh" +
             (meshes[0].points.size() > 1 ? " with a morph target for each frame" : "");
    return settings_.output + ": " + std::to_string(meshes.size()) +
           " meshes, each shown in its own frames, as none fits the surfaces of all: frames " + runs;
  }

  void measure(const MorphFrame& frame, FrameFigures& figures) {
    for (const GridBase::ConstPtr& grid : frame.grids) figures.grids.push_back(figuresOf(*grid));
    if (frame.image && maker_.inputs()[0].labels) figures.labels = measureLabels(*frame.image);
    if (frame.image && !maker_.inputs()[0].labels)
      figures.labels = {measureAbove(*frame.image, maker_.iso())};
    figures.voxelSize = frame.grids.empty() ? 0 : frame.grids[0]->voxelSize()[0];
    const FloatGrid::ConstPtr surface = frame.shape.surface;
    if (!surface) return;
    figures.voxelSize = surface->voxelSize()[0];
    figures.foldShare = frame.shape.foldShare;
    figures.shape = measureShape(*surface);
    if (previous_) figures.symmetricDifference = overlap(*previous_, *surface).symmetricDifference;
    previous_ = surface;
  }

  ShapeMeasures measuresOf(const FloatGrid::ConstPtr& levelSet) {
    if (measures_.size() > 8) measures_.clear();  // of a sequence's frames that are over
    const auto [at, fresh] = measures_.try_emplace(levelSet);
    if (fresh) at->second = measureShape(*levelSet);
    return at->second;
  }

  const MorphSettings& settings_;
  FrameMaker& maker_;
  TerminalProgress& progress_;
  ResumeLog log_;
  Notes notes_;
  PageShapes page_;
  FrameImages images_;
  std::vector<SurfaceFrame> surfaces_;  ///< of all frames, for one .glb
  FloatGrid::ConstPtr previous_;        ///< the frame before, kept for the report only
  std::map<FloatGrid::ConstPtr, ShapeMeasures> measures_;
};

void runMorph(const MorphSettings& settings) {
  cancelOnInterrupt();
  TerminalProgress progress(settings.quiet);
  FrameMaker maker(settings, progress);
  FrameRun run(settings, maker, progress);
  ReportParts report;
  report.frames = run.run();
  if (settings.reports.empty()) return;
  for (const LoadedObject& input : maker.inputs())
    report.inputs.push_back(measureShape(*input.object.levelSet));
  report.notes = run.notes();
  report.page = run.page();
  report.loadSeconds = maker.loadSeconds(), report.planSeconds = maker.planSeconds();
  report.restDistance = maker.restDistance();
  if (const MorphPlan* plan = maker.slicePlan()) {
    if (!settings.landmarks.empty()) report.landmarks = landmarkErrors(settings.landmarks, *plan);
    if (!settings.checkLandmarks.empty())
      report.checkLandmarks = landmarkErrors(settings.checkLandmarks, *plan);
  }
  writeReports(settings, report);
}

}  // namespace

void addMorphCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "morph", "Morph shapes, fog volumes or images into each other: a sequence, or one blend");
  const auto options = std::make_shared<MorphOptionSet>(*command);
  command->callback([options] { runMorph(options->settings()); });
}

}  // namespace slicemorph
