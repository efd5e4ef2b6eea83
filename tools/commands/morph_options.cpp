#include "tools/commands/morph_options.h"

#include "io/paths.h"
#include "io/sequence.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "tools/commands/common_options.h"
#include "tools/job/guidance_file.h"
#include "tools/job/image_lattice.h"
#include "tools/job/job_file.h"
#include "tools/job/job_writer.h"
#include "tools/job/landmarks.h"
#include "tools/job/methods.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace slicemorph {

struct MorphOptionSet::Values {
  std::vector<std::string> inputs;
  std::string output, at, weights, keys, timing = "linear", ease = "linear", interpolation = "linear",
                                         axis = "auto", spine = "auto", align = "auto", method = "slices",
                                         grids, config, sliceFolder, like, landmarks, checkLandmarks;
  std::vector<std::string> reports;
  int frames = 24, threads = 0;
  LoadOptions load;
  MorphOptions plan;
  double framesPerSecond = 24;
  std::string velocity = "vel", velocityUnit = "second", glbUp = "y", glbUnit = "m", exrContent = "picture";
  PictureOptions picture;
  SliceOptions exrSlices;
  std::vector<JobOption> pictureOptions, sliceOptions;
  bool quiet = false, resume = false, conserve = false, addVelocity = false, printConfig = false;

  SamplingOptions sampling;
  CLI::Option *inputsGiven, *outputGiven, *framesGiven, *atGiven, *weightsGiven, *keysGiven, *threadsGiven,
      *gridsGiven, *velocityGiven;
  std::vector<JobOption> jobOptions;
  std::map<std::string, std::string> places;  ///< of the keys that the job file says
  Notes notes;
  JobTables tables;  ///< for --print-config

  /// Where the job file says what a message is about, that begins with an option or the name of a file;
  /// empty: it does not.
  std::string placeOf(const std::string& message) const {
    const std::string first = message.substr(0, message.find_first_of(" :,"));
    for (const JobOption& option : jobOptions) {
      const auto place = places.find(option.key);
      if (place == places.end() || !option.option) continue;
      if (first == "--" + option.key || (first == "-o" && option.key == "output")) return place->second;
      if (option.type != JobType::kText && option.type != JobType::kTexts) continue;
      for (const std::string& text : option.option->results())
        if (message.compare(0, text.size() + 1, text + ":") == 0 ||
            message.compare(0, text.size() + 1, text + " ") == 0)
          return place->second;
    }
    return "";
  }
};

