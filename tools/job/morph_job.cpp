#include "tools/job/morph_job.h"

#include "tools/job/frame_range.h"
#include "tools/job/guidance_file.h"
#include "tools/job/input_names.h"
#include "tools/job/landmarks.h"
#include "tools/job/load_settings.h"
#include "tools/job/morph_checks.h"
#include "tools/job/option_values.h"
#include "tools/job/plan_settings.h"
#include "tools/job/usd_settings.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Times of the frames: evenly from 0 to 1, or those of --at.
std::vector<double> frameTimes(const OptionSet& options, int frames) {
  if (!options.given("at")) return evenTimes(frames);
  const std::string& at = options.values().at;
  const std::vector<double> times = options.about("at", [&] { return parseNumbers("--at", at); });
  for (double t : times)
    if (t < 0 || t > 1)
      options.refuse("at", "--at " + at + ": " + formatNumber(t) + " is not a time; times are 0 to 1");
  return times;
}

KeyList keysOf(const OptionSet& options) {
  const JobOptions& given = options.values();
  if (!given.keys.empty()) return {parseKeys("--keys", given.keys, given.inputs), {}};
  return options.given("keys") ? readKeys(JobFile(given), given.inputs) : KeyList();
}

/// Sets the frames of a sequence: their times and the weights at these.
MorphJob withTimes(MorphJob job, const OptionSet& options) {
  const JobOptions& given = options.values();
  MorphSettings& s = job.settings;
  const KeyList list = keysOf(options);
  job.notes.insert(job.notes.end(), list.notes.begin(), list.notes.end());
  const std::string unused = list.keys.empty() ? "" : noteOfUnused(list.keys, s.inputs);
  if (!unused.empty())
    job.notes.push_back({"job.input-unused", Severity::kNote,
                         options.source("keys") + spelledName(options.row("keys")), unused});
  job.tables.keys = list.keys;
  const Easing easing = options.about("ease", [&] { return parseEasing("--ease", given.ease); });
  s.course =
      courseOf(list.keys.empty() ? evenKeys(s.inputs.size()) : list.keys, timingNamed(given.timing), easing);

  const size_t length = lengthOfInputs(options);
  const bool wholeSequence = length > 1 && !options.given("frames"), atGiven = options.given("at");
  const std::vector<double> times = frameTimes(options, wholeSequence ? int(length) : given.frames);
  s.frames = framesAt(s, times, given.start);
  for (FrameJob& frame : s.frames)
    if (atGiven) frame.inputFrame = size_t(std::lround(*frame.t * double(length - 1)));
  return job;
}

/// Sets the frames of one blend by --weights: one, or one for each file of the longest sequence.
MorphJob withWeights(MorphJob job, const OptionSet& options) {
  MorphSettings& s = job.settings;
  for (const char* key : {"keys", "timing", "ease"})
    if (options.given(key))
      options.refuse(key, std::string("--") + key +
                              " is for sequences, by --frames or --at, not for one blend by --weights");
  const std::string said = "--weights " + options.values().weights;
  const CheckedWeights weights = options.about("weights", [&] {
    return checkWeights(said, parseNumbers("--weights", options.values().weights), s.inputs.size());
  });
  if (!weights.note.empty())
    job.notes.push_back(
        {"job.weights-normalised", Severity::kNote, "", options.source("weights") + weights.note});
  job.tables.values["weights"] = tomlOf(weights.weights);
  for (size_t i = 0; i < lengthOfInputs(options); ++i) {
    const int number = options.values().start + int(i);
    s.frames.push_back({number, std::nullopt, weights.weights, OutputName(s.output).path(number), i, {}});
  }
  return job;
}

/// Sets features, regions and landmarks.
MorphJob withGuidance(MorphJob job, const OptionSet& options) {
  const JobOptions& given = options.values();
  MorphSettings& s = job.settings;
  if (!given.config.empty()) {
    const Guidance guidance = readGuidance(JobFile(given), s.inputs);
    s.plan.features = job.tables.features = guidance.features;
    s.plan.regions = job.tables.regions = guidance.regions;
    job.notes.insert(job.notes.end(), guidance.notes.begin(), guidance.notes.end());
  }
  s.landmarks = landmarksOf(options, "landmarks", given.landmarks, s.inputs.size());
  s.checkLandmarks = landmarksOf(options, "check-landmarks", given.checkLandmarks, s.inputs.size());
  for (const Feature& feature : featuresOf(s.landmarks)) s.plan.features.push_back(feature);
  return job;
}

LoadOptions loadingOf(const MorphSettings& s, const OptionSet& options) {
  LoadOptions load = loadSettings(options);
  load.matching = true;
  load.density = options.values().align == "none";
  checkIsos(load, options, s.inputs.size());
  // The shape found in fog only steers the map unless the surface itself is wanted.
  if (s.holdsGrids() && !std::count(s.grids.begin(), s.grids.end(), "surface"))
    load.fogResolution = kFogResolution;
  return load;
}

VelocitySettings velocityOf(const OptionSet& options, const MorphSettings& s, bool images) {
  const JobOptions& given = options.values();
  const bool none = s.toPictures() || (images && !options.given("velocity"));
  return {none ? "none" : given.velocity, given.velocityUnit == "frame", given.addVelocity,
          given.velocityHalf};
}

