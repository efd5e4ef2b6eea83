#include "tools/job/run_demo.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "slicemorph/io/output.h"
#include "tools/job/cut_slices.h"
#include "tools/job/morph_checks.h"
#include "tools/job/morph_job.h"
#include "tools/job/render_pictures.h"
#include "tools/job/run_morph.h"
#include "tools/job/work_steps.h"

#include <filesystem>

namespace slicemorph {
namespace {

/// Few enough for a contact sheet that is seen at once.
constexpr int kDemoFrames = 9, kHalfWay = (kDemoFrames + 1) / 2, kDemoSlices = 64;
/// What the steps take, in any unit, for the progress; measured on the bundled shapes.
constexpr double kMorphed = 20, kMeshed = 3, kSliced = 2, kRendered = 8;

using Texts = std::vector<std::string>;

/// The options of a command as if they had been typed.
OptionSet demoOptions(Command command, const DemoJob& job,
                      const std::vector<std::pair<std::string, Texts>>& given) {
  OptionSet options(command);
  for (const auto& [name, texts] : given) options.set(options.row(name), texts);
  if (!job.memory.empty()) options.set(options.row("memory"), {job.memory});
  return options;
}

void makeMeshes(const std::string& from, const std::string& to, JobEvents& events) {
  for (int frame = 1; frame <= kDemoFrames; ++frame) {
    events.throwIfCancelled();
    events.report("meshing", double(frame - 1) / kDemoFrames);
    const LoadedObject object = loadObject(parseInput(OutputName(from).path(frame)), {});
    writeSurface(OutputName(to).path(frame), *object.object.levelSet);
  }
}

}  // namespace

std::vector<DemoResult> runDemo(const DemoJob& job, JobEvents& events) {
  WorkSteps steps;
  for (const double cost : {kMorphed, kMeshed, kSliced, kRendered}) steps.add(cost);
  // Names of files are not told one by one: there are too many, and a list follows.
  StepEvents morphed(events, steps, 0), meshed(events, steps, 1), sliced(events, steps, 2),
      rendered(events, steps, 3);
  const std::string top = job.folder + "/";
  for (const char* folder : {"vdb", "mesh", "slices", "pictures"})
    std::filesystem::create_directories(top + folder);
  const auto sequence = [&](const char* folder, const char* ending) {
    return top + folder + "/" + job.name + ".####" + ending;
  };
  const std::string vdb = sequence("vdb", ".vdb"), mesh = sequence("mesh", ".ply"),
                    slices = sequence("slices", ".exr"), pictures = sequence("pictures", ".png"),
                    sheet = top + job.name + ".png", report = top + "report.json";

  const OptionSet morph = demoOptions(kMorph, job,
                                      {{"inputs", job.inputs},
                                       {"output", {vdb}},
                                       {"frames", {std::to_string(kDemoFrames)}},
                                       {"report", {report}}});
  const MorphJob morphing = morphJob(morph);
  checkMorphFiles(morphing.settings, morph);
  runMorph(morphing.settings, morphed);
  makeMeshes(vdb, mesh, meshed);
  cutSlices(cutJob(demoOptions(kSlice, job,
                               {{"input", {OutputName(vdb).path(kHalfWay)}},
                                {"output", {slices}},
                                {"slices", {std::to_string(kDemoSlices)}}})),
            sliced);
  renderPictures(renderJob(demoOptions(
                     kRender, job, {{"inputs", {vdb}}, {"output", {pictures}}, {"contact-sheet", {sheet}}})),
                 rendered);
  return {{sheet, "all frames on one sheet: look at this first"},
          {vdb, "level sets, for Houdini, Blender, vdb_view"},
          {mesh, "meshes"},
          {slices, "oriented slices of frame " + std::to_string(kHalfWay) + ": signed distance and coverage"},
          {pictures, "pictures"},
          {report, "volume, pieces, genus and seconds of every frame"}};
}

}  // namespace slicemorph