namespace {

std::vector<double> frameTimes(const std::string& at, bool atGiven, int frames) {
  if (!atGiven) {
    checkRange("--frames", frames, 1, 1000000);
    std::vector<double> times(size_t(frames), 0.0);
    for (int i = 1; i < frames; ++i) times[size_t(i)] = double(i) / (frames - 1);
    return times;
  }
  const std::vector<double> times = parseNumbers("--at", at);
  for (double t : times)
    if (t < 0 || t > 1)
      throw InputError("--at " + at + ": " + formatNumber(t) + " is not a time; times are 0 to 1");
  return times;
}

/// Voxels along the longest side of shapes found in fog.
constexpr int kFogResolution = 160;

/// As help lists choices: slices|sdf.
std::string methodChoices() {
  std::string choices;
  for (const std::string& name : methodNames()) choices += (choices.empty() ? "" : "|") + name;
  return choices;
}

/// Files of the longest input that is a sequence; 1 where none is.
size_t lengthOfInputs(const std::vector<std::string>& inputs) {
  size_t length = 1;
  for (const std::string& input : inputs)
    if (isMovingInput(input)) length = std::max(length, framesOf(parseInput(input)).size());
  return length;
}

/// Speeds of the weights: frames are 1 / fps seconds apart, whatever their times.
void setRates(std::vector<FrameJob>& frames, const WeightCourse& course, double framesPerSecond) {
  if (frames.size() < 2) return;
  for (size_t i = 0; i < frames.size(); ++i) {
    const size_t before = i > 0 ? i - 1 : i, after = i + 1 < frames.size() ? i + 1 : i;
    const double perSecond =
        (*frames[after].t - *frames[before].t) / double(after - before) * framesPerSecond;
    frames[i].rate = slopeAt(course, *frames[i].t);
    for (double& r : frames[i].rate) r *= perSecond;
  }
}

Timing timingOf(const std::string& name) {
  return name == "smoothstep"    ? Timing::kSmoothstep
         : name == "catmull-rom" ? Timing::kCatmullRom
                                 : Timing::kLinear;
}

ContourPath pathOf(const std::string& name) {
  return name == "hermite"     ? ContourPath::kHermite
         : name == "intrinsic" ? ContourPath::kIntrinsic
                               : ContourPath::kLinear;
}

/// Options that were given, with their values.
std::vector<std::pair<std::string, std::string>> given(const std::vector<JobOption>& options) {
  std::vector<std::pair<std::string, std::string>> list;
  for (const JobOption& option : options) {
    if (!option.option->count()) continue;
    std::string all;
    for (const std::string& text : option.option->results()) all += (all.empty() ? "" : " ") + text;
    list.push_back({option.key, all});
  }
  return list;
}

/// Options of pictures and slices are for outputs that are some.
void checkImageOptions(const MorphSettings& s) {
  const bool slices = s.exrContent == ExrContent::kSlices;
  if (!s.pictureOptions.empty() && !s.toPictures())
    throw InputError("--" + s.pictureOptions[0].first + " is for pictures, .exr or .png, not for " +
                     (s.toFrameImages() ? "--exr slices" : s.output));
  if (!s.sliceOptions.empty() && !(s.toFrameImages() && slices))
    throw InputError("--" + s.sliceOptions[0].first + " is for outputs that are .exr, with --exr slices");
  if (slices && OutputName(s.output).extension() != ".exr")
    throw InputError("--exr slices is for outputs that are .exr, not for " + s.output);
  if (slices && s.exrSlices.spine && !s.can().surface)
    throw InputError("--exr-spine: --method " + s.method + " makes no shape whose spine slices could follow");
}

/// Throws IoError where an input is missing or an output cannot be written.
void checkFiles(const MorphSettings& s) {
  s.toFrameImages() ? checkOutputPath(s.frames[0].path) : checkOutput(s.frames[0].path);
  for (const std::string& report : s.reports) {
    checkExtension(report, {".json", ".csv", ".html"});
    checkOutputPath(report);
  }
  if (!s.sliceFolder.empty()) {
    const auto parent = std::filesystem::absolute(s.sliceFolder).lexically_normal();
    if (!std::filesystem::is_directory(parent)) checkOutputPath(parent.string());
  }
  for (const std::string& input : s.inputs) checkInputExists(input);
  if (!s.like.empty()) checkInputExists(s.like);
}

}  // namespace