/// Options of one run: where its results go, and how it is run. The last two are here as they may name files: the job file has
/// the positions that these hold.
constexpr const char* kNotOfTheJob[] = {"output", "report",    "dump-slices",    "resume",
                                        "range",  "quiet",     "verbose",        "threads",
                                        "memory", "landmarks", "check-landmarks"};
constexpr const char* kFilesOfTheJob[] = {"inputs", "like", "exr-planes"};

/// What was given without the options of one run, files by their whole paths.
OptionSet withoutRun(const OptionSet& options) {
  const auto isIn = [](const auto& names, const OptionRow& row) {
    return std::find(std::begin(names), std::end(names), row.name) != std::end(names);
  };
  OptionSet whole(kMorph);
  for (const OptionRow* row : options.rows()) {
    std::vector<std::string> texts = options.texts(row->name);
    if (texts.empty() || isIn(kNotOfTheJob, *row)) continue;
    if (isIn(kFilesOfTheJob, *row)) std::transform(texts.begin(), texts.end(), texts.begin(), wholePath);
    whole.set(*row, texts);
  }
  return whole;
}

/// The job file of what was given, which may lie anywhere and writes over nothing that this run makes. Features that are
/// points are left out. Empty where no file holds the inputs, or a name is none that a job file can have.
std::string jobTextOf(const OptionSet& options, JobTables tables, const MorphSettings& s) {
  if (std::any_of(s.held.begin(), s.held.end(), [](const auto& held) { return bool(held); })) return "";
  if (!s.landmarks.empty()) tables.values["landmarks"] = tomlOf(s.landmarks);
  if (!s.checkLandmarks.empty()) tables.values["check-landmarks"] = tomlOf(s.checkLandmarks);
  auto& features = tables.features;
  features.erase(std::remove_if(features.begin(), features.end(),
                                [](const Feature& f) { return f.kind == Feature::Kind::kPoint; }),
                 features.end());
  try {
    return givenJobText(withoutRun(options), tables);
  } catch (const InputError&) {
    return "";
  }
}

/// Settings that follow from single options.
MorphSettings plainSettings(const OptionSet& options) {
  const JobOptions& given = options.values();
  MorphSettings s;
  s.options = given;
  s.inputs = given.inputs, s.held = given.held, s.output = given.output;
  const MethodChoice choice = options.about("method", [&] { return methodChoice(given.method); });
  s.method = choice.name, s.parameters = choice.given;
  s.framesPerSecond = given.framesPerSecond, s.reports = given.reports, s.sliceFolder = given.sliceFolder;
  s.quiet = given.quiet, s.resume = given.resume, s.planFile = given.planFile;
  s.conserve = given.conserve, s.like = given.like;
  if (options.given("grids"))
    s.grids = options.about("grids", [&] { return parseNames("--grids", given.grids); });
  s.exrContent = given.exrContent == "slices" ? ExrContent::kSlices : ExrContent::kPicture;
  const bool images = s.allImages();
  s = withUsd(std::move(s), options);
  s.velocity = velocityOf(options, s, images);
  s.load = loadingOf(s, options);
  s.plan = planSettings(options, images);
  s.alignGiven = options.given("align");
  s.glb.zUp = given.glbUp == "z";
  s.glb.metres = given.unit == "mm" ? 1e-3 : given.unit == "cm" ? 1e-2 : 1;
  s.picture = checkedPicture(options), s.exrSlices = checkedSlices(options, "exr-");
  s.pictureOptions = options.givenFor(OptionTarget::kPictures);
  s.sliceOptions = options.givenFor(OptionTarget::kExrSlices);
  s.frameSettings = options.frameSettings();
  return s;
}

}  // namespace

std::vector<double> evenTimes(int frames) {
  std::vector<double> times(size_t(frames), 0.0);
  for (int i = 1; i < frames; ++i) times[size_t(i)] = double(i) / (frames - 1);
  return times;
}

std::vector<FrameJob> framesAt(const MorphSettings& settings, const std::vector<double>& times, int start) {
  std::vector<FrameJob> frames;
  for (size_t i = 0; i < times.size(); ++i) {
    const int number = start + int(i);
    frames.push_back({number,
                      times[i],
                      weightsAt(settings.course, times[i]),
                      OutputName(settings.output).path(number),
                      i,
                      {}});
    if (times.size() < 2) continue;
    const size_t before = i > 0 ? i - 1 : i, after = i + 1 < times.size() ? i + 1 : i;
    frames[i].rate = rateAt(settings, times[i], (times[after] - times[before]) / double(after - before));
  }
  return frames;
}

Weights rateAt(const MorphSettings& settings, double t, double perFrame) {
  Weights rate = slopeAt(settings.course, t);
  for (double& r : rate) r *= perFrame * settings.framesPerSecond;
  return rate;
}

MorphJob morphJob(const OptionSet& options) {
  checkEssentials(options);
  MorphJob job;
  job.settings = plainSettings(options);
  job.tables.inputs = job.settings.inputs;
  job = withGuidance(std::move(job), options);
  job = options.given("weights") ? withWeights(std::move(job), options) : withTimes(std::move(job), options);
  keepRange(job.settings.frames, options);
  checkPurposes(job.settings, options);
  checkOutputKind(job.settings, options);
  checkMethodInputs(job.settings, options);
  job.settings.jobText = jobTextOf(options, job.tables, job.settings);
  return job;
}

}  // namespace slicemorph
