#include "tools/job/apply_map.h"

#include "engine/numerics/readable.h"
#include "engine/volume/image_grid.h"
#include "engine/volume/resample_image.h"
#include "io/image/image_formats.h"
#include "io/paths.h"
#include "io/points/position_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/formats.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/job/image_lattice.h"
#include "tools/job/key_times.h"
#include "tools/job/load_settings.h"
#include "tools/job/memory_need.h"
#include "tools/job/one_world.h"
#include "tools/job/option_values.h"
#include "tools/job/plan_file.h"
#include "tools/job/plan_settings.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

namespace slicemorph {
namespace {

/// Voxels along the longest side of a field where nothing else says how many: the map's own lattice has 30 to 50.
constexpr int kFieldVoxels = 96;
/// Of a field: 6 GB. The map's own lattice has a million nodes at most, so finer ones tell nothing more.
constexpr double kMostFieldVoxels = 5e8;
/// The map is defined, and a field drawn, this share of the objects' diagonal around them; farther points are told.
constexpr double kAround = 0.1;

bool isPositions(const std::string& path) {
  const std::vector<std::string>& known = positionExtensions();
  return std::find(known.begin(), known.end(), extensionOf(path)) != known.end();
}

/// Throws where the output does not fit what is carried.
void checkApplyOutput(const ApplyJob& job, const OptionSet& options) {
  if (OutputName(job.output).isSequence())
    options.refuse("output", "-o " + job.output + ": apply writes one file; leave out the ####");
  const bool image = isImageOutput(job.output);
  if (job.field()) {
    if (!image && !isGridOutput(job.output))
      options.refuse("output", "-o " + job.output + ": a field is written as " +
                                   writableList(Contents::kImage) + " " + writableList(Contents::kGrids));
  } else if (isImageInput(job.what)) {
    if (!image)
      options.refuse("output",
                     "-o " + job.output + ": an image is written as " + writableList(Contents::kImage));
  } else if (!isPositions(job.what)) {
    options.refuse("inputs", job.what + ": cannot carry a file with the extension '" + extensionOf(job.what) +
                                 "'; use points, meshes, curves: " + positionList() +
                                 "; or an image: " + readableList(Contents::kImage));
  } else if (extensionOf(job.output) != extensionOf(job.what)) {
    options.refuse("output", "-o " + job.output + ": the result is a copy of " + job.what +
                                 " with other positions; give it the extension " + extensionOf(job.what));
  }
  checkOutputPath(job.output);
}

/// The map from one time to another and the objects it is of.
class TimeMap {
 public:
  TimeMap(const ApplyJob& job, JobEvents& events) {
    for (size_t k = 0; k < job.inputs.size(); ++k) {
      events.throwIfCancelled();
      events.report("reading", 0.2 * double(k) / double(job.inputs.size()));
      inputs_.push_back(loadObject(job.inputs[k], optionsOfInput(job.load, k)));
      events.notes(about(job.inputs[k], inputs_.back().notes));
    }
    addLabelSurfaces(inputs_);
    std::vector<Object> objects;
    for (const LoadedObject& input : inputs_) objects.push_back(input.object);
    PartProgress part(events, 0.2, 0.8);
    require(job.load.memory, "", needOfMorph(inputs_));
    const PlanOptions found =
        job.alignGiven ? PlanOptions{job.plan, {}} : optionsInOneWorld(job.plan, inputs_, job.inputs);
    events.notes(found.notes);
    plan_ = std::make_unique<MorphPlan>(planOf(job, objects, found.options, part));
    events.notes(plan_->notes());
    const WeightCourse course = courseOf(evenKeys(job.inputs.size()), Timing::kLinear, {});
    from_ = weightsAt(course, job.from), to_ = weightsAt(course, job.to);
    for (const LoadedObject& input : inputs_) {
      const FloatGrid& grid = *input.object.levelSet;
      box_.expand(grid.transform().indexToWorld(grid.evalActiveVoxelBoundingBox()));
    }
    const Vec3d margin(kAround * box_.extents().length());
    box_ = openvdb::BBoxd(box_.min() - margin, box_.max() + margin);
  }

  std::vector<Vec3d> carried(const std::vector<Vec3d>& points) const {
    return plan_->carryPoints(points, from_, to_);
  }
  /// From the time `to` to the time `from`.
  std::vector<Vec3d> carriedBack(const std::vector<Vec3d>& points) const {
    return plan_->carryPoints(points, to_, from_);
  }
  /// Around all objects, world.
  const openvdb::BBoxd& box() const { return box_; }
  /// The object that is at a time, where it has an image; null: none is.
  const LoadedObject* objectFrom() const { return objectAt(from_); }
  const LoadedObject* objectTo() const { return objectAt(to_); }

