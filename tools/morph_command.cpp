#include "tools/morph_command.h"

#include "engine/errors.h"
#include "engine/peers/peers.h"
#include "tools/common_options.h"
#include "tools/dump_slices.h"
#include "tools/morph_report.h"
#include "tools/morph_settings.h"
#include "tools/resume_log.h"
#include "tools/terminal_progress.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

/// Shares of the whole job, for the progress line.
constexpr double kLoaded = 0.1, kPlanned = 0.25;

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void throwIfCancelled(const Progress& progress) {
  if (progress.cancelled()) throw Cancelled();
}

std::vector<LoadedObject> loadInputs(const MorphSettings& settings, TerminalProgress& progress) {
  std::vector<LoadedObject> loaded;
  for (const std::string& input : settings.inputs) {
    throwIfCancelled(progress);
    progress.report("reading", kLoaded * double(loaded.size()) / double(settings.inputs.size()));
    loaded.push_back(loadObject(input, settings.load));
    progress.clear();
    printNotes(input + ": ", loaded.back().notes, settings.quiet);
  }
  return loaded;
}

/// Makes the in-between of one frame; `index` into the settings' frames.
using FrameMaker = std::function<InBetween(size_t index)>;

struct Plan {
  FrameMaker make;
  std::vector<std::string> notes;
  std::optional<double> restDistance;  ///< of --method levelset, voxels
};

Plan planSlices(const MorphSettings& settings, const std::vector<LoadedObject>& loaded, Progress& progress) {
  std::vector<Object> objects;
  for (const LoadedObject& input : loaded) objects.push_back(input.object);
  const auto plan = std::make_shared<MorphPlan>(objects, settings.plan, &progress);
  if (!settings.sliceFolder.empty()) dumpSlices(settings.sliceFolder, plan->slicePictures(), settings.inputs);
  return {[plan, &settings](size_t i) { return plan->frame(settings.frames[i].weights); }, plan->notes(), {}};
}

Plan planSdf(const MorphSettings& settings, const std::vector<LoadedObject>& loaded) {
  std::vector<FloatGrid::ConstPtr> grids;
  double finest = std::numeric_limits<double>::max();
  for (const LoadedObject& input : loaded) {
    grids.push_back(input.object.levelSet);
    finest = std::min(finest, grids.back()->voxelSize()[0]);
  }
  const auto blend =
      std::make_shared<SdfBlend>(grids, settings.plan.voxelSize > 0 ? settings.plan.voxelSize : finest);
  return {[blend, &settings](size_t i) {
            return InBetween{blend->frame(settings.frames[i].weights), 0};
          },
          {},
          {}};
}

Plan planLevelSet(const MorphSettings& settings, const std::vector<LoadedObject>& loaded,
                  Progress& progress) {
  const auto result = std::make_shared<LevelSetMorphResult>(levelSetMorph(
      *loaded[0].object.levelSet, *loaded[1].object.levelSet, int(settings.frames.size()), 2000, &progress));
  const std::string rest = "the level set came to rest after " + std::to_string(result->steps) +
                           " steps, at most " + formatNumber(result->restDistance, 3) + " voxels from " +
                           settings.inputs[1];
  return {[result](size_t i) { return InBetween{result->frames[i], 0}; }, {rest}, result->restDistance};
}

Plan makePlan(const MorphSettings& settings, const std::vector<LoadedObject>& loaded, Progress& progress) {
  if (settings.method == Method::kSdf) return planSdf(settings, loaded);
  if (settings.method == Method::kLevelSet) return planLevelSet(settings, loaded, progress);
  return planSlices(settings, loaded, progress);
}

/// Makes, measures and writes the frames one after another: each uses all threads, and one at a time bounds
/// the memory.
class FrameRun {
 public:
  FrameRun(const MorphSettings& settings, const Plan& plan, bool halfFloat,
           const std::vector<ShapeMeasures>& inputs)
      : settings_(settings), plan_(plan), halfFloat_(halfFloat), inputs_(inputs), log_(settings) {}

