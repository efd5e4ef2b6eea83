#include "tools/job/survey_job.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/job_file.h"
#include "tools/job/morph_checks.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Options of `survey` that are not those of each method's morph, though `morph` has some of that name.
constexpr const char* kOwn[] = {"output", "method", "view", "up", "quiet", "verbose"};
/// What a job file says for one run of `morph` only; it counts for nothing here, and no note need say so.
constexpr const char* kOfOneRun[] = {"output", "report", "dump-slices", "resume", "range", "method", "start"};
/// Names of frames, in the scratch folder of the run.
constexpr const char* kFrames = "frame.####.vdb";
/// What this program chooses for each method.
constexpr const char* kChosenHere[] = {"output", "grids", "velocity", "config"};
/// Of a picture, pixels: nine of them go side by side on a page.
constexpr const char* kPictureSize = "216x180";
/// A truth's time may be typed with so few digits: half of the last of three.
constexpr double kTruthTime = 5e-4;

template <typename Names>
bool isIn(const Names& names, const std::string& name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

bool hasOption(const OptionSet& options, const std::string& name) {
  return std::any_of(options.rows().begin(), options.rows().end(),
                     [&](const OptionRow* row) { return row->name == name; });
}

/// The options of `survey` that `morph` has, too, from the command line and the job file.
struct MorphPart {
  OptionSet options = OptionSet(kMorph);
  Notes notes;
};

/// Whether an option of `morph` counts for every method.
bool counts(const OptionRow& row, const OptionSet& options) {
  return !row.field || (hasOption(options, row.name) && !isIn(kOwn, row.name));
}

/// Takes over what the job file says, within the ranges that `survey` has. Returns notes on what counts for nothing.
Notes takeJobFile(OptionSet& morph, const OptionSet& options) {
  Notes notes;
  applyJobFile(JobFile(options.values()), morph);
  for (const OptionRow* row : morph.rows()) {
    if (morph.source(row->name).empty()) continue;
    if (!counts(*row, options)) {
      if (!isIn(kOfOneRun, row->name))
        notes.push_back({"survey.option-unused", Severity::kNote, morph.source(row->name) + row->name,
                         "is not for survey and counts for nothing here"});
    } else if (row->field) {
      JobOptions checked;
      morph.about(row->name, [&] { setField(options.row(row->name), morph.texts(row->name), checked); });
    }
  }
  return notes;
}

MorphPart morphPart(const OptionSet& options) {
  OptionSet all(kMorph);
  for (const OptionRow* row : all.rows())
    if (hasOption(options, row->name) && counts(*row, options) && !options.texts(row->name).empty())
      all.set(*row, options.texts(row->name));
  MorphPart part;
  if (!options.values().config.empty()) part.notes = takeJobFile(all, options);
  for (const OptionRow* row : all.rows()) {
    if (!counts(*row, options)) continue;
    const std::vector<std::string> texts = all.texts(row->name);
    if (!texts.empty()) part.options.set(part.options.row(row->name), texts);
    if (!all.source(row->name).empty()) part.options.setSource(row->name, all.source(row->name));
  }
  const auto setUnlessGiven = [&](const char* name, const char* other, int value) {
    if (!part.options.given(name) && (!*other || !part.options.given(other)))
      part.options.set(part.options.row(name), {std::to_string(value)});
  };
  setUnlessGiven("frames", "", kSurveyFrames);
  setUnlessGiven("resolution", "voxel-size", kSurveyResolution);
  part.options.set(part.options.row("output"), {kFrames});
  part.options.set(part.options.row("grids"), {"surface"});
  part.options.set(part.options.row("velocity"), {"none"});
  return part;
}

/// The pictures' options.
PictureOptions pictureOf(const OptionSet& options, const MorphOptions& plan) {
  OptionSet pictures(kMorph);
  pictures.set(pictures.row("size"), {kPictureSize});
  // Upright objects are seen upright.
  if (plan.up[2] > 0 && !options.given("up") && !options.given("view"))
    pictures.set(pictures.row("up"), {"z"}), pictures.set(pictures.row("view"), {"-0.55,1,-0.3"});
  for (const char* name : {"view", "up"})
    if (options.given(name)) pictures.set(pictures.row(name), options.texts(name));
  return checkedPicture(pictures);
}

std::vector<SurveyJob::Asked> methodsOf(const OptionSet& options) {
  const std::vector<std::string>& given = options.values().methods;
  std::vector<SurveyJob::Asked> methods;
  for (const std::string& text : given.empty() ? methodNames() : given)
    methods.push_back({text, options.about("method", [&] { return &methodNamed(methodChoice(text).name); })});
  return methods;
}

/// `t=0.5:middle.obj`
SurveyTruth truthOf(const std::string& text, const OptionSet& options, const std::vector<FrameJob>& frames) {
  const std::string said = "--truth " + text + ": ";
  const size_t colon = text.find(':');
  SurveyTruth truth;
  if (text.rfind("t=", 0) != 0 || colon == std::string::npos || colon + 1 == text.size())
    options.refuse("truth", said + "expected t=T:FILE, for example --truth t=0.5:middle.obj");
  const std::vector<double> numbers = parseNumbers("--truth", text.substr(2, colon - 2));
  truth.t = numbers[0], truth.file = text.substr(colon + 1);
  if (numbers.size() != 1 || truth.t <= 0 || truth.t >= 1)
    options.refuse("truth", said + "T must be one time between 0 and 1, where the inputs are");
  for (; truth.frame < frames.size(); ++truth.frame)
    if (std::abs(*frames[truth.frame].t - truth.t) < kTruthTime) break;
  if (truth.frame == frames.size())
    options.refuse("truth", said + "none of the " + std::to_string(frames.size()) +
                                " frames is at that time; they are 1/" + std::to_string(frames.size() - 1) +
                                " apart, choose others by --frames N");
  truth.t = *frames[truth.frame].t;
  options.about("truth", [&] { checkInputExists(truth.file); });
  if (isMovingInput(truth.file)) options.refuse("truth", said + "is a sequence; name one of its files");
  return truth;
}

std::vector<SurveyTruth> truthsOf(const OptionSet& options, const std::vector<FrameJob>& frames) {
  std::vector<SurveyTruth> truths;
  for (const std::string& text : options.values().truths) {
    const SurveyTruth truth = truthOf(text, options, frames);
    for (const SurveyTruth& other : truths)
      if (other.frame == truth.frame)
        options.refuse("truth", "--truth " + text + ": there is one of t=" + formatNumber(truth.t) +
                                    " already, " + other.file);
    truths.push_back(truth);
  }
  return truths;
}

void checkFiles(const SurveyJob& job, const OptionSet& options) {
  if (extensionOf(job.page) != ".html" || OutputName(job.page).isSequence())
    options.refuse("output", "-o " + job.page + ": the page is one file name.html");
  options.about("output", [&] { checkOutputPath(job.page); });
  if (job.table.empty()) return;
  if (extensionOf(job.table) != ".csv" || OutputName(job.table).isSequence())
    options.refuse("csv", "--csv " + job.table + ": the table is one file name.csv");
  options.about("csv", [&] { checkOutputPath(job.table); });
}

void checkInputs(const OptionSet& options) {
  const std::vector<std::string>& inputs = options.values().inputs;
  if (inputs.size() < 2)
    options.refuse("inputs", "survey needs two inputs or more, not " + std::to_string(inputs.size()) +
                                 "; for example: slicemorph survey a.obj b.obj -o survey.html");
  for (const std::string& input : inputs) {
    options.about("inputs", [&] { checkInputExists(input); });
    if (isMovingInput(input))
      options.refuse("inputs", input + ": is a sequence; survey takes still inputs, name one of its files");
  }
}

}  // namespace

SurveyJob surveyJob(const OptionSet& options) {
  options.checkExclusions();
  SurveyJob job;
  job.page = options.values().output, job.table = options.values().tableFile;
  checkFiles(job, options);
  job.methods = methodsOf(options);
  const MorphPart part = morphPart(options);
  checkInputs(part.options);
  job.morph = morphJob(part.options);
  job.morph.notes.insert(job.morph.notes.begin(), part.notes.begin(), part.notes.end());
  job.morph.settings.picture = pictureOf(options, job.morph.settings.plan);
  job.truths = truthsOf(options, job.morph.settings.frames);
  for (const OptionRow* row : part.options.rows()) {
    const std::vector<std::string> texts = part.options.texts(row->name);
    if (!texts.empty() && row->positional.empty() && !isIn(kChosenHere, row->name))
      job.given.push_back({row, texts});
  }
  return job;
}

}  // namespace slicemorph
