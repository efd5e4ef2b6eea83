#include "tools/job/frame_images.h"

#include "engine/render/render.h"
#include "io/vdb/fog_reader.h"
#include "slicemorph/errors.h"
#include "tools/job/frame_survey.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <map>

namespace slicemorph {
namespace {

/// Share of the diagonal of the box around everything: room for the soft rim of fog and for parts of shapes
/// that lie between the points surveyed.
constexpr double kFrameMargin = 0.02;

/// A grid that is active in a box of the world and nowhere else. Voxels are scaled so that the box is always
/// one tile, a lower node's 128^3 voxels.
openvdb::MaskGrid::Ptr boxGrid(const openvdb::BBoxd& box) {
  constexpr int kTile = 128;
  const auto grid = openvdb::MaskGrid::create();
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  matrix.preScale(box.extents() / double(kTile - 1));
  matrix.postTranslate(box.min());
  grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  grid->fill(openvdb::CoordBBox({0, 0, 0}, openvdb::Coord(kTile - 1)), true);
  return grid;
}

/// Pixels along the longest side of slices whose pixels' size nobody asked for: this many, or so many times the
/// voxels along any of the inputs, so that only inputs of very different sizes get coarser pixels than the finest
/// voxels.
constexpr double kUsualPixels = 1024, kPixelsPerVoxel = 4;

/// The size of pixels that --pixel-size leaves open: that of the finest voxels, unless these are dust in the whole.
double slicePixelOf(const FrameMaker& maker, double finest, const openvdb::BBoxd& all, Notes& notes) {
  double most = kUsualPixels;
  for (const LoadedObject& input : maker.inputs()) {
    const openvdb::CoordBBox box = input.object.levelSet->evalActiveVoxelBoundingBox();
    most = std::max(most, kPixelsPerVoxel * box.dim()[int(box.maxExtent())]);
  }
  const double least = all.extents()[int(all.maxExtent())] / most;
  if (finest >= least) return finest;
  notes.emplace_back("slices.coarser-pixels", Severity::kNote, "",
                     "slices get pixels of " + formatNumber(least, 4) + ", as at the finest voxels' " +
                         formatNumber(finest, 4) + " they would have more than " + formatNumber(most) +
                         " along a side (--pixel-size sets others)");
  return least;
}

/// The grids with unique names for channels.
std::vector<SliceGrid> namedGrids(const openvdb::GridCPtrVec& grids) {
  std::vector<SliceGrid> named;
  std::map<std::string, int> seen;
  for (const openvdb::GridBase::ConstPtr& grid : grids) {
    std::string name = grid->getName().empty() ? "value" : grid->getName();
    const int earlier = seen[name]++;
    if (earlier > 0) name += "[" + std::to_string(earlier) + "]";
    named.push_back({name, grid});
  }
  return named;
}

void writePictureOf(const FrameTask& task, const ImageSetup& setup, const MorphFrame& frame) {
  const std::string& path = task.job.path;
  RenderOptions options = task.settings.picture.render;
  options.channels = OutputName(path).extension() == ".exr";
  if (frame.density)
    return writePicture(path,
                        renderFog(fogOf(frame.density, frame.grids), setup.look, setup.camera, options));
  if (!frame.shape.surface)
    throw InputError("--grids names neither the surface nor the density: there is nothing to draw");
  writePicture(path, renderSurface(*frame.shape.surface, setup.camera, options, frame.colors.get()));
}

Notes writeSlicesOf(const FrameTask& task, const ImageSetup& setup, const MorphFrame& frame,
                    const Progress& cancel) {
  const MorphSettings& s = task.settings;
  const std::vector<SliceGrid> grids = namedGrids(frame.grids);
  SliceExrOptions exr = s.exrSlices.exr;
  exr.t = task.job.t;
  exr.frame = task.job.number;
  exr.framesPerSecond = s.framesPerSecond;
  if (s.allImages()) exr.units = "mm";
  OnlyCancel progress(cancel);
  Notes notes;
  if (!setup.planes.empty())
    writeSlicesExr(task.job.path, grids, setup.planes, exr, progress);
  else
    writeSlicesExr(task.job.path, grids, placeSlices(s.exrSlices, frame.grids, frame.shape.surface, notes),
                   exr, progress);
  return about("frame " + std::to_string(task.job.number), std::move(notes));
}

}  // namespace

ImageSetup setUpImages(const MorphSettings& s, const FrameMaker& maker, Progress& progress) {
  const FrameSurvey survey = surveyFrames(s, maker, progress);
  openvdb::BBoxd all = boxAround(survey.boxes);
  // Velocities are kept as far around the shapes as these move while a shutter is open.
  const double margin = kFrameMargin * all.extents().length() + kShutter * survey.fastest;
  all = openvdb::BBoxd(all.min() - Vec3d(margin), all.max() + Vec3d(margin));
  ImageSetup setup;
  if (s.exrContent == ExrContent::kSlices) {
    if (s.exrSlices.spine) return setup;
    SliceOptions slices = s.exrSlices;
    if (slices.section.pixelSize == 0)
      slices.section.pixelSize =
          s.plan.voxelSize > 0 ? s.plan.voxelSize : slicePixelOf(maker, survey.finest, all, setup.notes);
    setup.planes = placeSlices(slices, {boxGrid(all)}, nullptr, setup.notes);
    require(s.load.memory, s.output, needOfSlices(setup.planes, 1));
    return setup;
  }
  require(s.load.memory, s.output, needOfPicture(s.picture.render));
  std::vector<openvdb::BBoxd> boxes = survey.boxes;
  boxes.push_back(all);
  setup.camera = cameraFor(boxes, s.picture);
  setup.look = lookFor(survey.fogs, s.picture);
  if (!survey.fogs.empty() && s.picture.extinction == 0)
    setup.notes.emplace_back("render.extinction", Severity::kNote, "",
                             "extinction of the fog: " + formatNumber(setup.look.extinction, 4) +
                                 " per world unit (--extinction sets another)");
  return setup;
}

Notes writeFrameImage(const FrameTask& task, const ImageSetup& setup, const MorphFrame& frame,
                      const Progress& cancel) {
  if (task.settings.exrContent == ExrContent::kSlices) return writeSlicesOf(task, setup, frame, cancel);
  writePictureOf(task, setup, frame);
  return {};
}

}  // namespace slicemorph
