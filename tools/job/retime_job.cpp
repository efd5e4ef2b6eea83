#include "tools/job/retime_job.h"

#include "tools/job/frame_range.h"
#include "tools/job/image_lattice.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"
#include "tools/job/plan_settings.h"
#include "tools/job/usd_settings.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace slicemorph {
namespace {

/// Nearer to a file's number than this a frame is that file.
constexpr double kSameNumber = 1e-6;
constexpr double kMostFrames = 1e6;

/// The number of the file that an output frame shows, or a number between two of them, and how it changes.
struct ShownTime {
  int frame = 1;
  double at = 0, speed = 1;  ///< speed: file numbers per output frame
};

/// A key of --curve: at this frame of the output that file is shown.
struct CurveKey {
  double frame = 0, at = 0;
};

std::vector<InputFrame> filesOf(const OptionSet& options) {
  const std::string& text = options.values().input;
  const InputSpec input = parseInput(text);
  if (!input.isMoving() || !input.isGrids())
    options.refuse("input", text +
                                " is no sequence of VDB files; expected for example smoke.####.vdb, or "
                                "smoke.####.vdb@10-40 for some of them");
  if (input.placing.given())
    options.refuse("input", text + ": files are shown where they are; leave out " + input.placing.text);
  std::vector<InputFrame> files = framesOf(input);
  if (files.size() < 2) options.refuse("input", text + " is one file; frames between files need two or more");
  return files;
}

/// `FRAME@FILE FRAME@FILE ...`, separated by spaces or commas.
std::vector<CurveKey> parseCurve(const std::string& text) {
  const std::string said = "--curve " + text + ": ";
  std::string items = text;
  std::replace(items.begin(), items.end(), ',', ' ');
  std::vector<CurveKey> keys;
  for (const std::string& item : parted(items, ' ')) {
    if (item.empty()) continue;
    char *behind = nullptr, *end = nullptr;
    CurveKey key;
    key.frame = std::strtod(item.c_str(), &behind);
    if (behind != item.c_str() && *behind == '@') key.at = std::strtod(behind + 1, &end);
    if (!end || *end || end == behind + 1 || !std::isfinite(key.frame) || !std::isfinite(key.at) ||
        key.frame != std::round(key.frame))
      throw InputError(said + "'" + item +
                       "' is not understood; expected frames of the output, each with the number of the "
                       "file that it shows: 1001@6 1024@8.5 1040@10");
    if (!keys.empty() && !(key.frame > keys.back().frame))
      throw InputError(said + "frame " + formatNumber(key.frame) + " does not follow frame " +
                       formatNumber(keys.back().frame) + "; frames must rise");
    keys.push_back(key);
  }
  if (keys.size() < 2) throw InputError(said + "expected two keys or more: 1001@6 1040@10");
  return keys;
}

/// The course of numbers over the frames of keys, as that of weights of two files, the first and the last, between
/// which times are interpolated.
WeightCourse courseOfCurve(const std::vector<CurveKey>& keys, double first, double last,
                           const std::string& timing) {
  std::vector<WeightKey> weights;
  const double begin = keys.front().frame, length = keys.back().frame - begin;
  for (const CurveKey& key : keys) {
    const double share = (key.at - first) / (last - first);
    weights.push_back({(key.frame - begin) / length, {1 - share, share}});
  }
  return courseOf(std::move(weights), timingNamed(timing), Easing());
}

std::vector<ShownTime> timesOfCurve(const OptionSet& options, double first, double last) {
  const std::string& text = options.values().curve;
  const std::vector<CurveKey> keys = options.about("curve", [&] { return parseCurve(text); });
  for (const CurveKey& key : keys)
    if (key.at < first || key.at > last)
      options.refuse("curve", "--curve " + text + ": there is no file " + formatNumber(key.at) +
                                  "; there are " + formatNumber(first) + " to " + formatNumber(last));
  const WeightCourse course = courseOfCurve(keys, first, last, options.values().timing);
  const double begin = keys.front().frame, length = keys.back().frame - begin;
  std::vector<ShownTime> times;
  for (double frame = begin; frame <= keys.back().frame; ++frame) {
    const double t = (frame - begin) / length;
    const double share = std::min(std::max(weightsAt(course, t)[1], 0.0), 1.0);
    times.push_back(
        {int(frame), first + share * (last - first), slopeAt(course, t)[1] * (last - first) / length});
  }
  return times;
}

/// At even speed from the first file to the last.
std::vector<ShownTime> evenTimes(const OptionSet& options, double first, double last) {
  const JobOptions& given = options.values();
  double speed = 1 / given.factor;
  if (options.given("frames")) speed = given.frames > 1 ? (last - first) / (given.frames - 1) : last - first;
  const double count = options.given("frames") ? given.frames : std::floor((last - first) / speed + 1e-9) + 1;
  if (!(count <= kMostFrames))
    options.refuse("factor", "--factor " + formatNumber(given.factor) + " asks for " + formatNumber(count) +
                                 " frames; a million is the most");
  const int start = options.given("start") ? given.start : int(first);
  std::vector<ShownTime> times;
  for (int i = 0; i < int(count); ++i) times.push_back({start + i, std::min(first + i * speed, last), speed});
  return times;
}

/// The job of one frame.
FrameJob jobOf(const ShownTime& time, const std::vector<InputFrame>& files, const OutputName& output,
               double framesPerSecond) {
  size_t after = 1;
  while (after + 1 < files.size() && time.at >= files[after].number) ++after;
  const InputFrame &a = files[after - 1], &b = files[after];
  const double gap = b.number - a.number, t = (time.at - a.number) / gap;
  const double perSecond = time.speed / gap * framesPerSecond;
  FrameJob job;
  job.number = time.frame, job.t = t, job.weights = {1 - t, t}, job.path = output.path(time.frame);
  job.inputFrame = after - 1, job.rate = {-perSecond, perSecond}, job.speed = time.speed;
  for (const InputFrame* file : {&a, &b})
    if (std::abs(time.at - file->number) < kSameNumber) job.given = file->input.path;
  return job;
}

/// The sequence without one of its files, the first or the last.
std::string withoutFile(const InputSpec& input, const std::vector<InputFrame>& files, size_t from) {
  std::string range;
  for (size_t i = from; i + 1 < files.size() + from; ++i)
    range += (range.empty() ? "" : ",") + std::to_string(files[i].number);
  return input.path + "@" + range + (input.selection.empty() ? "" : ":" + input.selection);
}

}  // namespace