  /// Returns the rows of the report, none where none is asked for.
  std::vector<Json> run(TerminalProgress& progress) {
    std::vector<Json> rows;
    const size_t count = settings_.frames.size();
    for (size_t i = 0; i < count; ++i) {
      throwIfCancelled(progress);
      progress.report("making frames", kPlanned + (1 - kPlanned) * double(i) / double(count));
      const FrameJob& job = settings_.frames[i];
      const bool done = log_.has(job) && (!measured() || log_.row(job).is_object());
      if (done) previous_ = nullptr;
      const Json row = done ? log_.row(job) : makeFrame(i);
      if (measured()) rows.push_back(row);
      if (!done) log_.add(job, row);
      progress.clear();
      if (!settings_.quiet) std::printf("%s%s\n", job.path.c_str(), done ? " (kept)" : "");
      std::fflush(stdout);
    }
    log_.remove();
    return rows;
  }

 private:
  bool measured() const { return !settings_.report.empty(); }

  Json makeFrame(size_t i) {
    const FrameJob& job = settings_.frames[i];
    FrameFigures figures;
    // After frames kept from an earlier run, the one before this is made once more to compare with.
    if (measured() && i > 0 && !previous_) previous_ = plan_.make(i - 1).surface;
    Stopwatch watch;
    const InBetween frame = plan_.make(i);
    figures.seconds.evaluate = watch.lap();
    if (measured()) {
      figures.voxelSize = frame.surface->voxelSize()[0];
      figures.foldShare = frame.foldShare;
      figures.shape = measureShape(*frame.surface);
      if (previous_) figures.symmetricDifference = overlap(*previous_, *frame.surface).symmetricDifference;
      previous_ = frame.surface;
      figures.seconds.measure = watch.lap();
    }
    SurfaceOutput options;
    options.halfFloat = halfFloat_;
    options.framesPerSecond = settings_.framesPerSecond;
    options.frame = job.number;
    writeSurface(job.path, *frame.surface, options);
    figures.seconds.write = watch.lap();
    return measured() ? describeFrame(job, figures, inputs_) : Json();
  }

  const MorphSettings& settings_;
  const Plan& plan_;
  const bool halfFloat_;
  const std::vector<ShapeMeasures>& inputs_;
  ResumeLog log_;
  FloatGrid::ConstPtr previous_;  ///< the frame before, kept for the report only
};

void runMorph(const MorphSettings& settings) {
  cancelOnInterrupt();
  TerminalProgress progress(settings.quiet);
  ReportParts report;
  Stopwatch watch;
  const std::vector<LoadedObject> loaded = loadInputs(settings, progress);
  report.loadSeconds = watch.lap();

  throwIfCancelled(progress);
  PartProgress planning(progress, kLoaded, kPlanned);
  planning.report("planning", 0);
  const Plan plan = makePlan(settings, loaded, planning);
  report.planSeconds = watch.lap();
  progress.clear();
  printNotes("", plan.notes, settings.quiet);

  if (!settings.report.empty())
    for (const LoadedObject& input : loaded) report.inputs.push_back(measureShape(*input.object.levelSet));
  const bool halfFloat =
      std::all_of(loaded.begin(), loaded.end(), [](const LoadedObject& input) { return input.halfFloat; });
  report.frames = FrameRun(settings, plan, halfFloat, report.inputs).run(progress);
  if (settings.report.empty()) return;

  for (size_t k = 0; k < loaded.size(); ++k)
    for (const std::string& note : loaded[k].notes) report.notes.push_back(settings.inputs[k] + ": " + note);
  report.notes.insert(report.notes.end(), plan.notes.begin(), plan.notes.end());
  report.restDistance = plan.restDistance;
  writeReport(settings, report);
}

}  // namespace

void addMorphCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("morph", "Morph shapes into each other: a sequence, or one blend");
  const auto options = std::make_shared<MorphOptionSet>(*command);
  command->callback([options] { runMorph(options->settings()); });
}

}  // namespace slicemorph
