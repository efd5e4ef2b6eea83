#include "tools/job/frame_images.h"

#include "engine/render/render.h"
#include "engine/sections/object_boxes.h"
#include "engine/volume/fog.h"
#include "engine/volume/voxelise.h"
#include "io/vdb/fog_reader.h"
#include "slicemorph/errors.h"
#include "tools/job/frame_inputs.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <map>

namespace slicemorph {
namespace {

/// Points of each input's surface that are followed through the frames, at most.
constexpr size_t kMostPoints = 4000;
/// Of the largest box's diagonal: what shapes may reach beyond the places that are known, and their fog's
/// soft rim.
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

/// A grid that is active in a box of the world and nowhere else: one tile, whatever its size.
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

/// The active box of a grid in a file, world, by the file's statistics where it has some.
openvdb::BBoxd boxInFile(const VdbFile& file, size_t index, const openvdb::GridBase& header) {
  const auto low = header.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high = header.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  openvdb::CoordBBox box;
  if (low && high)
    box = {openvdb::Coord(low->value()), openvdb::Coord(high->value())};
  else
    box = file.readDelayed(index)->evalActiveVoxelBoundingBox();
  return box.empty() ? openvdb::BBoxd() : header.transform().indexToWorld(box);
}

/// Passes nothing on but that the job is to end.
class OnlyCancel : public Progress {
 public:
  explicit OnlyCancel(const Progress& of) : of_(of) {}
  bool cancelled() const override { return of_.cancelled(); }

