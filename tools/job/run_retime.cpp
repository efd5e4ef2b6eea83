#include "tools/job/run_retime.h"

#include "tools/job/frame_claims.h"
#include "tools/job/frame_maker.h"
#include "tools/job/frame_writer.h"
#include "tools/job/own_velocity.h"
#include "tools/job/work_steps.h"

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace slicemorph {
namespace {

/// Passes everything on but notes: those of the first pair of files stand for those of the others.
class WithoutNotes : public JobEvents {
 public:
  explicit WithoutNotes(JobEvents& caller) : caller_(caller) {}
  void report(const char* stage, double fraction) override { caller_.report(stage, fraction); }
  bool cancelled() const override { return caller_.cancelled(); }

 private:
  JobEvents& caller_;
};

/// The grid by which all files of the sequence are read, of the first that holds something; empty where the sequence's
/// name says it. `events`: gets the note on the choice.
std::string gridOfSequence(const MorphSettings& settings, JobEvents& events) {
  const InputSpec input = parseInput(settings.options.input);
  if (!input.selection.empty()) return "";
  MovingInput files(input);
  LoadOptions options = settings.load;
  options.besides.push_back(files.file(1).path);
  size_t n = 0;
  LoadedObject loaded = files.load(n, options);
  while (loaded.nothing) loaded = files.load(++n, options);
  for (const Note& note : about(files.file(n).text, loaded.notes))
    if (note.code == "vdb.grid-chosen") events.note(note);
  return loaded.file->entries()[loaded.grid].name;
}

/// What planning a pair of files takes, in times of making one frame, for the progress; an estimate.
constexpr double kPairPlanned = 4;
/// And copying a file.
constexpr double kCopied = 0.1;

/// The number of pairs that are planned before each of some frames; see PairPlans::at. `pairs`: there are; `isMade`: whether
/// a frame is made, and no copy of a file nor there already.
template <typename IsMade>
std::vector<size_t> plansBefore(const std::vector<FrameJob>& frames, size_t pairs, const IsMade& isMade) {
  std::vector<size_t> counts;
  std::set<size_t> kept;
  for (const FrameJob& frame : frames) {
    counts.push_back(0);
    if (!isMade(frame)) continue;
    std::set<size_t> around;
    for (size_t pair = frame.inputFrame; pair < frame.inputFrame + 3; ++pair)
      if (pair > 0 && pair - 1 < pairs) around.insert(pair - 1);
    for (const size_t pair : around) counts.back() += kept.count(pair) == 0;
    kept = std::move(around);
  }
  return counts;
}

/// The plans of pairs of neighbouring files, of which those around the last one asked for are kept.
class PairPlans {
 public:
  PairPlans(const RetimeJob& job, JobEvents& events) : job_(job), events_(events), quiet_(events) {}

  /// Reads and plans a pair and its neighbours. `from`, `to`: fractions of the whole job at which this begins and ends.
  FrameMaker& at(size_t pair, double from, double to) {
    makers_.erase(makers_.begin(), makers_.lower_bound(pair > 0 ? pair - 1 : 0));
    makers_.erase(makers_.upper_bound(pair + 1), makers_.end());
    if (bent_ == pair) return *makers_.at(pair);
    const double third = (to - from) / 3;
    const FrameMaker* before = pair > 0 ? &planned(pair - 1, from, from + third) : nullptr;
    FrameMaker& own = planned(pair, from + third, from + 2 * third);
    const FrameMaker* after =
        pair + 2 < job_.numbers.size() ? &planned(pair + 1, from + 2 * third, to) : nullptr;
    own.passSmoothly({before, before ? gap(pair) / gap(pair - 1) : 1},
                     {after, after ? gap(pair) / gap(pair + 1) : 1});
    bent_ = pair;
    return own;
  }

 private:
  FrameMaker& planned(size_t pair, double from, double to) {
    std::unique_ptr<FrameMaker>& maker = makers_[pair];
    if (maker) return *maker;
    JobEvents& events = told_ ? quiet_ : events_;
    told_ = true;
    // One for both files of all pairs: else a frame would depend on which pair is read first.
    if (!grid_) grid_ = gridOfSequence(job_.settings, events);
    maker = std::make_unique<FrameMaker>(job_.settings, events, *grid_);
    // A file is the end of one pair and the beginning of the next.
    for (const auto& [other, made] : makers_)
      if (other + 1 == pair || other == pair + 1) maker->takeFilesFrom(*made);
    maker->planFor(pair, job_.numbers[pair], from, to);
    return *maker;
  }
  double gap(size_t pair) const { return job_.numbers[pair + 1] - job_.numbers[pair]; }

  const RetimeJob& job_;
  JobEvents& events_;
  WithoutNotes quiet_;
  bool told_ = false;
  std::optional<std::string> grid_;  ///< see gridOfSequence; found when the first pair is read
  std::map<size_t, std::unique_ptr<FrameMaker>> makers_;
  std::optional<size_t> bent_;  ///< the pair whose paths go on into its neighbours'
};

}  // namespace

void runRetime(const RetimeJob& job, JobEvents& events) {
  const MorphSettings& settings = job.settings;
  ResumeLog log(settings);
  events.notes(log.notes());
  FrameWriter writer(settings, events);
  FrameClaims claims(settings, log);
  PairPlans plans(job, events);
  const std::vector<FrameJob> frames = settings.wantedFrames();
  const auto isMade = [&](const FrameJob& frame) { return frame.given.empty() && !log.has(frame); };
  const std::vector<size_t> planned = plansBefore(frames, job.numbers.size() - 1, isMade);
  WorkSteps steps;  // of each frame planning and making
  for (size_t i = 0; i < frames.size(); ++i)
    steps.add(kPairPlanned * double(planned[i])), steps.add(isMade(frames[i])    ? 1
                                                            : log.has(frames[i]) ? 0
                                                                                 : kCopied);
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameJob& frame = frames[i];
    events.throwIfCancelled();
    if (log.has(frame)) {
      events.fileWritten(frame.path, true);
      continue;
    }
    if (!claims.take(frame)) continue;
    if (!frame.given.empty()) {
      copyAtSpeed(frame, settings);
    } else {
      FrameMaker& maker = plans.at(frame.inputFrame, steps.from(2 * i), steps.to(2 * i));
      events.report("making frames", steps.from(2 * i + 1));
      const FrameTask task = maker.taskOf(frame);
      writer.write(task, makeFrame(task, events));
    }
    events.report("making frames", steps.to(2 * i + 1));
    log.add(frame, nullptr);
    claims.free();
    events.fileWritten(frame.path, false);
  }
  writer.finish(nullptr, events);
  events.notes(claims.finish());
  log.finish();
}

}  // namespace slicemorph