MorphOptionSet::MorphOptionSet(CLI::App& command) : values_(std::make_shared<Values>()) {
  Values& v = *values_;
  const auto add = [&](const std::string& name, auto& value, JobType type, const std::string& help,
                       const std::string& typeName, const std::vector<std::string>& silencers = {}) {
    const std::string fallback = fallbackOf(value);
    CLI::Option* option = command.add_option("--" + name, value, help)->type_name(typeName);
    v.jobOptions.push_back({name, type, option, silencers, fallback});
    return option;
  };
  const auto remember = [&](const std::string& key, JobType type, CLI::Option* option,
                            const std::vector<std::string>& silencers = {}) {
    v.jobOptions.push_back({key, type, option, silencers});
    return option;
  };
  v.inputsGiven =
      remember("inputs", JobType::kTexts,
               command.add_option(
                   "INPUT", v.inputs,
                   "Two or more shapes or fog volumes: .vdb (file.vdb:grid picks a grid, "
                   "name.####.vdb is a sequence) .obj .ply .stl .off .glb; or images: .nii .nii.gz .nrrd "
                   ".nhdr .mha .mhd (file:N), DICOM folders (folder:N), name.####.tif|png|exr; more than "
                   "two follow each other in time"));
  v.outputGiven =
      remember("output", JobType::kText,
               command
                   .add_option("-o,--output", v.output,
                               "Result: .vdb .obj .ply .stl .glb, pictures .png .exr, slices .exr, of images "
                               "also .nii .nii.gz .nrrd .mha; #### stands "
                               "for the frame number; a .glb without #### holds all frames, animated")
                   ->type_name("OUTPUT"));
  v.framesGiven =
      add("frames", v.frames, JobType::kInteger,
          "Frames 1 to N, the first input at 1, the last at N (24; as many as input sequences have)", "N",
          {"at", "weights"});
  v.atGiven =
      add("at", v.at, JobType::kNumbers, "Only these times, 0 to 1", "T[,T...]", {"frames", "weights"});
  v.weightsGiven =
      add("weights", v.weights, JobType::kNumbers, "One blend of all inputs: a weight per input, of sum 1",
          "W,W[,W...]", {"frames", "at", "keys"});
  v.keysGiven = add("keys", v.keys, JobType::kTables,
                    "Inputs by time, 0 to 1: by file name, number or letter (one after the other, evenly); "
                    "in a job file also "
                    "[{at = 0, input = \"a\"}, {at = 1, weights = [0.5, 0.5]}]",
                    "\"a@0 b@0.5 c@1\"", {"weights"});
  add("timing", v.timing, JobType::kText,
      "Between keys: at even speed, stopping at each, or smoothly through all (linear)",
      "linear|smoothstep|catmull-rom", {"weights"})
      ->check(oneOf({"linear", "smoothstep", "catmull-rom"}));
  add("ease", v.ease, JobType::kNumbers,
      "Of the whole sequence: slow in, slow out, or a curve as CSS's cubic-bezier (linear)",
      "linear|in|out|in-out|X1,Y1,X2,Y2", {"weights"});
  v.sampling = addSamplingOptions(command, v.load);
  remember("voxel-size", JobType::kNumber, v.sampling.voxelSize, {"resolution"});
  remember("resolution", JobType::kInteger, v.sampling.resolution, {"voxel-size"});
  remember("iso", JobType::kNumbers, v.sampling.iso);
  remember("image", JobType::kText, v.sampling.image);
  remember("spacing", JobType::kNumbers, v.sampling.spacing);
  add("like", v.like, JobType::kText,
      "Put in-between images on the voxels of this one (those of the first input, and more where shapes "
      "reach beyond)",
      "IMAGE");
  add("landmarks", v.landmarks, JobType::kPlaces,
      "Places to be carried onto each other: a file of points per input, or in a job file "
      "[[[x,y,z],[x,y,z]], ...]",
      "FILE,FILE[,...]");
  add("check-landmarks", v.checkLandmarks, JobType::kPlaces, "Places that are only measured, for the report",
      "FILE,FILE[,...]");
  add("slices", v.plan.slices, JobType::kInteger, "Slices per object, 8 to 1024 (96)", "N");
  add("samples", v.plan.samples, JobType::kInteger, "Points per contour, 16 to 4096 (128)", "N");
  add("axis", v.axis, JobType::kText, "Slicing direction of the first input (auto)", "auto|x|y|z|DX,DY,DZ");
  add("spine", v.spine, JobType::kText, "Line that the slices follow (auto)", "auto|straight|curved")
      ->check(oneOf({"auto", "straight", "curved"}));
  add("align", v.align, JobType::kText, "none keeps world positions and directions (auto)", "auto|none")
      ->check(oneOf({"auto", "none"}));
  add("interpolation", v.interpolation, JobType::kText,
      "Way of the contours: straight, by cubics that leave and reach them at right angles, or by edge "
      "lengths and turning "
      "angles (linear)",
      "linear|hermite|intrinsic")
      ->check(oneOf({"linear", "hermite", "intrinsic"}));
  add("method", v.method, JobType::kText, methodHelp(), methodChoices())->check(oneOf(methodNames()));
  v.gridsGiven = add("grids", v.grids, JobType::kText,
                     "Grids of VDBs, slices and pictures, `surface` for the shape's level set (all; the "
                     "surface where no input is fog)",
                     "a,b,...");
  remember(
      "conserve", JobType::kFlag,
      command.add_flag("--conserve", v.conserve,
                       "Thin and thicken fog so that its total goes straight from the one to the other"));
  v.velocityGiven =
      add("velocity", v.velocity, JobType::kText,
          "Name of the velocity grid of VDB outputs; none: without (vel; none for images)", "NAME|none");
  add("velocity-unit", v.velocityUnit, JobType::kText, "World units per second or per frame (second)",
      "second|frame")
      ->check(oneOf({"second", "frame"}));
  remember(
      "add-velocity", JobType::kFlag,
      command.add_flag("--add-velocity", v.addVelocity,
                       "Add the inputs' own velocities (vel, v, velocity; world units per second), morphed"));
  add("fps", v.framesPerSecond, JobType::kNumber, "Frames per second, for velocities and metadata (24)", "F");
  add("glb-up", v.glbUp, JobType::kText,
      "The inputs' axis that points up: what stands is turned about it, and .glb, where Y is up, says so (y)",
      "y|z")
      ->check(oneOf({"y", "z"}));
  add("glb-unit", v.glbUnit, JobType::kText, "The inputs' unit, for .glb, which is in metres (m)", "m|cm|mm")
      ->check(oneOf({"m", "cm", "mm"}));
  add("exr", v.exrContent, JobType::kText,
      "What .exr frames hold: a rendered picture, or slices of all grids, one part each (picture)",
      "picture|slices")
      ->check(oneOf({"picture", "slices"}));
  v.pictureOptions = addPictureOptions(command, v.picture);
  v.sliceOptions = addSliceOptions(command, v.exrSlices, "exr-");
  for (const auto* options : {&v.pictureOptions, &v.sliceOptions})
    v.jobOptions.insert(v.jobOptions.end(), options->begin(), options->end());
  v.threadsGiven = remember("threads", JobType::kInteger, addThreadsOption(command, v.threads));
  remember("report", JobType::kTexts,
           command
               .add_option(
                   "--report", v.reports,
                   "Measure every frame and write the figures; .csv: of every label or shape a line a frame; "
                   ".html: a page with a 3D player, curves, pictures")
               ->type_name("FILE.json|FILE.csv|FILE.html")
               ->allow_extra_args(false));
  add("dump-slices", v.sliceFolder, JobType::kText,
      "Draw the slices with their contours and pairs, one SVG each", "DIR");
  remember("resume", JobType::kFlag,
           command.add_flag("--resume", v.resume, "Go on with an interrupted sequence of the same settings"));
  remember("quiet", JobType::kFlag, command.add_flag("--quiet", v.quiet, "Print nothing but errors"));
  command
      .add_option("--config", v.config,
                  "Take options from a file (key = value, keys as the long options, inputs, "
                  "output; tables [[feature]] and [[region]]); the command line wins")
      ->type_name("FILE.toml");
  command.add_flag("--print-config", v.printConfig, "Print all options as such a file, and do nothing else");
  for (const char* table : {"feature", "region"}) v.jobOptions.push_back({table, JobType::kTables, nullptr});
}