RetimeJob retimeJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  RetimeJob job;
  MorphSettings& s = job.settings;
  const std::vector<InputFrame> files = filesOf(options);
  for (const InputFrame& file : files) job.numbers.push_back(file.number);
  const InputSpec input = parseInput(given.input);
  s.options = given;
  s.inputs = {withoutFile(input, files, 0), withoutFile(input, files, 1)};
  s.output = given.output;
  if (isOneUsda(s.output)) s.usdVolume = s.output, s.output = vdbFilesOf(s.output);
  const OutputName output(s.output);
  if (output.extension() != ".vdb" || !output.isSequence())
    options.refuse("output", "-o " + given.output +
                                 ": expected a sequence of VDB files, name.####.vdb, or name.usda for one "
                                 "with a stage that shows it");
  s.framesPerSecond = s.stage.framesPerSecond = given.framesPerSecond;
  s.quiet = given.quiet, s.resume = given.resume;
  s.conserve = true;
  if (options.given("grids"))
    s.grids = options.about("grids", [&] { return parseNames("--grids", given.grids); });
  s.velocity = {given.velocity, given.velocityUnit == "frame", false, given.velocityHalf, true};
  s.load = loadSettings(options);
  checkIsos(s.load, options, 1);
  s.load.matching = s.load.density = true, s.load.fogResolution = kFogResolution;
  s.plan = planSettings(options, false);
  s.plan.align = Align::kNone, s.alignGiven = true;
  s.eachAlone = true;
  s.frameSettings = options.frameSettings();
  const double first = files.front().number, last = files.back().number;
  const std::vector<ShownTime> times =
      options.given("curve") ? timesOfCurve(options, first, last) : evenTimes(options, first, last);
  for (const ShownTime& time : times) s.frames.push_back(jobOf(time, files, output, s.framesPerSecond));
  keepRange(s.frames, options);
  options.about("output", [&] {
    checkOutput(s.frames[0].path);
    if (!s.usdVolume.empty()) checkOutputPath(s.usdVolume);
  });
  return job;
}

}  // namespace slicemorph