 private:
  const Progress& of_;
};

/// Names for channels: one each.
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

}  // namespace

void FrameImages::prepare(const FrameMaker& maker, Progress& progress) {
  const auto isFog = [](const LoadedObject& input) { return input.fog; };
  const bool fog = settings_.method == Method::kDissolve ||
                   std::any_of(maker.inputs().begin(), maker.inputs().end(), isFog);
  std::vector<openvdb::BBoxd> reach;
  for (const LoadedObject& input : maker.inputs()) reach.push_back(survey(input, fog));
  // What is around a surface alone is not seen.
  if (!fog && settings_.exrContent != ExrContent::kSlices) reach.assign(reach.size(), openvdb::BBoxd());
  surveyBetween(maker, reach);
  if (settings_.moving()) {
    FrameInputs inputs(settings_);
    for (size_t i = 0; i < settings_.frames.size(); ++i) {
      progress.report("looking at all frames", double(i) / double(settings_.frames.size()));
      OnlyCancel quiet(cancel_);
      if (inputs.moveTo(settings_.frames[i].inputFrame, quiet))
        for (const LoadedObject& input : inputs.loaded()) survey(input, fog);
    }
  }
  openvdb::BBoxd all = boxAround(boxes_);
  // Velocities reach as far around the shapes as these get while a shutter is open.
  const double margin = kMargin * all.extents().length() + 0.5 * fastest_;
  all = openvdb::BBoxd(all.min() - Vec3d(margin), all.max() + Vec3d(margin));
  if (settings_.exrContent == ExrContent::kSlices) {
    if (settings_.exrSlices.spine) return;
    SliceOptions slices = settings_.exrSlices;
    if (slices.section.pixelSize == 0)
      slices.section.pixelSize = settings_.plan.voxelSize > 0 ? settings_.plan.voxelSize : finest_;
    planes_ = placeSlices(slices, {boxGrid(all)}, nullptr, notes_);
    return;
  }
  boxes_.push_back(all);
  camera_ = cameraFor(boxes_, settings_.picture);
  look_ = lookFor(fogs_, settings_.picture);
  if (!fogs_.empty() && !settings_.picture.extinctionGiven->count())
    notes_.push_back("extinction of the fog: " + formatNumber(look_.extinction, 4) +
                     " per world unit (--extinction sets another)");
}

/// Where an input is in the world, with all that is shown of it.
openvdb::BBoxd FrameImages::survey(const LoadedObject& input, bool asFog) {
  openvdb::BBoxd box = surfaceBox(*input.object.levelSet);
  if (settings_.exrContent == ExrContent::kSlices) {
    box.expand(surveyGrids(input));
  } else if (asFog) {
    Fog fog;
    if (input.fog) {
      openvdb::GridCPtrVec grids;
      for (size_t i = 0; i < input.file->entries().size(); ++i)
        if (i != input.grid && isDrawn(input.file->entries()[i].name)) grids.push_back(input.file->read(i));
      fog = fogOf(input.file->read(input.grid), grids);
    } else {
      fog.density = fogOf(*input.object.levelSet);
    }
    fogs_.push_back(measureFog(fog));
    if (!fogs_.back().box.empty()) box.expand(fogs_.back().box);
  }
  boxes_.push_back(box);
  return box;
}

/// Of the grids that ride along; takes note of the finest.
openvdb::BBoxd FrameImages::surveyGrids(const LoadedObject& input) {
  openvdb::BBoxd box;
  const auto finer = [&](double size) { finest_ = finest_ > 0 ? std::min(finest_, size) : size; };
  if (input.image) {
    box = boxOf(input.image->lattice);
    const Vec3d spacing = input.image->lattice.spacing();
    finer(std::min({spacing[0], spacing[1], spacing[2]}));
  }
  if (!input.image && !input.fog) finer(input.object.levelSet->voxelSize()[0]);
  if (!input.file || settings_.method == Method::kSdf || settings_.method == Method::kLevelSet) return box;
  for (size_t i = 0; i < input.file->entries().size(); ++i) {
    const openvdb::GridBase::Ptr header = input.file->readHeader(i);
    if (!header || !isSliceable(*header)) continue;
    const std::vector<std::string>& wanted = settings_.grids;
    if (!wanted.empty() && std::count(wanted.begin(), wanted.end(), header->getName()) == 0) continue;
    const openvdb::BBoxd own = boxInFile(*input.file, i, *header);
    if (own.empty()) continue;
    box.expand(own);
    const Vec3d size = header->voxelSize();
    finer(std::min({size[0], size[1], size[2]}));
  }
  return box;
}

/// Where the map takes the inputs' surfaces, and the corners of what is around them.
void FrameImages::surveyBetween(const FrameMaker& maker, const std::vector<openvdb::BBoxd>& reach) {
  const MorphPlan* plan = maker.slicePlan();
  if (!plan) return;
  const std::vector<LoadedObject>& inputs = maker.inputs();
  for (size_t k = 0; k < inputs.size(); ++k) {
    std::vector<Vec3d> points = somePoints(*inputs[k].object.levelSet), before;
    if (!reach[k].empty()) addCorners(reach[k], points);
    for (const FrameJob& job : settings_.frames) {
      if (job.weights[k] == 0 && settings_.plan.regions.empty()) continue;
      const std::vector<Vec3d> there = plan->carryPoints(points, k, job.weights);
      openvdb::BBoxd box;
      for (const Vec3d& p : there) box.expand(p);
      boxes_.push_back(box);
      for (size_t i = 0; i < before.size(); ++i)
        fastest_ = std::max(fastest_, (there[i] - before[i]).length());
      before = there;
    }
  }
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
  writePicture(job.path, renderSurface(*frame.shape.surface, camera_, options, frame.colors.get()));
}

void FrameImages::writeSlicesOf(const FrameJob& job, const MorphFrame& frame) {
  const std::vector<SliceGrid> grids = namedGrids(frame.grids);
  SliceExrOptions exr = settings_.exrSlices.exr;
  exr.t = job.t;
  exr.frame = job.number;
  exr.framesPerSecond = settings_.framesPerSecond;
  if (std::all_of(settings_.inputs.begin(), settings_.inputs.end(), isImageInput)) exr.units = "mm";
  OnlyCancel progress(cancel_);
  if (!planes_.empty()) return writeSlicesExr(job.path, grids, planes_, exr, progress);
  Notes notes;
  writeSlicesExr(job.path, grids, placeSlices(settings_.exrSlices, frame.grids, frame.shape.surface, notes),
                 exr, progress);
  for (Note& note : about("frame " + std::to_string(job.number), std::move(notes)))
    notes_.push_back(std::move(note));
}

}  // namespace slicemorph
