#include "tools/job/frame_maker.h"

#include "slicemorph/errors.h"
#include "tools/job/carry_image.h"
#include "tools/job/memory_need.h"
#include "tools/job/one_world.h"
#include "tools/job/plan_file.h"
#include "tools/job/stopwatch.h"
#include "tools/report/dump_slices.h"

namespace slicemorph {
namespace {

/// Share of reading in the time for reading and planning; only the progress display depends on it.
constexpr double kReadShare = 0.1;

/// Progress of planning in even time. The engine's fractions are those of its steps: distances and slices are done at a
/// twentieth, contours are matched and bodies bent between a tenth and a fifth, then follow rounds. What these take of the
/// time was measured on blade to creature.
class PlanProgress : public Progress {
 public:
  PlanProgress(Progress& whole, double from, double to) : part_(whole, from, to) {}
  void report(const char* stage, double fraction) override { part_.report(stage, inTime(fraction)); }
  bool cancelled() const override { return part_.cancelled(); }

 private:
  static double inTime(double fraction) {
    constexpr double kSteps[] = {0, 0.05, 0.1, 0.2, 1}, kTimes[] = {0, 0.25, 0.27, 0.75, 1};
    size_t k = 1;
    while (k < 4 && fraction > kSteps[k]) ++k;
    const double share = (fraction - kSteps[k - 1]) / (kSteps[k] - kSteps[k - 1]);
    return kTimes[k - 1] + share * (kTimes[k] - kTimes[k - 1]);
  }

  PartProgress part_;
};

/// What an action returns; its errors in decisions name the file that they are from.
template <typename Action>
MethodPlan inFile(const std::string& file, const Action& action) {
  try {
    return action();
  } catch (const InputError& error) {
    throw IoError(file, error.what());
  }
}

}  // namespace

FrameMaker::FrameMaker(const MorphSettings& settings, JobEvents& events, const std::string& grid)
    : settings_(settings), events_(events), inputs_(settings, grid), options_(settings.plan) {
  events.notes(inputs_.notes(settings.frames.back().inputFrame + 1));
}

void FrameMaker::complete() {
  if (settings_.alignGiven || !settings_.can().guided) return;
  PlanOptions found = optionsInOneWorld(options_, inputs(), settings_.inputs);
  options_ = std::move(found.options);
  events_.notes(found.notes);
}

void FrameMaker::moveTo(size_t index, double from, double to) {
  index_ = index;
  const FrameJob& job = settings_.frames[index];
  planFor(job.inputFrame, job.number, from, to);
}

void FrameMaker::planFor(size_t inputFrame, int number, double from, double to) {
  Stopwatch watch;
  const double read = from + kReadShare * (to - from);
  PartProgress reading(events_, from, read);
  PlanProgress planning(events_, read, to);
  const FrameInputs::Step step = inputs_.moveTo(inputFrame, reading);
  // Notes on the first files of a sequence stand for those on the others.
  if (!planned_) events_.notes(step.notes);
  events_.notes(step.nothing);
  seconds_.load += watch.lap();
  if (!step.changed) return;
  events_.throwIfCancelled();

  if (!planned_) complete();
  if (settings_.can().guided) require(settings_.load.memory, "", needOfMorph(inputs()));
  plan_.content = contentOf(settings_, inputs(), !planned_);
  events_.notes(plan_.content.notes);
  const bool images = plan_.content.images || plan_.content.labelFigures;
  plan_.images = images ? planImages(settings_, inputs()) : ImagePlan();
  events_.notes(plan_.images.notes);
  if (images) require(settings_.load.memory, settings_.output, needOfImage(plan_.images.lattice, 1));
  planning.report("planning", 0);
  const MethodPlan* before = planned_ && !settings_.eachAlone ? &plan_.method : nullptr;
  MethodTask task{settings_, inputs(), number, before, planning, &options_};
  std::string decisions;
  if (!settings_.planFile.empty()) {
    // Plans count the inputs' frames, whatever numbers the job's have.
    const OutputName name(settings_.planFile);
    if (name.isSequence() && !firstPlan_) firstPlan_ = firstPlanNumber(settings_.planFile);
    const std::string file = name.path(firstPlan_.value_or(0) + int(inputFrame));
    decisions = readPlanFile(file).decisions, task.decisions = &decisions;
    plan_.method = inFile(file, [&] { return methodNamed(settings_.method).plan(task); });
  } else {
    plan_.method = methodNamed(settings_.method).plan(task);
  }
  // Of plans that were decided before each has the notes of all.
  if (!planned_ || settings_.planFile.empty()) events_.notes(plan_.method.notes);
  if (!planned_ && plan_.method.slices && !settings_.sliceFolder.empty())
    dumpSlices(settings_.sliceFolder, plan_.method.slices->slicePictures(), settings_.inputs);
  planned_ = true;
  seconds_.plan += watch.lap();
}

void FrameMaker::passSmoothly(const Neighbour& before, const Neighbour& after) {
  if (!plan_.method.slices) return;
  const auto stretch = [](const Neighbour& of) {
    return MorphPlan::Stretch{of.maker ? of.maker->plan_.method.slices.get() : nullptr, of.ratio};
  };
  plan_.method.slices->passSmoothly(stretch(before), stretch(after));
}

VdbOutput fileOptionsOf(const std::vector<LoadedObject>& inputs) {
  VdbOutput options;
  for (const LoadedObject& input : inputs)
    if (input.file) {
      options.metadata = input.file->metadata();
      options.compression = input.file->compression();
      break;
    }
  return options;
}

}  // namespace slicemorph
