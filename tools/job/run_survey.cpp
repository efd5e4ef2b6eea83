#include "tools/job/survey_job.h"

#include "engine/render/contact_sheet.h"
#include "engine/render/render.h"
#include "engine/volume/mesh_measures.h"
#include "engine/volume/voxelise.h"
#include "io/atomic_file.h"
#include "io/image/png_writer.h"
#include "slicemorph/errors.h"
#include "tools/job/frame_inputs.h"
#include "tools/job/option_values.h"
#include "tools/job/render_shots.h"
#include "tools/job/survey_methods.h"
#include "tools/report/survey_page.h"
#include "tools/report/survey_score.h"
#include "tools/report/survey_table.h"

#include <algorithm>
#include <memory>

namespace slicemorph {
namespace {

/// Shares of the whole time, for the progress: measured on creature to ring, whose methods ran for 25 s.
constexpr double kSurveyRun = 0.85, kSurveyMeasured = 0.92;
/// Pictures side by side.
constexpr int kMostColumns = 9;
/// Frames that leave the box around the inputs are seen whole up to a box of so many times its size.
constexpr double kSeenAround = 2;

/// A shape that a frame is compared with.
struct Target {
  size_t frame;
  std::string name;
  Mesh mesh;
  double diagonal;
};

Target targetOf(size_t frame, const std::string& name, const FloatGrid& levelSet) {
  Target target{frame, name, surfaceOf(levelSet), 0};
  target.diagonal = boundsOf(target.mesh.points).extents().length();
  return target;
}

/// Inputs and true frames.
struct Shapes {
  std::vector<SurveyShape> inputs, truths;
  std::vector<Target> targets;
  std::vector<openvdb::BBoxd> boxes;
  std::vector<FloatGrid::ConstPtr> trueSurfaces;
};

Shapes readShapes(const SurveyJob& job, JobEvents& events) {
  const MorphSettings& settings = job.morph.settings;
  Shapes shapes;
  FrameInputs reader(settings);
  OnlyCancel quiet(events);
  reader.moveTo(0, quiet);
  const std::vector<LoadedObject>& inputs = reader.loaded();
  const size_t last = settings.frames.size() - 1;
  for (size_t k = 0; k < inputs.size(); ++k) {
    const FloatGrid& levelSet = *inputs[k].object.levelSet;
    shapes.inputs.push_back(
        {settings.inputs[k], measureShape(levelSet), double(k) / double(inputs.size() - 1)});
    shapes.boxes.push_back(surfaceBox(levelSet));
    if (k == 0) shapes.targets.push_back(targetOf(0, settings.inputs[k], levelSet));
    if (k + 1 == inputs.size()) shapes.targets.push_back(targetOf(last, settings.inputs[k], levelSet));
  }
  LoadOptions load = settings.load;
  load.isosByInput.clear();
  for (const SurveyTruth& truth : job.truths) {
    events.throwIfCancelled();
    const LoadedObject object = loadObject(truth.file, load);
    events.notes(about(truth.file, object.notes));
    const FloatGrid& levelSet = *object.object.levelSet;
    shapes.truths.push_back({truth.file, measureShape(levelSet), truth.t});
    shapes.boxes.push_back(surfaceBox(levelSet));
    shapes.targets.push_back(targetOf(truth.frame, truth.file, levelSet));
    shapes.trueSurfaces.push_back(object.object.levelSet);
  }
  return shapes;
}

/// Does something with each frame of a method, read from its file.
template <typename Action>
void forFrames(const MethodRun& run, const MorphSettings& settings, const Action& action) {
  if (run.method.frames.empty()) return;
  LoadOptions load;
  load.memory = settings.load.memory;
  const std::vector<RenderInput> files = listRenderInputs({run.files}, {});
  RenderSubjects subjects(files, load, false);
  for (size_t i = 0; i < files.size(); ++i) action(i, subjects.get(i));
}

/// What the pictures of a method show.
struct Seen {
  openvdb::BBoxd box;  ///< empty: nothing
  std::vector<FogMeasure> fogs;
};

/// Measures the distances of a method's frames.
Seen measureFrames(MethodRun& run, const MorphSettings& settings, const std::vector<Target>& targets) {
  Seen seen;
  forFrames(run, settings, [&](size_t index, const RenderSubject& subject) {
    if (subject.fog) {
      seen.fogs.push_back(measureFog(*subject.fog));
      if (!seen.fogs.back().box.empty()) seen.box.expand(seen.fogs.back().box);
    }
    if (!subject.surface || subject.surface->empty()) return;
    seen.box.expand(surfaceBox(*subject.surface));
    for (const Target& target : targets) {
      if (target.frame != index) continue;
      const Mesh mesh = surfaceOf(*subject.surface);
      if (mesh.triangles.empty()) continue;
      run.method.frames[index].distance = {target.name, surfaceDistance(mesh, target.mesh), target.diagonal};
    }
  });
  return seen;
}

openvdb::BBoxd scaled(const openvdb::BBoxd& box, double factor) {
  const Vec3d half = box.extents() * factor / 2;
  return {box.getCenter() - half, box.getCenter() + half};
}

/// One camera for all methods.
Camera cameraOf(const Shapes& shapes, const std::vector<Seen>& seen, const PictureOptions& picture) {
  openvdb::BBoxd all;
  for (const openvdb::BBoxd& box : shapes.boxes) all.expand(box);
  const openvdb::BBoxd most = scaled(all, kSeenAround);
  std::vector<openvdb::BBoxd> boxes = {all};
  for (const Seen& of : seen) {
    if (of.box.empty()) continue;
    const openvdb::BBoxd box(openvdb::math::maxComponent(of.box.min(), most.min()),
                             openvdb::math::minComponent(of.box.max(), most.max()));
    if (!box.empty()) boxes.push_back(box);
  }
  return cameraFor(boxes, picture);
}

/// In one row the page says the times above all sheets.
bool isOneRow(const MorphSettings& settings) { return settings.frames.size() <= size_t(kMostColumns); }

std::string captionOf(const MorphSettings& settings, size_t frame) {
  return isOneRow(settings) ? "" : "t=" + formatNumber(*settings.frames[frame].t, 3);
}

Picture pictureOf(const RenderSubject& subject, const std::vector<FogMeasure>& fogs, const Camera& camera,
                  const PictureOptions& picture) {
  if (subject.fog) return renderFog(*subject.fog, lookFor(fogs, picture), camera, picture.render);
  if (subject.surface) return renderSurface(*subject.surface, camera, picture.render, subject.colors.get());
  return Film(camera, picture.render).take();
}

std::string sheetOf(const std::vector<Tile>& tiles) {
  return tiles.empty() ? "" : encodePng(contactSheet(tiles, std::min(kMostColumns, int(tiles.size()))));
}

std::string drawFrames(const MethodRun& run, const MorphSettings& settings,
                       const std::vector<FogMeasure>& fogs, const Camera& camera) {
  std::vector<Tile> tiles;
  forFrames(run, settings, [&](size_t index, const RenderSubject& subject) {
    tiles.push_back({pictureOf(subject, fogs, camera, settings.picture), captionOf(settings, index)});
  });
  return sheetOf(tiles);
}

/// The true frames where they are among the others.
std::string drawTruths(const SurveyJob& job, const Shapes& shapes, const Camera& camera) {
  if (job.truths.empty()) return "";
  const PictureOptions& picture = job.morph.settings.picture;
  std::vector<Tile> tiles(job.morph.settings.frames.size(), {Film(camera, picture.render).take(), ""});
  for (size_t i = 0; i < job.truths.size(); ++i) {
    const size_t frame = job.truths[i].frame;
    tiles[frame] = {pictureOf({shapes.trueSurfaces[i], nullptr, std::nullopt}, {}, camera, picture),
                    captionOf(job.morph.settings, frame)};
  }
  return sheetOf(tiles);
}

/// Moves notes that all methods with frames have to the whole.
std::vector<std::string> takeCommonNotes(std::vector<SurveyMethod>& methods) {
  const auto isIn = [](const std::vector<std::string>& notes, const std::string& note) {
    return std::find(notes.begin(), notes.end(), note) != notes.end();
  };
  const auto first = std::find_if(methods.begin(), methods.end(),
                                  [](const SurveyMethod& method) { return !method.frames.empty(); });
  std::vector<std::string> common;
  if (first == methods.end()) return common;
  for (const std::string& note : first->notes)
    if (std::all_of(methods.begin(), methods.end(), [&](const SurveyMethod& method) {
          return method.frames.empty() || isIn(method.notes, note);
        }))
      common.push_back(note);
  for (SurveyMethod& method : methods) {
    std::vector<std::string>& notes = method.notes;
    notes.erase(std::remove_if(notes.begin(), notes.end(),
                               [&](const std::string& note) { return isIn(common, note); }),
                notes.end());
  }
  return common;
}

std::string voxelsInWords(const MorphSettings& settings) {
  const LoadOptions& load = settings.load;
  return std::to_string(settings.frames.size()) + " frames, " +
         (load.voxelSize > 0
              ? "voxels of " + formatNumber(load.voxelSize) + " world units"
              : std::to_string(load.resolution) + " voxels along the longest side of each input");
}

/// Both files appear whole, or none.
void writeFiles(const SurveyJob& job, const SurveyResult& survey, JobEvents& events) {
  AtomicFile page(job.page);
  page.write(surveyPage(survey));
  std::unique_ptr<AtomicFile> table;
  if (!job.table.empty()) {
    table = std::make_unique<AtomicFile>(job.table);
    table->write(surveyTable(survey));
    table->commit();
  }
  page.commit();
  events.fileWritten(job.page, false);
  if (table) events.fileWritten(job.table, false);
}

}  // namespace

void runSurvey(const SurveyJob& job, JobEvents& events) {
  const MorphSettings& settings = job.morph.settings;
  const ScratchFolder scratch;
  // Before anything is read: a process that is started begins with what this one holds, see ChildEnd::peakBytes.
  PartProgress running(events, 0, kSurveyRun);
  std::vector<MethodRun> runs = runMethods(job, scratch, running);
  events.report("measuring", kSurveyRun);
  const Shapes shapes = readShapes(job, events);
  std::vector<Seen> seen;
  for (size_t i = 0; i < runs.size(); ++i) {
    events.throwIfCancelled();
    events.report("measuring", kSurveyRun + (kSurveyMeasured - kSurveyRun) * double(i) / double(runs.size()));
    seen.push_back(measureFrames(runs[i], settings, shapes.targets));
  }
  const Camera camera = cameraOf(shapes, seen, settings.picture);
  SurveyResult survey;
  survey.inputs = shapes.inputs, survey.truths = shapes.truths, survey.voxels = voxelsInWords(settings);
  if (isOneRow(settings))
    for (const FrameJob& frame : settings.frames) survey.sheetTimes.push_back(*frame.t);
  survey.truthSheet = drawTruths(job, shapes, camera);
  for (size_t i = 0; i < runs.size(); ++i) {
    events.throwIfCancelled();
    events.report("drawing", kSurveyMeasured + (1 - kSurveyMeasured) * double(i) / double(runs.size()));
    SurveyMethod& method = runs[i].method;
    method.sheet = drawFrames(runs[i], settings, seen[i].fogs, camera);
    if (!method.surface) method.unranked = "makes values and no surface";
    scoreMethod(method, survey.inputs, survey.truths);
    survey.methods.push_back(std::move(method));
  }
  sortByScore(survey.methods);
  survey.notes = takeCommonNotes(survey.methods);
  writeFiles(job, survey, events);
}

}  // namespace slicemorph