MorphSettings MorphOptionSet::settings() {
  Values& v = *values_;
  if (!v.config.empty()) v.places = applyJobFile(v.config, v.jobOptions);
  const bool bare = v.printConfig && v.config.empty() && v.inputs.empty();
  try {
    MorphSettings s = bare ? MorphSettings() : checked();
    for (Note& note : v.notes) note.text = v.placeOf(note.sentence()) + note.text;
    printNotes("", v.notes, s.quiet);
    if (v.printConfig) {
      std::fputs(jobText(v.jobOptions, v.tables).c_str(), stdout);
      throw CLI::Success();
    }
    checkFiles(s);
    s.threadLimit = limitThreads(v.threads, v.threadsGiven);
    return s;
  } catch (const InputError& error) {
    throw InputError(v.placeOf(error.what()) + error.what());
  } catch (const IoError& error) {
    throw IoError(v.placeOf(error.what()) + error.what());
  }
}

bool MorphOptionSet::said(const std::string& key) const {
  const auto& options = values_->jobOptions;
  const auto option =
      std::find_if(options.begin(), options.end(), [&](const JobOption& o) { return o.key == key; });
  return values_->places.count(key) || (option->option && option->option->count());
}

/// Times, and the weights at them.
void MorphOptionSet::setTimes(MorphSettings& s) {
  Values& v = *values_;
  const OutputName name(s.output);
  KeyList keys;
  if (v.keysGiven->count())
    keys.keys = parseKeys("--keys", v.keys, s.inputs);
  else if (said("keys"))
    keys = readKeys(v.config, s.inputs);
  v.notes.insert(v.notes.end(), keys.notes.begin(), keys.notes.end());
  if (!keys.keys.empty()) {
    const std::string unused = noteOfUnused(keys.keys, s.inputs);
    if (!unused.empty()) v.notes.push_back("--keys: " + unused);
  }
  v.tables.keys = keys.keys;
  s.course = courseOf(keys.keys.empty() ? evenKeys(s.inputs.size()) : keys.keys, timingOf(v.timing),
                      parseEasing("--ease", v.ease));

  const size_t length = v.printConfig ? 1 : lengthOfInputs(s.inputs);
  const bool wholeSequence = length > 1 && !v.framesGiven->count(), atGiven = v.atGiven->count() > 0;
  const std::vector<double> times = frameTimes(v.at, atGiven, wholeSequence ? int(length) : v.frames);
  for (size_t i = 0; i < times.size(); ++i)
    s.frames.push_back({int(i) + 1,
                        times[i],
                        weightsAt(s.course, times[i]),
                        name.path(int(i) + 1),
                        atGiven ? size_t(std::lround(times[i] * double(length - 1))) : i,
                        {}});
  setRates(s.frames, s.course, s.framesPerSecond);
}