 private:
  static MorphPlan planOf(const ApplyJob& job, const std::vector<Object>& objects,
                          const MorphOptions& options, Progress& progress) {
    if (job.planFile.empty()) return MorphPlan(objects, options, &progress);
    try {
      return MorphPlan::decidedBefore(objects, options, readPlanFile(job.planFile).decisions, &progress);
    } catch (const InputError& error) {
      throw IoError(job.planFile, error.what());
    }
  }

  const LoadedObject* objectAt(const Weights& weights) const {
    const std::optional<size_t> alone = aloneIn(weights);
    return alone && inputs_[*alone].image ? &inputs_[*alone] : nullptr;
  }

  std::vector<LoadedObject> inputs_;
  std::unique_ptr<MorphPlan> plan_;
  Weights from_, to_;
  openvdb::BBoxd box_;
};

std::vector<Vec3d> voxelsOf(const ImageLattice& lattice, const SliceRange& slices) {
  std::vector<Vec3d> points;
  points.reserve(size_t(lattice.size[0]) * size_t(lattice.size[1]) * size_t(slices.to - slices.from));
  for (int k = slices.from; k < slices.to; ++k)
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0]; ++i) points.push_back(lattice.toWorld(Vec3d(i, j, k)));
  return points;
}

void reportSlices(JobEvents& events, const SliceRange& slices, const ImageLattice& of) {
  events.throwIfCancelled();
  events.report("carrying", 0.8 + 0.2 * double(slices.from) / double(of.size[2]));
}

void carryPositions(const ApplyJob& job, const PositionFile& file, const TimeMap& map, JobEvents& events) {
  const std::vector<Vec3d>& points = file.positions();
  const auto outside =
      std::count_if(points.begin(), points.end(), [&](const Vec3d& p) { return !map.box().isInside(p); });
  if (outside > 0)
    events.note({"apply.far-away", Severity::kWarning, job.what,
                 readableCount(double(outside)) + " of " + readableCount(double(points.size())) +
                     " points are far from the objects, where the map is only continued; are they in the "
                     "objects' coordinates and units?"});
  if (file.hasNormals())
    events.note({"apply.normals-kept", Severity::kNote, job.what,
                 "its normals are kept as they are; compute them anew where they are needed"});
  file.write(job.output, map.carried(points));
}

void carryImage(const ApplyJob& job, const TimeMap& map, JobEvents& events) {
  ImageFile file = readImage(job.what, job.load.image);
  takeLabels(file, job.load.imageKind);
  events.notes(about(job.what, file.notes));
  const bool stated = job.load.imageKind == ImageKind::kAuto && isStatedLabels(file);
  const bool labels = stated || isLabelMap(file.image, job.load.imageKind);
  ImageHeader header = file.header;
  ImageLattice on = file.image.lattice;
  // Codes of space belong to voxels, all else of a header to the values.
  if (!job.like.empty()) {
    const ImageVoxels like = voxelsLike(job.like, job.load.image);
    on = like.lattice, header.forms = like.forms;
  } else if (const LoadedObject* to = map.objectTo()) {
    on = to->image->lattice, header.forms = to->imageHeader.forms;
  }
  require(job.load.memory, job.output, needOfImage(on, 1));
  const auto positions = [&](const SliceRange& slices) {
    reportSlices(events, slices, on);
    return map.carriedBack(voxelsOf(on, slices));
  };
  writeImage(job.output, sampledAt(file.image, on, positions, labels), header);
}

ImageLattice latticeOver(const openvdb::BBoxd& box, double voxelSize) {
  const Vec3d extents = box.extents();
  const double edge =
      voxelSize > 0 ? voxelSize : std::max({extents[0], extents[1], extents[2]}) / kFieldVoxels;
  double voxels = 1;
  for (int d = 0; d < 3; ++d) voxels *= std::ceil(extents[d] / edge) + 1;
  if (voxels > kMostFieldVoxels)
    throw InputError("--voxel-size " + formatNumber(voxelSize) + ": a field of " + readableCount(voxels) +
                     " voxels; it is dense: choose a larger one, or --like an image");
  ImageLattice lattice;
  lattice.origin = box.min();
  for (int d = 0; d < 3; ++d) {
    lattice.size[d] = int(std::ceil(extents[d] / edge)) + 1;
    lattice.step[d] = Vec3d(0.0), lattice.step[d][d] = edge;
  }
  return lattice;
}

