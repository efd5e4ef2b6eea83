#include "tools/job/make_frame.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/job/carry_grids.h"
#include "tools/job/carry_image.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// Whether the shape is used: by the output, its colours, slices across its spine or the report.
bool needsShape(const FrameTask& task) {
  const MorphSettings& s = task.settings;
  const FrameContent& content = task.plan.content;
  const bool leaning = s.toFrameImages() && s.exrSlices.spine;
  const bool colored = s.holdsGrids() && !content.colorName.empty();
  return (content.surface && !isImageOutput(s.output)) || leaning || colored || !s.reports.empty();
}

/// Whether all inputs that count at a frame hold nothing.
bool isNothing(const FrameTask& task) {
  bool nothing = true;
  for (size_t k = 0; k < task.inputs.size(); ++k)
    if (task.job.weights[k] > 0) nothing = nothing && task.inputs[k].nothing;
  return nothing && task.settings.plan.regions.empty();
}

/// A level set without voxels.
FloatGrid::Ptr withoutSurface(const FloatGrid& like) {
  const FloatGrid::Ptr none = FloatGrid::create(like.background());
  none->setTransform(like.transform().copy());
  none->setGridClass(openvdb::GRID_LEVEL_SET);
  return none;
}

openvdb::GridBase::ConstPtr surfaceOfFrame(const FrameTask& task, const FloatGrid& surface, bool half) {
  SurfaceOutput options;
  options.name = task.plan.content.surfaceName;
  options.doubles = std::all_of(task.inputs.begin(), task.inputs.end(),
                                [](const LoadedObject& input) { return input.doubles; });
  options.halfFloat = half;
  options.vdb.framesPerSecond = task.settings.framesPerSecond;
  options.vdb.frame = task.job.number;
  return surfaceGrid(surface, options);
}

}  // namespace

MorphFrame coloredShape(const FrameTask& task) {
  MorphFrame frame;
  frame.shape = task.plan.method.shape(task.job);
  if (frame.shape.surface && isNothing(task)) {
    frame.shape.surface = withoutSurface(*frame.shape.surface);
    return frame;
  }
  if (!frame.shape.surface || task.plan.content.colorName.empty()) return frame;
  Pullback pullback = task.plan.method.pullback(task.job.weights);
  std::vector<openvdb::Vec3SGrid::ConstPtr> own;
  for (const LoadedObject& input : task.inputs) own.push_back(input.colors);
  const openvdb::Vec3SGrid::Ptr colors = pullback.colors(*frame.shape.surface, own);
  colors->setName(task.plan.content.colorName);
  frame.colors = colors;
  return frame;
}

MorphFrame makeFrame(const FrameTask& task, const Progress& cancel) {
  const MorphSettings& s = task.settings;
  const FrameContent& content = task.plan.content;
  MorphFrame frame;
  if (needsShape(task)) frame = coloredShape(task);
  if (content.images || content.labelFigures) frame.image = imageBetween(task);
  if (content.labelFigures) frame.labels = measureLabels(*frame.image);
  if (!content.images) frame.image.reset();
  if (!s.holdsGrids()) return frame;
  const bool half = std::all_of(task.inputs.begin(), task.inputs.end(),
                                [](const LoadedObject& input) { return input.halfFloat; });
  if (content.surface) frame.grids.push_back(surfaceOfFrame(task, *frame.shape.surface, half));
  if (frame.colors) frame.grids.push_back(frame.colors);
  if (frame.image) {
    const bool labels = task.inputs[0].labels;
    frame.grids.push_back(gridOf(*frame.image, labels ? "labels" : "image", labels));
    frame.image.reset();
  }
  if (!s.can().grids || (content.sets.empty() && !s.velocity.wanted())) return frame;
  const openvdb::GridBase::ConstPtr where = content.surface ? frame.grids[0] : nullptr;
  CarriedGrids carried = carryGrids(task, where, std::move(frame.grids), half, cancel);
  frame.grids = std::move(carried.grids);
  frame.density = carried.density;
  return frame;
}

double isoOf(const FrameTask& task) {
  double iso = 0;
  const Weights weights = withoutNegatives(task.job.weights);
  for (size_t k = 0; k < task.inputs.size(); ++k) iso += weights[k] * task.inputs[k].iso;
  return iso;
}

}  // namespace slicemorph
