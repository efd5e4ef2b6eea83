#include "tools/job/run_retime.h"

#include "tools/job/frame_claims.h"
#include "tools/job/frame_maker.h"
#include "tools/job/frame_writer.h"
#include "tools/job/own_velocity.h"

#include <map>
#include <memory>
#include <optional>
#include <string>

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

/// The plans of pairs of neighbouring files, of which those around the last one asked for are kept.
class PairPlans {
 public:
  PairPlans(const RetimeJob& job, JobEvents& events) : job_(job), events_(events), quiet_(events) {}

  /// Reads and plans a pair and its neighbours. `done`: share of the whole job.
  FrameMaker& at(size_t pair, double done) {
    makers_.erase(makers_.begin(), makers_.lower_bound(pair > 0 ? pair - 1 : 0));
    makers_.erase(makers_.upper_bound(pair + 1), makers_.end());
    if (bent_ == pair) return *makers_.at(pair);
    const FrameMaker* before = pair > 0 ? &planned(pair - 1, done) : nullptr;
    FrameMaker& own = planned(pair, done);
    const FrameMaker* after = pair + 2 < job_.numbers.size() ? &planned(pair + 1, done) : nullptr;
    own.passSmoothly({before, before ? gap(pair) / gap(pair - 1) : 1},
                     {after, after ? gap(pair) / gap(pair + 1) : 1});
    bent_ = pair;
    return own;
  }

 private:
  FrameMaker& planned(size_t pair, double done) {
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
    maker->planFor(pair, job_.numbers[pair], done, done);
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
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameJob& frame = frames[i];
    events.throwIfCancelled();
    const double done = double(i) / double(frames.size());
    if (log.has(frame)) {
      events.fileWritten(frame.path, true);
      continue;
    }
    if (!claims.take(frame)) continue;
    events.report("making frames", done);
    if (!frame.given.empty()) {
      copyAtSpeed(frame, settings);
    } else {
      FrameMaker& maker = plans.at(frame.inputFrame, done);
      const FrameTask task = maker.taskOf(frame);
      writer.write(task, makeFrame(task, events));
    }
    log.add(frame, nullptr);
    claims.free();
    events.fileWritten(frame.path, false);
  }
  writer.finish(nullptr, 1);
  events.notes(claims.finish());
  log.finish();
}

}  // namespace slicemorph