void writeFieldGrid(const std::string& path, const VectorImage& field) {
  const openvdb::Vec3SGrid::Ptr grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.f));
  const ImageLattice& on = field.lattice;
  openvdb::Vec3SGrid::Accessor accessor = grid->getAccessor();
  for (int k = 0; k < on.size[2]; ++k)
    for (int j = 0; j < on.size[1]; ++j)
      for (int i = 0; i < on.size[0]; ++i)
        accessor.setValue(openvdb::Coord(i, j, k), field.vectors[on.index(i, j, k)]);
  grid->setTransform(transformOf(on));
  grid->setName("displacement");
  grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  grid->insertMeta("meaning", openvdb::StringMetadata(field.meaning));
  writeGridFile(path, {grid}, {});
}

void writeField(const ApplyJob& job, const TimeMap& map, JobEvents& events) {
  VectorImage field;
  field.lattice = !job.like.empty()  ? voxelsLike(job.like, job.load.image).lattice
                  : map.objectFrom() ? map.objectFrom()->image->lattice
                                     : latticeOver(map.box(), job.load.voxelSize);
  const bool vdb = !isImageOutput(job.output);
  field.meaning = "displacement from t=" + formatNumber(job.from) + " to t=" + formatNumber(job.to) +
                  (vdb ? ", world units" : ", LPS mm");
  const ImageLattice& on = field.lattice;
  require(job.load.memory, job.output, needOfImage(on, sizeof(openvdb::Vec3s)));
  field.vectors.reserve(on.count());
  for (const SliceRange& slices : sliceRanges(on)) {
    reportSlices(events, slices, on);
    const std::vector<Vec3d> points = voxelsOf(on, slices), there = map.carried(points);
    for (size_t i = 0; i < points.size(); ++i) field.vectors.emplace_back(there[i] - points[i]);
  }
  vdb ? writeFieldGrid(job.output, field) : writeVectors(job.output, field);
  events.note({"apply.field-meaning", Severity::kNote, job.output,
               "holds, at points of t = " + formatNumber(job.from) +
                   ", the displacement to where they are at t = " + formatNumber(job.to) +
                   (vdb ? ", in world units" : ", in millimetres along LPS (as ITK, also in NIfTI)") +
                   "; to draw an image of t = " + formatNumber(job.from) + " as it is at t = " +
                   formatNumber(job.to) + ", resampling programs want the other one, --from " +
                   formatNumber(job.to) + " --to " + formatNumber(job.from)});
}

}  // namespace

ApplyJob applyJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  ApplyJob job;
  job.inputs = given.inputs, job.output = given.output, job.like = given.like;
  job.from = given.fromTime, job.to = given.toTime;
  job.planFile = given.planFile;
  const size_t least = given.field ? 2 : 3;
  if (job.inputs.size() < least)
    options.refuse("inputs", given.field
                                 ? "apply --field needs two objects or more"
                                 : "apply needs two objects or more and, last, what is to be carried");
  if (!given.field) job.what = job.inputs.back(), job.inputs.pop_back();
  for (const std::string& input : job.inputs) {
    if (parseInput(input).placing.given())
      options.refuse("inputs",
                     input +
                         ": apply carries what is in the objects' own coordinates, which braces would "
                         "change; leave them out");
    if (isMovingInput(input))
      options.refuse("inputs",
                     input + " is a sequence; apply takes still objects, one of its files for example");
    checkInputExists(input);
  }
  if (!job.field() && !isImageInput(job.what)) {
    const InputSpec what = parseInput(job.what);
    if (what.placing.given())
      options.refuse("inputs", job.what +
                                   ": the result is a copy with other positions, which braces cannot "
                                   "place; leave them out");
    if (what.isSequence)
      options.refuse("inputs", job.what + " is a sequence; apply carries one file at a time");
  }
  if (!job.field()) checkInputExists(job.what);
  if (!job.like.empty()) checkInputExists(job.like);
  checkApplyOutput(job, options);
  job.load = loadSettings(options);
  job.load.matching = true;
  checkIsos(job.load, options, job.inputs.size());
  // Plans are made of fog as it is.
  if (job.planFile.empty() && std::none_of(job.inputs.begin(), job.inputs.end(), isImageInput))
    job.load.fogResolution = kFogResolution;
  job.alignGiven = options.given("align");
  job.plan = planSettings(options, std::all_of(job.inputs.begin(), job.inputs.end(), isImageInput));
  job.plan.features = featuresOf(landmarksOf(options, "landmarks", given.landmarks, job.inputs.size()));
  return job;
}

void applyMap(const ApplyJob& job, JobEvents& events) {
  // Read before the long work, so that what is wrong with it is told at once.
  std::unique_ptr<PositionFile> positions;
  if (!job.field() && isPositions(job.what)) positions = std::make_unique<PositionFile>(job.what);
  const TimeMap map(job, events);
  events.throwIfCancelled();
  if (job.field())
    writeField(job, map, events);
  else if (positions)
    carryPositions(job, *positions, map, events);
  else
    carryImage(job, map, events);
  events.fileWritten(job.output, false);
}

}  // namespace slicemorph
