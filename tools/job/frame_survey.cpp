#include "tools/job/frame_survey.h"

#include "engine/render/render.h"
#include "engine/sections/object_boxes.h"
#include "engine/volume/fog.h"
#include "engine/volume/voxelise.h"
#include "io/vdb/fog_reader.h"
#include "io/vdb/grid_box.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// Most points of each input's surface that are followed through the frames: bounds the time. What lies
/// between them is covered by the margin of frame_images.cpp.
constexpr size_t kMostFollowedPoints = 4000;

std::vector<Vec3d> somePoints(const FloatGrid& surface) {
  const std::vector<openvdb::Vec3s> points = surfaceOf(surface).points;
  const size_t step = points.size() / kMostFollowedPoints + 1;
  std::vector<Vec3d> some;
  for (size_t i = 0; i < points.size(); i += step) some.emplace_back(points[i]);
  return some;
}

void addCorners(const openvdb::BBoxd& box, std::vector<Vec3d>& points) {
  for (int c = 0; c < 8; ++c)
    points.emplace_back((c & 1 ? box.max() : box.min())[0], (c & 2 ? box.max() : box.min())[1],
                        (c & 4 ? box.max() : box.min())[2]);
}

openvdb::BBoxd boxOf(const ImageLattice& lattice) {
  openvdb::BBoxd box;
  for (int c = 0; c < 8; ++c)
    box.expand(lattice.toWorld(Vec3d((c & 1) * (lattice.size[0] - 1), (c >> 1 & 1) * (lattice.size[1] - 1),
                                     (c >> 2) * (lattice.size[2] - 1))));
  return box;
}

/// The active box of a grid in a file, in world units.
openvdb::BBoxd boxInFile(const VdbFile& file, size_t index, const openvdb::GridBase& header) {
  const openvdb::CoordBBox box = activeBoxIn(file, index, header);
  return box.empty() ? openvdb::BBoxd() : header.transform().indexToWorld(box);
}

/// What is to be surveyed.
struct SurveyTask {
  const MorphSettings& settings;
  bool slices;  ///< for slices of all grids, else for pictures
  bool fog;     ///< inputs are shown as fog
};

/// Extent of an input's grids that are sliced.
struct GridExtent {
  openvdb::BBoxd box;  ///< world
  double finest = 0;   ///< voxel size, world units; 0: none
};

void takeFiner(double& finest, double size) { finest = finest > 0 ? std::min(finest, size) : size; }

double smallestOf(const Vec3d& sizes) { return std::min({sizes[0], sizes[1], sizes[2]}); }

GridExtent extentOfGrids(const LoadedObject& input, const SurveyTask& task) {
  GridExtent extent;
  if (input.image) {
    extent.box = boxOf(input.image->lattice);
    takeFiner(extent.finest, smallestOf(input.image->lattice.spacing()));
  }
  if (!input.image && !input.fog) takeFiner(extent.finest, input.object.levelSet->voxelSize()[0]);
  if (!input.file || !task.settings.can().grids) return extent;
  for (size_t i = 0; i < input.file->entries().size(); ++i) {
    const openvdb::GridBase::Ptr header = placed(input.file->readHeader(i), input.placing);
    if (!header || !isSliceable(*header)) continue;
    const std::vector<std::string>& wanted = task.settings.grids;
    if (!wanted.empty() && std::count(wanted.begin(), wanted.end(), header->getName()) == 0) continue;
    const openvdb::BBoxd own = boxInFile(*input.file, i, *header);
    if (own.empty()) continue;
    extent.box.expand(own);
    takeFiner(extent.finest, smallestOf(header->voxelSize()));
  }
  return extent;
}

