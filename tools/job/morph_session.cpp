#include "tools/job/morph_session.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/carry_image.h"
#include "tools/job/frame_writer.h"
#include "tools/job/memory_need.h"
#include "tools/job/morph_checks.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// What a file of that name holds of a frame.
enum class FileKind { kGrids, kImage, kMesh };

FileKind kindOfFile(const std::string& path) {
  if (isGridOutput(path)) return FileKind::kGrids;
  return isImageOutput(path) ? FileKind::kImage : FileKind::kMesh;
}

/// Sets the caller's events for the time of a call.
template <typename Relay>
class Relayed {
 public:
  Relayed(Relay& relay, JobEvents& to) : relay_(relay) { relay_.to = &to; }
  ~Relayed() { relay_.to = nullptr; }

 private:
  Relay& relay_;
};

}  // namespace

MorphSession::MorphSession(const OptionSet& options, JobEvents& events)
    : job_(morphJob(options)), length_(lengthOfInputs(options)) {
  events.notes(job_.notes);
  for (size_t k = 0; k < settings().inputs.size(); ++k)
    if (!heldAt(settings().held, k)) options.about("inputs", [&] { checkInputExists(settings().inputs[k]); });
  moveTo(0, events);
}

void MorphSession::moveTo(size_t inputFrame, JobEvents& events) {
  const Relayed<Relay> relayed(events_, events);
  const int start = settings().options.start;
  if (at_ && (inputFrame == *at_ || !settings().moving())) return;
  // A plan follows that of the frame before.
  if (!at_ || inputFrame < *at_) at_.reset(), maker_ = std::make_unique<FrameMaker>(settings(), events_);
  const size_t next = at_ ? *at_ + 1 : 0;
  const double steps = double(inputFrame - next + 1);
  for (size_t i = next; i <= inputFrame; ++i) {
    // What fails half way leaves inputs of one frame and a plan of another: the next call begins anew.
    at_.reset();
    maker_->planFor(i, start + int(i), double(i - next) / steps, double(i - next + 1) / steps);
    at_ = i, labels_ = maker_->inputs()[0].labels;
    events_.throwIfCancelled();
  }
}

const MorphPlan& MorphSession::plan() const {
  if (settings().moving())
    throw InputError("of inputs that are sequences each frame has a map of its own; plan still ones");
  if (method().slices) return *method().slices;
  throw InputError("--method " + settings().method + " has no map that carries points");
}

void MorphSession::checkTime(double t) const {
  if (!(t >= 0 && t <= 1)) throw InputError("t = " + formatNumber(t) + " is no time; times are 0 to 1");
  if (settings().course.keys.empty())
    throw InputError("t = " + formatNumber(t) +
                     ": the plan is of one blend, by --weights, which has no times");
}

Weights MorphSession::weightsOf(double t) const {
  checkTime(t);
  return weightsAt(settings().course, t);
}

FrameJob MorphSession::frameAt(double t) const {
  checkTime(t);
  const MorphSettings& s = settings();
  const size_t count = s.frames.size();
  const int number = s.options.start + int(std::lround(t * double(count - 1)));
  if (!s.can().anyTime) {
    const FrameJob& nearest = s.frames[size_t(number - s.options.start)];
    if (std::abs(*nearest.t - t) < 1e-9) return nearest;
    throw InputError("t = " + formatNumber(t) + ": --method " + s.method + " has only the times of its " +
                     std::to_string(count) + " frames");
  }
  FrameJob job{number, t, weightsAt(s.course, t), "", size_t(std::lround(t * double(length_ - 1))), {}};
  if (count > 1) job.rate = rateAt(s, t, 1 / double(count - 1));
  return job;
}

FrameJob MorphSession::blendOf(const Weights& weights) const {
  const MorphSettings& s = settings();
  if (!s.can().anyTime) throw InputError("weights: --method " + s.method + " has no weights, only steps");
  const CheckedWeights checked = checkWeights("weights", weights, s.inputs.size());
  return {s.options.start, std::nullopt, checked.weights, "", 0, {}};
}

std::vector<FrameJob> MorphSession::frames(std::optional<int> count) const {
  const MorphSettings& s = settings();
  if (!count) return s.wantedFrames();
  checkRange("frames", *count, 1, 1000000);
  checkTime(0);
  if (!s.can().anyTime && size_t(*count) != s.frames.size())
    throw InputError(std::to_string(*count) + " frames: --method " + s.method + " was planned for " +
                     std::to_string(s.frames.size()));
  return framesAt(s, evenTimes(*count), s.options.start);
}

MorphFrame MorphSession::make(const FrameJob& job, JobEvents& events) {
  moveTo(job.inputFrame, events);
  return makeFrame(maker_->taskOf(job), events);
}

void MorphSession::refuseShape() const {
  throw InputError("--method " + settings().method + " blends values and makes no surface");
}

MorphFrame MorphSession::shapeOf(const FrameJob& job, JobEvents& events) {
  if (!settings().can().surface) refuseShape();
  moveTo(job.inputFrame, events);
  return coloredShape(maker_->taskOf(job));
}

void MorphSession::save(const std::string& path, const FrameJob& given, const MorphFrame& frame,
                        JobEvents& events) {
  moveTo(given.inputFrame, events);
  const Relayed<Relay> relayed(events_, events);
  MorphSettings s = settings();
  s.output = path;
  FrameJob job = given;
  job.path = path;
  s.frames = {job};
  const FrameTask as = maker_->taskOf(job);
  FramePlan plan = as.plan;
  const FileKind kind = kindOfFile(path);
  MorphFrame made = frame;
  if (kind == FileKind::kMesh) {
    if (!s.can().surface) refuseShape();
    if (!made.shape.surface) made = coloredShape(as);
    made.grids.clear(), made.image.reset();
  } else if (kind != kindOfFile(settings().output)) {
    plan.content = contentOf(s, as.inputs, true);
    if (plan.content.images) plan.images = planImages(s, as.inputs);
    made = makeFrame({s, as.inputs, plan, job}, events);
  }
  FrameWriter writer(s, events_);
  writer.write({s, as.inputs, plan, job}, made);
  Progress none;
  writer.finish(nullptr, none);
}

}  // namespace slicemorph
