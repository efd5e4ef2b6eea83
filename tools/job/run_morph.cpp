#include "tools/job/run_morph.h"

#include "slicemorph/errors.h"
#include "tools/job/frame_claims.h"
#include "tools/job/frame_maker.h"
#include "tools/job/frame_report.h"
#include "tools/job/frame_writer.h"
#include "tools/job/resume_log.h"
#include "tools/job/stopwatch.h"

#include <algorithm>
#include <memory>

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

/// The end of the frames that are to be made: the number of those that have to be gone through.
size_t endOfFrames(const MorphSettings& settings) {
  size_t end = settings.frames.size();
  while (end > 0 && !settings.frames[end - 1].wanted) --end;
  return end;
}

/// A frame's part of the job's progress, 0 to 1.
struct FrameSteps {
  double from, planned;  ///< begin and end of reading and planning
  double made;           ///< begin of making the frame
};

/// `index`: of the frame in the whole sequence. Frames that --range leaves out only count where plans follow them.
FrameSteps stepsOf(const MorphSettings& settings, size_t index) {
  const std::vector<FrameJob>& frames = settings.frames;
  const auto counted = [&](size_t end) {
    if (settings.moving()) return double(end);
    return double(std::count_if(frames.begin(), frames.begin() + std::ptrdiff_t(end),
                                [](const FrameJob& frame) { return frame.wanted; }));
  };
  const double step = (settings.oneFile() ? kFramesMade : 1) / counted(endOfFrames(settings));
  if (!settings.moving()) return {0, kPlanned, kPlanned + (1 - kPlanned) * counted(index) * step};
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
Json makeAndWrite(const FrameTask& task, FrameWriter& writer, FrameReport& report, const Progress& cancel) {
  Stopwatch watch;
  const MorphFrame frame = makeFrame(task, cancel);
  const double evaluate = watch.lap();
  FrameFigures figures = report.measure(task, frame);
  const double measure = watch.lap();
  writer.write(task, frame);
  figures.seconds = {evaluate, measure, watch.lap()};
  report.addToPage(task, frame);
  return report.addRow(figures, task.inputs);
}

/// All frames as one, for the claim on a file that holds them all.
FrameJob wholeOf(const MorphSettings& settings) {
  FrameJob whole = settings.frames.front();
  whole.path = settings.output;
  return whole;
}

/// Reports have no frames of their own: each process needs its own one. Throws IoError.
std::vector<std::unique_ptr<FileClaim>> claimReports(const std::vector<std::string>& reports) {
  std::vector<std::unique_ptr<FileClaim>> claims;
  for (const std::string& report : reports) {
    claims.push_back(std::make_unique<FileClaim>(report, "report"));
    if (!claims.back()->held())
      throw IoError(report, "is the --report of " + claims.back()->other().name() +
                                ", too; give each process that makes some of the frames its own (" +
                                claimFileOf(report) + " says so; delete it if that process has ended)");
  }
  return claims;
}

}  // namespace

void runMorph(const MorphSettings& settings, JobEvents& caller) {
  NoteKeeper events(caller);
  FrameMaker maker(settings, events);
  ResumeLog log(settings);
  events.notes(log.notes());
  FrameWriter writer(settings, events);
  FrameReport report(settings);
  const auto reportClaims = claimReports(settings.reports);
  FrameClaims claims(settings, log);
  if (settings.oneFile() && !claims.take(wholeOf(settings))) return events.notes(claims.finish());
  const std::vector<FrameJob>& jobs = settings.frames;
  const size_t end = endOfFrames(settings);
  const auto isDone = [&](size_t i) {
    return log.has(jobs[i]) && (!report.wanted() || log.row(jobs[i]).is_object());
  };
  // One frame after another: each uses all threads, and this bounds the memory. Also those that are left out are gone
  // through: of sequences the plan of each follows that of the one before.
  for (size_t i = 0; i < end; ++i) {
    const FrameSteps steps = stepsOf(settings, i);
    const bool nextIsMade = i + 1 < end && jobs[i + 1].wanted && !isDone(i + 1);
    // The first frame tells how inputs are placed, and which options they ask for.
    if (!settings.planFile.empty() && i > 0 && !jobs[i].wanted && !(nextIsMade && report.wanted())) continue;
    maker.moveTo(i, steps.from, steps.planned);
    if (i == 0) writer.prepare(maker, steps.planned);
    events.throwIfCancelled();
    const bool kept = jobs[i].wanted && isDone(i);
    if (jobs[i].wanted && !kept && (settings.oneFile() || claims.take(jobs[i]))) {
      events.report("making frames", steps.made);
      log.add(jobs[i], makeAndWrite(maker.task(), writer, report, events));
      if (!settings.oneFile()) claims.free(), events.fileWritten(jobs[i].path, false);
      continue;
    }
    if (kept) report.addKept(maker.task(), log.row(jobs[i])), events.fileWritten(jobs[i].path, true);
    if (nextIsMade) report.compareWith(maker.task());
  }
  writer.finish(maker.commonPlan(), kPlanned + (1 - kPlanned) * kFramesMade);
  claims.free();
  events.notes(claims.finish());
  log.finish();
  report.write(maker, events.kept(), events);
}

}  // namespace slicemorph
