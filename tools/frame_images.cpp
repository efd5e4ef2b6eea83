#include "tools/frame_images.h"

#include "engine/errors.h"
#include "engine/render/render.h"
#include "engine/volume/voxelise.h"
#include "io/fog_reader.h"
#include "tools/common_options.h"
#include "tools/frame_inputs.h"

#include <algorithm>
#include <limits>

namespace slicemorph {
namespace {

/// Points of each input's surface that are followed through the frames, at most.
constexpr size_t kMostPoints = 4000;
/// Of the largest box's diagonal: what shapes may reach beyond the places that are known, and their fog's soft rim.
constexpr double kMargin = 0.02;

openvdb::BBoxd boxAround(const std::vector<openvdb::BBoxd>& boxes) {
  openvdb::BBoxd all;
  for (const openvdb::BBoxd& box : boxes) all.expand(box);
  return all;
}

std::vector<Vec3d> somePoints(const FloatGrid& surface) {
  const std::vector<openvdb::Vec3s> points = surfaceOf(surface).points;
  const size_t step = points.size() / kMostPoints + 1;
  std::vector<Vec3d> some;
  for (size_t i = 0; i < points.size(); i += step) some.emplace_back(points[i]);
  return some;
}

/// A grid that is active in a box of the world and nowhere else.
openvdb::MaskGrid::Ptr boxGrid(const openvdb::BBoxd& box, double voxelSize) {
  const auto grid = openvdb::MaskGrid::create();
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
  grid->fill({openvdb::Coord::floor(grid->worldToIndex(box.min())), openvdb::Coord::ceil(grid->worldToIndex(box.max()))}, true);
  return grid;
}

}  // namespace

void FrameImages::prepare(const FrameMaker& maker, Progress& progress) {
  if (!settings_.moving()) {
    for (const LoadedObject& input : maker.inputs()) survey(input);
    surveyBetween(maker);
  } else {
    FrameInputs inputs(settings_);
    for (size_t i = 0; i < settings_.frames.size(); ++i) {
      progress.report("looking at all frames", double(i) / double(settings_.frames.size()));
      PartProgress quiet(progress, 0, 0);
      if (inputs.moveTo(settings_.frames[i].inputFrame, quiet))
        for (const LoadedObject& input : inputs.loaded()) survey(input);
    }
  }
  const double margin = kMargin * boxAround(boxes_).extents().length();
  for (openvdb::BBoxd& box : boxes_) box = openvdb::BBoxd(box.min() - Vec3d(margin), box.max() + Vec3d(margin));
  if (settings_.exrContent == ExrContent::kSlices) return placePlanes(maker);
  camera_ = cameraFor(boxes_, settings_.picture);
  look_ = lookFor(fogs_, settings_.picture);
  if (!fogs_.empty() && !settings_.picture.extinctionGiven->count())
    notes_.push_back("extinction of the fog: " + formatNumber(look_.extinction, 4) + " per world unit (--extinction sets another)");
}

void FrameImages::survey(const LoadedObject& input) {
  boxes_.push_back(surfaceBox(*input.object.levelSet));
  if (!input.fog || settings_.exrContent == ExrContent::kSlices) return;
  const openvdb::GridBase::ConstPtr density = input.file->read(input.grid);
  openvdb::GridCPtrVec grids;
  for (size_t i = 0; i < input.file->entries().size(); ++i)
    if (i != input.grid && isDrawn(input.file->entries()[i].name)) grids.push_back(input.file->read(i));
  fogs_.push_back(measureFog(fogOf(density, grids)));
  if (!fogs_.back().box.empty()) boxes_.push_back(fogs_.back().box);
}

/// Where the map takes the inputs' surfaces.
void FrameImages::surveyBetween(const FrameMaker& maker) {
  const MorphPlan* plan = maker.slicePlan();
  if (!plan) return;
  const std::vector<LoadedObject>& inputs = maker.inputs();
  for (size_t k = 0; k < inputs.size(); ++k) {
    const std::vector<Vec3d> points = somePoints(*inputs[k].object.levelSet);
    Weights own(inputs.size(), 0);
    own[k] = 1;
    for (const FrameJob& job : settings_.frames) {
      if (job.weights[k] == 0) continue;
      openvdb::BBoxd box;
      for (const Vec3d& p : plan->carryPoints(points, own, job.weights)) box.expand(p);
      boxes_.push_back(box);
    }
  }
}

/// Leaning planes and given ones follow each frame's own shape.
void FrameImages::placePlanes(const FrameMaker& maker) {
  const SliceOptions& slices = settings_.exrSlices;
  if (slices.spine) return;
  double finest = std::numeric_limits<double>::max();
  for (const LoadedObject& input : maker.inputs()) finest = std::min(finest, input.object.levelSet->voxelSize()[0]);
  if (settings_.plan.voxelSize > 0) finest = settings_.plan.voxelSize;
  planes_ = placeSlices(slices, {boxGrid(boxAround(boxes_), finest)}, nullptr, notes_);
}

void FrameImages::write(const FrameJob& job, const MorphFrame& frame) {
  settings_.exrContent == ExrContent::kSlices ? writeSlicesOf(job, frame) : writePictureOf(job, frame);
}

void FrameImages::writePictureOf(const FrameJob& job, const MorphFrame& frame) {
  RenderOptions options = settings_.picture.render;
  options.channels = OutputName(job.path).extension() == ".exr";
  if (frame.density)
    return writePicture(job.path, renderFog(fogOf(frame.density, frame.grids), look_, camera_, options));
  if (!frame.shape.surface)
    throw InputError("--grids names neither the surface nor the density: there is nothing to draw");
  writePicture(job.path, renderSurface(*frame.shape.surface, camera_, options));
}

void FrameImages::writeSlicesOf(const FrameJob& job, const MorphFrame& frame) {
  std::vector<SliceGrid> grids;
  for (const openvdb::GridBase::ConstPtr& grid : frame.grids) grids.push_back({grid->getName(), grid});
  SliceExrOptions exr = settings_.exrSlices.exr;
  exr.t = job.t;
  exr.frame = job.number;
  exr.framesPerSecond = settings_.framesPerSecond;
  if (std::all_of(settings_.inputs.begin(), settings_.inputs.end(), isImageInput)) exr.units = "mm";
  Progress none;
  if (!planes_.empty()) return writeSlicesExr(job.path, grids, planes_, exr, none);
  std::vector<std::string> notes;
  writeSlicesExr(job.path, grids, placeSlices(settings_.exrSlices, frame.grids, frame.shape.surface, notes), exr, none);
  for (const std::string& note : notes) notes_.push_back("frame " + std::to_string(job.number) + ": " + note);
}

}  // namespace slicemorph
