#include "tools/job/pick_job.h"

#include "io/atomic_file.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "tools/job/frame_maker.h"
#include "tools/job/input_names.h"
#include "tools/job/job_file.h"
#include "tools/job/option_values.h"
#include "tools/report/page_template.h"
#include "tools/report/pick_part.h"

#include <filesystem>

namespace slicemorph {
namespace {

/// Reading and planning in the time for a page.
constexpr double kBeforeDrawing = 0.8;

/// The options of the morph: those of `pick` that it has, too, and those of the job file.
OptionSet morphOptions(const OptionSet& options) {
  OptionSet morph(kMorph);
  for (const OptionRow* row : options.rows()) {
    const std::vector<std::string> texts = options.texts(row->name);
    if (!texts.empty() && row->name != "output" && row->name != "no-plan")
      morph.set(morph.row(row->name), texts);
  }
  if (!morph.values().config.empty()) applyJobFile(JobFile(morph.values()), morph);
  return morph;
}

/// The frames' names where none are given: `horse_to_spot.####.vdb`.
std::string outputFor(const std::vector<std::string>& inputs) {
  return stemOfInput(inputs.front()) + "_to_" + stemOfInput(inputs.back()) + ".####.vdb";
}

std::vector<std::string> toldOf(const Notes& notes) {
  std::vector<std::string> sentences;
  for (const Note& note : notes)
    if (note.severity != Severity::kDetail) sentences.push_back(note.sentence());
  return sentences;
}

}  // namespace

PickJob pickJob(const OptionSet& options) {
  options.checkExclusions();
  PickJob job;
  job.output = options.values().output, job.plan = !options.values().noPlan;
  if (extensionOf(job.output) != ".html" || OutputName(job.output).isSequence())
    options.refuse("output", "-o " + job.output + ": the page is one file name.html");
  checkOutputPath(job.output);
  OptionSet morph = morphOptions(options);
  const std::vector<std::string>& inputs = morph.values().inputs;
  if (inputs.size() < 2)
    morph.refuse("inputs", "pick needs two inputs or more, not " + std::to_string(inputs.size()) +
                               "; for example: slicemorph pick a.obj b.obj -o pairs.html");
  if (morph.values().output.empty()) morph.set(morph.row("output"), {outputFor(inputs)});
  job.morph = morphJob(morph);
  const MorphSettings& settings = job.morph.settings;
  if (!settings.can().guided)
    morph.refuse("method",
                 "--method " + settings.method +
                     " matches no slices, which pick shows; leave it out: features that are pointed at "
                     "serve each method that takes them");
  for (const std::string& input : settings.inputs) morph.about("inputs", [&] { checkInputExists(input); });
  if (settings.jobText.empty())
    morph.refuse("inputs", "pick: a job file cannot hold one of these names, which must be UTF-8");
  return job;
}

std::string pickPartOf(const MorphSettings& settings, const std::vector<LoadedObject>& inputs,
                       const MorphPlan* plan, const std::string& file, const Notes& notes,
                       const Progress& cancel) {
  PickSceneJob scene;
  scene.names = settings.inputs, scene.plan = plan, scene.up = settings.plan.up;
  for (const LoadedObject& input : inputs)
    scene.levelSets.push_back(input.object.levelSet), scene.colors.push_back(input.colors);
  PickTexts texts{file, settings.jobText};
  // Landmarks stand behind the job file's features.
  const std::vector<Feature>& features = settings.plan.features;
  texts.features.assign(features.begin(), features.end() - std::ptrdiff_t(settings.landmarks.size()));
  texts.landmarks = settings.landmarks, texts.notes = toldOf(notes);
  return pickPart(pickScene(scene, cancel), texts);
}

void runPick(const PickJob& job, JobEvents& caller) {
  NoteKeeper events(caller);
  const MorphSettings& settings = job.morph.settings;
  const std::string file = std::filesystem::path(job.output).stem().string() + ".toml";
  std::string part;
  if (settings.moving())
    events.note({"pick.first-of-sequence", Severity::kNote, "",
                 "of sequences the first files are shown; features are places on these"});
  if (job.plan) {
    FrameMaker maker(settings, events);
    maker.moveTo(0, 0, kBeforeDrawing);
    events.report("drawing", kBeforeDrawing);
    part = pickPartOf(settings, maker.inputs(), maker.plan().slices.get(), file, events.kept(), events);
  } else {
    FrameInputs inputs(settings);
    PartProgress reading(events, 0, kBeforeDrawing);
    const FrameInputs::Step step = inputs.moveTo(settings.frames[0].inputFrame, reading);
    events.notes(step.notes), events.notes(step.nothing);
    events.report("drawing", kBeforeDrawing);
    part = pickPartOf(settings, inputs.loaded(), nullptr, file, events.kept(), events);
  }
  writeTextFile(job.output, pageWith(part));
  events.fileWritten(job.output, false);
}

}  // namespace slicemorph