/// One blend, of every frame that the inputs have.
void MorphOptionSet::setWeights(MorphSettings& s) {
  Values& v = *values_;
  for (const char* key : {"keys", "timing", "ease"})
    if (said(key))
      throw InputError(std::string("--") + key +
                       " is for sequences, by --frames or --at, not for one blend by --weights");
  const CheckedWeights weights =
      checkWeights("--weights " + v.weights, parseNumbers("--weights", v.weights), s.inputs.size());
  if (!weights.note.empty()) v.notes.push_back(weights.note);
  v.tables.values["weights"] = tomlOf(weights.weights);
  const size_t length = v.printConfig ? 1 : lengthOfInputs(s.inputs);
  for (size_t i = 0; i < length; ++i)
    s.frames.push_back(
        {int(i) + 1, std::nullopt, weights.weights, OutputName(s.output).path(int(i) + 1), i, {}});
}

/// Features, regions, landmarks, the contours' way.
void MorphOptionSet::setGuidance(MorphSettings& s) {
  Values& v = *values_;
  if (!v.config.empty()) {
    const Guidance guidance = readGuidance(v.config, s.inputs);
    s.plan.features = v.tables.features = guidance.features;
    s.plan.regions = v.tables.regions = guidance.regions;
    v.notes.insert(v.notes.end(), guidance.notes.begin(), guidance.notes.end());
  }
  // --print-config needs no files.
  const auto landmarks = [&](const std::string& option, const std::string& text) {
    const bool files = text.find('=') == std::string::npos;
    return v.printConfig && files ? std::vector<Landmark>() : readLandmarks(option, text, s.inputs.size());
  };
  s.landmarks = landmarks("--landmarks", v.landmarks);
  s.checkLandmarks = landmarks("--check-landmarks", v.checkLandmarks);
  for (const Feature& feature : featuresOf(s.landmarks)) s.plan.features.push_back(feature);
  s.plan.path = pathOf(v.interpolation);
  if (s.can().guided) return;
  for (const char* table : {"feature", "region"})
    if (said(table))
      throw InputError(v.places[table] + "[[" + table + "]] is for " + methodsThat(&MethodTraits::guided) +
                       ", not for " + v.method);
  if (!s.landmarks.empty())
    throw InputError("--landmarks " + v.landmarks + " is for " + methodsThat(&MethodTraits::guided) +
                     ", not for " + v.method);
  if (s.plan.path != ContourPath::kLinear)
    throw InputError("--interpolation " + v.interpolation + " is for " + methodsThat(&MethodTraits::guided) +
                     ", not for " + v.method);
}

