#include "tools/job/run_morph.h"

#include "tools/job/frame_maker.h"
#include "tools/job/frame_report.h"
#include "tools/job/frame_writer.h"
#include "tools/job/resume_log.h"
#include "tools/job/stopwatch.h"

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

// Shares for the progress line, measured on jobs of 24 frames.
/// Reading and planning in the whole job, where the inputs stay the same.
constexpr double kPlanned = 0.25;
/// Reading and planning in the time of one frame, where inputs are sequences.
constexpr double kFramePlanned = 0.6;
/// Making the frames in the rest of the job, where they are then put into one .glb.
constexpr double kFramesMade = 0.5;

/// A frame's part of the job's progress, 0 to 1.
struct FrameSteps {
  double from, planned;  ///< begin and end of reading and planning
  double made;           ///< begin of making the frame
};

FrameSteps stepsOf(const MorphSettings& settings, size_t index) {
  const double step = (settings.oneGlb() ? kFramesMade : 1) / double(settings.frames.size());
  if (!settings.moving()) return {0, kPlanned, kPlanned + (1 - kPlanned) * double(index) * step};
  const double from = double(index) * step, planned = from + kFramePlanned * step;
  return {from, planned, planned};
}

/// Passes events on and keeps the notes, for the report.
class NoteKeeper : public JobEvents {
 public:
  explicit NoteKeeper(JobEvents& caller) : caller_(caller) {}
  void report(const char* stage, double fraction) override { caller_.report(stage, fraction); }
  bool cancelled() const override { return caller_.cancelled(); }
  void note(const Note& note) override { caller_.note(note), kept_.push_back(note); }
  void fileWritten(const std::string& path, bool kept) override { caller_.fileWritten(path, kept); }
  const Notes& kept() const { return kept_; }

 private:
  JobEvents& caller_;
  Notes kept_;
};

/// Makes, measures and writes one frame. Returns its row of the report.
Json makeAndWrite(size_t index, const FrameTask& task, FrameWriter& writer, FrameReport& report,
                  const Progress& cancel) {
  Stopwatch watch;
  const MorphFrame frame = makeFrame(task, cancel);
  const double evaluate = watch.lap();
  FrameFigures figures = report.measure(task, frame);
  const double measure = watch.lap();
  writer.write(task, frame);
  figures.seconds = {evaluate, measure, watch.lap()};
  report.addToPage(index, task, frame);
  return report.addRow(figures, task.inputs);
}

}  // namespace

void runMorph(const MorphSettings& settings, JobEvents& caller) {
  NoteKeeper events(caller);
  FrameMaker maker(settings, events);
  ResumeLog log(settings);
  events.notes(log.notes());
  FrameWriter writer(settings, events);
  FrameReport report(settings);
  const std::vector<FrameJob>& jobs = settings.frames;
  const auto isDone = [&](size_t i) {
    return i < jobs.size() && log.has(jobs[i]) && (!report.wanted() || log.row(jobs[i]).is_object());
  };
  // One frame after another: each uses all threads, and this bounds the memory.
  for (size_t i = 0; i < jobs.size(); ++i) {
    const FrameSteps steps = stepsOf(settings, i);
    maker.moveTo(i, steps.from, steps.planned);
    if (i == 0) writer.prepare(maker, steps.planned);
    events.throwIfCancelled();
    events.report("making frames", steps.made);
    const bool kept = isDone(i);
    if (kept)
      report.addKept(i, maker.task(), log.row(jobs[i]), i + 1 < jobs.size() && !isDone(i + 1));
    else
      log.add(jobs[i], makeAndWrite(i, maker.task(), writer, report, events));
    if (!settings.oneGlb()) events.fileWritten(jobs[i].path, kept);
  }
  writer.finish(maker.commonPlan(), kPlanned + (1 - kPlanned) * kFramesMade);
  log.remove();
  report.write(maker, events.kept(), events);
}

}  // namespace slicemorph