/// An input as fog, with the heat and colour grids drawn with it; a solid as fog with a soft rim.
Fog fogOfInput(const LoadedObject& input) {
  if (!input.fog) {
    Fog fog;
    fog.density = fogOf(*input.object.levelSet);
    return fog;
  }
  Fog none;
  none.density = FloatGrid::create(0.f);
  if (input.grid == LoadedObject::kNoGrid) return none;
  openvdb::GridCPtrVec grids;
  for (size_t i = 0; i < input.file->entries().size(); ++i)
    if (i != input.grid && isDrawn(input.file->entries()[i].name))
      grids.push_back(placed(input.file->read(i), input.placing));
  return fogOf(placed(input.file->read(input.grid), input.placing), grids);
}

/// Adds the box of an input with all that is shown of it.
void surveyInput(const LoadedObject& input, const SurveyTask& task, FrameSurvey& survey) {
  openvdb::BBoxd box = surfaceBox(*input.object.levelSet);
  if (task.slices) {
    const GridExtent grids = extentOfGrids(input, task);
    box.expand(grids.box);
    if (grids.finest > 0) takeFiner(survey.finest, grids.finest);
  } else if (task.fog) {
    survey.fogs.push_back(measureFog(fogOfInput(input)));
    if (!survey.fogs.back().box.empty()) box.expand(survey.fogs.back().box);
  }
  survey.boxes.push_back(box);
}

/// Adds the boxes of the inputs' surfaces, and of what surrounds them, as the map moves them in each frame.
/// `reach`: per input, the box of what surrounds it; empty: nothing of that is shown.
void surveyBetween(const FrameMaker& maker, const MorphSettings& settings,
                   const std::vector<openvdb::BBoxd>& reach, FrameSurvey& survey) {
  const MorphPlan* plan = maker.plan().slices.get();
  if (!plan) return;
  const std::vector<LoadedObject>& inputs = maker.inputs();
  for (size_t k = 0; k < inputs.size(); ++k) {
    std::vector<Vec3d> points = somePoints(*inputs[k].object.levelSet), before;
    if (!reach[k].empty()) addCorners(reach[k], points);
    for (const FrameJob& job : settings.frames) {
      if (job.weights[k] == 0 && settings.plan.regions.empty()) continue;
      const std::vector<Vec3d> there = plan->carryPoints(points, k, job.weights);
      openvdb::BBoxd box;
      for (const Vec3d& p : there) box.expand(p);
      survey.boxes.push_back(box);
      for (size_t i = 0; i < before.size(); ++i)
        survey.fastest = std::max(survey.fastest, (there[i] - before[i]).length());
      before = there;
    }
  }
}

}  // namespace

openvdb::BBoxd boxAround(const std::vector<openvdb::BBoxd>& boxes) {
  openvdb::BBoxd all;
  for (const openvdb::BBoxd& box : boxes) all.expand(box);
  return all;
}

FrameSurvey surveyFrames(const MorphSettings& settings, const FrameMaker& maker, Progress& progress) {
  const std::vector<LoadedObject>& first = maker.inputs();
  const bool anyFog =
      std::any_of(first.begin(), first.end(), [](const LoadedObject& input) { return input.fog; });
  const SurveyTask task{settings, settings.exrContent == ExrContent::kSlices,
                        anyFog || !settings.can().surface};
  FrameSurvey survey;
  for (const LoadedObject& input : first) surveyInput(input, task, survey);
  std::vector<openvdb::BBoxd> reach = survey.boxes;
  // Where only surfaces are shown, their surroundings need no room.
  if (!task.fog && !task.slices) reach.assign(reach.size(), openvdb::BBoxd());
  surveyBetween(maker, settings, reach, survey);
  if (!settings.moving()) return survey;
  FrameInputs inputs(settings);
  for (size_t i = 0; i < settings.frames.size(); ++i) {
    progress.report("looking at all frames", double(i) / double(settings.frames.size()));
    OnlyCancel quiet(progress);
    if (!inputs.moveTo(settings.frames[i].inputFrame, quiet).changed) continue;
    for (const LoadedObject& input : inputs.loaded()) surveyInput(input, task, survey);
  }
  return survey;
}

}  // namespace slicemorph