MorphSettings MorphOptionSet::checked() {
  Values& v = *values_;
  if (v.inputs.size() < 2)
    throw InputError("morph needs at least two inputs, not " + std::to_string(v.inputs.size()) +
                     "; for example: slicemorph morph a.obj b.obj -o morph.####.vdb");
  if (v.output.empty()) throw InputError("morph needs an output; for example: -o morph.####.vdb");
  if (v.atGiven->count() + v.weightsGiven->count() + v.framesGiven->count() > 1)
    throw InputError("--frames, --at and --weights exclude each other; give one of them");

  MorphSettings s;
  s.inputs = v.inputs, s.output = v.output, s.load = v.load, s.plan = v.plan;
  s.framesPerSecond = v.framesPerSecond, s.reports = v.reports, s.sliceFolder = v.sliceFolder;
  s.quiet = v.quiet, s.resume = v.resume, s.method = v.method;
  checkSampling(s.load, v.sampling);
  if (v.sampling.voxelSize->count()) s.plan.voxelSize = s.load.voxelSize;
  if (!s.load.isosByInput.empty() && s.load.isosByInput.size() != s.inputs.size())
    throw InputError("--iso names values for " + std::to_string(s.load.isosByInput.size()) + " inputs of " +
                     std::to_string(s.inputs.size()) +
                     "; give one for all or one for each, for example --iso 300/250");
  checkRange("--slices", s.plan.slices, 8, 1024);
  checkRange("--samples", s.plan.samples, 16, 4096);
  checkPositive("--fps", s.framesPerSecond);
  if (v.gridsGiven->count()) s.grids = parseNames("--grids", v.grids);
  s.conserve = v.conserve;
  if (v.velocity.empty()) throw InputError("--velocity needs a name for the grid, or none");
  const bool images = std::all_of(s.inputs.begin(), s.inputs.end(), isImageInput);
  s.velocity = {images && !v.velocityGiven->count() ? "none" : v.velocity, v.velocityUnit == "frame",
                v.addVelocity};
  s.like = v.like;
  v.tables.inputs = s.inputs;
  setGuidance(s);
  if (v.axis != "auto") s.plan.axis = parseDirection("--axis", v.axis);
  s.plan.spine = v.spine == "straight" ? SpineKind::kStraight
                 : v.spine == "curved" ? SpineKind::kCurved
                                       : SpineKind::kAuto;
  s.plan.align = v.align == "none" ? Align::kNone : Align::kAuto;

  const OutputName name(s.output);
  v.weightsGiven->count() ? setWeights(s) : setTimes(s);
  // The shape found in fog only steers the map, unless it is what is asked for.
  if (s.holdsGrids() && !std::count(s.grids.begin(), s.grids.end(), "surface"))
    s.load.fogResolution = kFogResolution;
  s.exrContent = v.exrContent == "slices" ? ExrContent::kSlices : ExrContent::kPicture;
  s.picture = v.picture, s.exrSlices = v.exrSlices;
  checkPictureOptions(s.picture);
  if (!v.printConfig || s.exrSlices.planeFile.empty()) checkSliceOptions(s.exrSlices);
  s.pictureOptions = given(v.pictureOptions), s.sliceOptions = given(v.sliceOptions);
  checkImageOptions(s);
  if (s.toPictures() && images && !s.can().surface)
    throw InputError("--method " + s.method +
                     " of images makes no surface that could be drawn; the output can be --exr slices or "
                     "an image");
  if (s.toPictures() && v.velocityGiven->count())
    throw InputError("--velocity " + v.velocity + " is for outputs that hold grids; " + s.output +
                     " is a picture");
  const bool onlySurface =
      std::all_of(s.grids.begin(), s.grids.end(), [](const std::string& g) { return g == "surface"; });
  if (!onlySurface && !isImageOutput(s.output) && (!s.holdsGrids() || !s.can().grids))
    throw InputError(
        "--grids " + v.grids + ": " +
        (s.holdsGrids() ? "this --method makes the surface alone" : s.output + " holds the surface alone"));
  if (s.toPictures()) s.velocity.name = "none";
  s.glb.zUp = v.glbUp == "z";
  // Scans know where they lie.
  s.plan.up = images ? Vec3d(0.0) : s.glb.zUp ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
  s.glb.metres = v.glbUnit == "mm" ? 1e-3 : v.glbUnit == "cm" ? 1e-2 : 1;
  if (s.frames.size() > 1 && !name.isSequence() && !s.oneGlb())
    throw InputError(
        "-o " + s.output + " is one file for " + std::to_string(s.frames.size()) +
        " frames; put #### where the frame number belongs (name.####.vdb), or ask for one frame by --at "
        "T or --weights; a .glb holds all frames");
  const bool imageOutput = isImageOutput(s.output);
  if (imageOutput && !images) {
    const auto other = std::find_if_not(s.inputs.begin(), s.inputs.end(), isImageInput);
    throw InputError("-o " + s.output + ": in-between images need images on all sides, and " + *other +
                     " is none; the output can be .vdb .obj .ply .stl .glb .exr .png");
  }
  if (!s.plan.regions.empty() && images && (imageOutput || s.holdsGrids()) &&
      s.grids != std::vector<std::string>{"surface"})
    throw InputError(v.places["region"] +
                     "[[region]] is for shapes and grids, not for in-between images: make a mesh, or a .vdb "
                     "with --grids surface");
  if (!s.like.empty() && !imageOutput && !(images && s.holdsGrids()))
    throw InputError("--like " + s.like + " is for in-between images; the output " + s.output + " is none");
  if (!s.can().surface && !s.holdsGrids() && !imageOutput)
    throw InputError("--method " + s.method +
                     " blends values and makes no surface; the output must be .vdb, .exr, .png or an "
                     "image, not " +
                     s.output);
  if (!s.can().images && imageOutput)
    throw InputError("--method " + s.method +
                     " makes surfaces, no images; the output must be .vdb .obj .ply .stl .glb "
                     ".exr .png, not " +
                     s.output);
  const std::string method = "--method " + s.method;
  const size_t most = s.can().mostInputs;
  if (!s.can().anyTime && !v.printConfig && lengthOfInputs(s.inputs) > 1)
    throw InputError(method + " takes no sequences, only still inputs");
  if (most > 0 && s.inputs.size() > most)
    throw InputError(method + " takes " + (most == 2 ? "two" : std::to_string(most)) + " inputs, not " +
                     std::to_string(s.inputs.size()));
  if (!s.can().anyTime) {
    if (v.atGiven->count() || v.weightsGiven->count() || s.frames.size() < 2)
      throw InputError(method + " has no times or weights, only steps; ask for --frames N of at least 2");
    for (const char* key : {"keys", "timing", "ease"})
      if (said(key))
        throw InputError(std::string("--") + key + " is not for " + method + ", which only has steps");
  }
  if (!s.can().guided && !s.sliceFolder.empty())
    throw InputError("--dump-slices draws the slices of " + methodsThat(&MethodTraits::guided) +
                     "; the other methods have none");
  return s;
}

}  // namespace slicemorph
