#include "tools/job/run_morph.h"

#include "slicemorph/errors.h"
#include "tools/job/frame_claims.h"
#include "tools/job/frame_maker.h"
#include "tools/job/frame_report.h"
#include "tools/job/frame_writer.h"
#include "tools/job/resume_log.h"
#include "tools/job/stopwatch.h"
#include "tools/job/work_steps.h"

#include <algorithm>
#include <memory>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

// What the steps of a job take, in times of making one frame at kUsualResolution, for the progress; measured on blade to
// creature at 128 voxels, whose frames take a quarter of that.
/// Reading and planning, and both by a plan that was made before. That hardly depends on the voxels.
constexpr double kPlanned = 17, kReadPlan = 3;
/// The same for a further frame, where inputs are sequences.
constexpr double kPlannedNext = 1.5;
/// Making a frame, and measuring it for a report.
constexpr double kMade = 1, kMeasured = 1;
/// Voxels along an object where nothing is said, as kDefaultResolution of the inputs.
constexpr int kUsualResolution = 256;
/// Following the surface through a frame, where all are put into one .glb, and for the page of a report; an estimate.
constexpr double kFollowed = 1, kFollowedInPage = 0.2;
/// A page shows so many frames at most (tools/report/report_page.cpp).
constexpr size_t kPageFrames = 24;

/// The end of the frames that are to be made: the number of those that have to be gone through.
size_t endOfFrames(const MorphSettings& settings) {
  size_t end = settings.frames.size();
  while (end > 0 && !settings.frames[end - 1].wanted) --end;
  return end;
}

/// The steps of a job, as numbers in WorkSteps.
struct MorphSteps {
  WorkSteps all;
  std::vector<size_t> planned, made;  ///< of each frame of the sequence up to the last one
  size_t followed = 0, reported = 0;  ///< see kFollowed
};

/// `isDone`: whether the frame of an index is there from an earlier run, so that it costs nothing.
template <typename IsDone>
MorphSteps stepsOf(const MorphSettings& settings, size_t end, const FrameReport& report,
                   const IsDone& isDone) {
  MorphSteps steps;
  size_t made = 0;
  const double finer = settings.load.resolution > 0 ? settings.load.resolution / double(kUsualResolution) : 1;
  // Surfaces have so many voxels.
  const double cost = (kMade + (report.wanted() ? kMeasured : 0)) * finer * finer;
  for (size_t i = 0; i < end; ++i) {
    const bool makes = settings.frames[i].wanted && !isDone(i);
    const bool stays = i > 0 && (!settings.moving() || (!settings.planFile.empty() && !makes));
    const double first = settings.planFile.empty() ? kPlanned : kReadPlan;
    steps.planned.push_back(steps.all.add(stays ? 0 : i == 0 ? first : kPlannedNext));
    steps.made.push_back(steps.all.add(makes ? cost : 0));
    made += makes;
  }
  steps.followed = steps.all.add(settings.oneGlb() ? kFollowed * finer * finer * double(made) : 0);
  steps.reported = steps.all.add(report.hasPage() ? kFollowedInPage * double(std::min(end, kPageFrames)) : 0);
  return steps;
}

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
  const MorphSteps steps = stepsOf(settings, end, report, isDone);
  // One frame after another: each uses all threads, and this bounds the memory. Also those that are left out are gone
  // through: of sequences the plan of each follows that of the one before.
  for (size_t i = 0; i < end; ++i) {
    const bool nextIsMade = i + 1 < end && jobs[i + 1].wanted && !isDone(i + 1);
    // The first frame tells how inputs are placed, and which options they ask for.
    if (!settings.planFile.empty() && i > 0 && !jobs[i].wanted && !(nextIsMade && report.wanted())) continue;
    maker.moveTo(i, steps.all.from(steps.planned[i]), steps.all.to(steps.planned[i]));
    if (i == 0) writer.prepare(maker, steps.all.to(steps.planned[i]));
    events.throwIfCancelled();
    const bool kept = jobs[i].wanted && isDone(i);
    if (jobs[i].wanted && !kept && (settings.oneFile() || claims.take(jobs[i]))) {
      events.report("making frames", steps.all.from(steps.made[i]));
      log.add(jobs[i], makeAndWrite(maker.task(), writer, report, events));
      events.report("making frames", steps.all.to(steps.made[i]));
      if (!settings.oneFile()) claims.free(), events.fileWritten(jobs[i].path, false);
      continue;
    }
    if (kept) report.addKept(maker.task(), log.row(jobs[i])), events.fileWritten(jobs[i].path, true);
    if (nextIsMade) report.compareWith(maker.task());
  }
  PartProgress following(events, steps.all.from(steps.followed), steps.all.to(steps.followed));
  writer.finish(maker.commonPlan(), following);
  claims.free();
  events.notes(claims.finish());
  log.finish();
  PartProgress reporting(events, steps.all.from(steps.reported), steps.all.to(steps.reported));
  report.write(maker, events.kept(), reporting);
}

}  // namespace slicemorph
