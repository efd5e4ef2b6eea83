#include "tools/job/frame_maker.h"

#include "engine/peers/peers.h"
#include "engine/rebuild/add_vectors.h"
#include "engine/volume/fog.h"
#include "engine/volume/image_grid.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/surface_colors.h"
#include "io/vdb/fog_reader.h"
#include "io/vdb/grid_choice.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/image_lattice.h"
#include "tools/job/option_values.h"
#include "tools/job/stopwatch.h"
#include "tools/report/dump_slices.h"

#include <algorithm>
#include <limits>
#include <set>

namespace slicemorph {
namespace {

using openvdb::GridBase;

/// Frames that a shutter is open before or after its frame, at most.
constexpr double kShutter = 0.5;

/// Names that hosts give to velocities.
const std::set<std::string> kVelocityNames{"vel", "v", "velocity"};

void append(Notes& to, const Notes& notes) { to.insert(to.end(), notes.begin(), notes.end()); }

}  // namespace

FrameMaker::FrameMaker(const MorphSettings& settings, TerminalProgress& progress)
    : settings_(settings), progress_(progress), inputs_(settings) {
  append(notes_, inputs_.notes(settings.frames.back().inputFrame + 1));
}

FrameMaker::~FrameMaker() = default;

void FrameMaker::moveTo(size_t index, double from, double to) {
  const bool first = !makeShape_;
  index_ = index;
  Stopwatch watch;
  PartProgress reading(progress_, from, from + 0.4 * (to - from)),
      planning(progress_, from + 0.4 * (to - from), to);
  const bool changed = inputs_.moveTo(job().inputFrame, reading);
  // Of a sequence the first files stand for the others.
  const Notes inputNotes = inputs_.takeNotes();
  if (first) append(notes_, inputNotes);
  loadSeconds_ += watch.lap();
  if (!changed) return;
  if (progress_.cancelled()) throw Cancelled();
  chooseGrids(first);
  prepareImages();
  planning.report("planning", 0);
  plan(planning);
  planSeconds_ += watch.lap();
}

void FrameMaker::plan(Progress& progress) {
  switch (settings_.method) {
    case Method::kSlices:
      return planSlices(progress);
    case Method::kSdf:
      return planSdf();
    case Method::kLevelSet:
      return planLevelSet(progress);
    case Method::kDissolve:
      makeShape_ = [] { return InBetween(); };
  }
}

void FrameMaker::planSlices(Progress& progress) {
  std::vector<Object> objects;
  for (const LoadedObject& input : inputs()) objects.push_back(input.object);
  if (plan_) {
    auto next = std::make_unique<MorphPlan>(objects, *plan_, &progress);
    plan_ = std::move(next);
    for (const Note& note : plan_->notes())
      if (note.code == "sequence.planned-anew")
        append(notes_, about("frame " + std::to_string(job().number), {note}));
  } else {
    plan_ = std::make_unique<MorphPlan>(objects, settings_.plan, &progress);
    if (!settings_.sliceFolder.empty())
      dumpSlices(settings_.sliceFolder, plan_->slicePictures(), settings_.inputs);
    append(notes_, plan_->notes());
  }
  makeShape_ = [this] { return plan_->frame(job().weights); };
}

void FrameMaker::planSdf() {
  std::vector<FloatGrid::ConstPtr> grids;
  double finest = std::numeric_limits<double>::max();
  for (const LoadedObject& input : inputs()) {
    grids.push_back(input.object.levelSet);
    finest = std::min(finest, grids.back()->voxelSize()[0]);
  }
  const auto blend =
      std::make_shared<SdfBlend>(grids, settings_.plan.voxelSize > 0 ? settings_.plan.voxelSize : finest);
  makeShape_ = [this, blend] { return InBetween{blend->frame(job().weights), 0}; };
}

void FrameMaker::planLevelSet(Progress& progress) {
  const auto result = std::make_shared<LevelSetMorphResult>(
      levelSetMorph(*inputs()[0].object.levelSet, *inputs()[1].object.levelSet, int(settings_.frames.size()),
                    2000, &progress));
  notes_.push_back("the level set came to rest after " + std::to_string(result->steps) + " steps, at most " +
                   formatNumber(result->restDistance, 3) + " voxels from " + settings_.inputs[1]);
  restDistance_ = result->restDistance;
  makeShape_ = [this, result] { return InBetween{result->frames[index_], 0}; };
}

/// What the output holds: the surface, or the fog that the shapes are part of, and all grids that ride along.
void FrameMaker::chooseGrids(bool first) {
  const bool holdsGrids = settings_.holdsGrids();
  const bool carries = settings_.method == Method::kSlices || settings_.method == Method::kDissolve;
  const bool anyFog =
      std::any_of(inputs().begin(), inputs().end(), [](const LoadedObject& input) { return input.fog; });
  images_ = std::all_of(inputs().begin(), inputs().end(),
                        [](const LoadedObject& input) { return bool(input.image); }) &&
            carries;
  fog_ = holdsGrids && carries && (anyFog || settings_.method == Method::kDissolve);
  surfaceWanted_ = !fog_;
  sets_.clear();
  shapeSet_.reset();
  colorName_.clear();
  if (images_) {
    const std::string name = inputs()[0].labels ? "labels" : "image";
    const auto asked = [&](const std::string& grid) {
      return settings_.grids.empty() || std::count(settings_.grids.begin(), settings_.grids.end(), grid) > 0;
    };
    for (const std::string& grid : settings_.grids)
      if (grid != "surface" && grid != name)
        throw InputError("--grids: there is no grid '" + grid + "'; there are surface, " + name);
    surfaceWanted_ = asked("surface") && settings_.method != Method::kDissolve;
    if (!surfaceWanted_ && !asked(name))
      throw InputError("--grids surface: --method dissolve makes no surface");
    images_ = !holdsGrids || asked(name);
    return;
  }
  const bool anyColors = std::any_of(inputs().begin(), inputs().end(),
                                     [](const LoadedObject& input) { return bool(input.colors); });
  if (first && anyColors && settings_.method != Method::kSlices)
    notes_.push_back("the inputs' colours are left out: only --method slices carries them");
  if (!carries) return;
  GridSets found = pairGrids(inputs(), settings_.grids.empty());
  chooseColors(found);
  if (!holdsGrids) return;
  if (first) append(notes_, found.notes);
  // The grids that the shapes are made of are no riders.
  GridSet shape = shapeSet(inputs());
  if (shape.name.empty()) shape.name = "density";
  std::optional<size_t> place;
  for (size_t s = 0; s < found.sets.size(); ++s)
    for (size_t k = 0; k < inputs().size(); ++k)
      if (inputs()[k].file && found.sets[s].index[k] == inputs()[k].grid) {
        found.sets[s].index[k].reset();
        if (inputs()[k].fog && !place) place = s;
      }
  for (size_t s = 0; s < found.sets.size(); ++s) {
    if (fog_ && place == s) shapeSet_ = sets_.size(), sets_.push_back(shape);
    const auto& index = found.sets[s].index;
    const bool there = std::any_of(index.begin(), index.end(), [](const auto& i) { return i.has_value(); });
    if (there && (!settings_.toPictures() || isDrawn(found.sets[s].name))) sets_.push_back(found.sets[s]);
  }
  if (fog_ && !shapeSet_) shapeSet_ = 0, sets_.insert(sets_.begin(), shape);
  if (!settings_.grids.empty()) keepAsked(settings_.grids, first);
}

/// Colours of surfaces go along with them, not as grids of their own. Without a map there is nothing to go
/// along with.
void FrameMaker::chooseColors(GridSets& found) {
  if (fog_ || settings_.method != Method::kSlices) return;  // colours of fog are grids like others
  for (const LoadedObject& input : inputs())
    if (input.colors) colorName_ = "Cd";
  bool named = false;
  for (GridSet& set : found.sets) {
    if (!isColorName(set.name)) continue;
    for (size_t k = 0; k < inputs().size(); ++k) {
      if (!inputs()[k].colors || !set.index[k] || set.index[k] != findColors(*inputs()[k].file)) continue;
      set.index[k].reset();
      if (!named) colorName_ = set.name, named = true;
    }
  }
}

/// Grids that are asked for must be there in the first frame; in others of a sequence they may come and go.
void FrameMaker::keepAsked(const std::vector<std::string>& asked, bool first) {
  std::string known = "surface";
  if (!colorName_.empty()) known += ", " + colorName_;
  for (const GridSet& set : sets_) known += ", " + set.name;
  std::vector<GridSet> kept;
  std::optional<size_t> shapeSet;
  for (size_t s = 0; s < sets_.size(); ++s) {
    if (std::find(asked.begin(), asked.end(), sets_[s].name) == asked.end()) continue;
    if (shapeSet_ == s) shapeSet = kept.size();
    kept.push_back(sets_[s]);
  }
  for (const std::string& name : asked) {
    const bool there =
        std::any_of(kept.begin(), kept.end(), [&](const GridSet& set) { return set.name == name; });
    if (first && !there && name != "surface" && name != colorName_)
      throw InputError("--grids: no input has a grid '" + name + "'; there are " + known);
  }
  surfaceWanted_ = std::find(asked.begin(), asked.end(), "surface") != asked.end();
  if (std::find(asked.begin(), asked.end(), colorName_) == asked.end()) colorName_.clear();
  if (surfaceWanted_ && settings_.method == Method::kDissolve)
    throw InputError("--grids surface: --method dissolve makes no surface");
  sets_ = std::move(kept);
  shapeSet_ = shapeSet;
}

InBetween FrameMaker::shape() const { return makeShape_(); }

/// What in-between images need of the inputs.
void FrameMaker::prepareImages() {
  images_ = images_ && !settings_.toPictures() && (isImageOutput(settings_.output) || settings_.holdsGrids());
  if (!images_) return;
  const bool labels = inputs()[0].labels;
  for (size_t k = 1; k < inputs().size(); ++k)
    if (inputs()[k].labels != labels)
      throw InputError(settings_.inputs[labels ? 0 : k] + " is a map of labels and " +
                       settings_.inputs[labels ? k : 0] +
                       " holds grey values; --image grey or labels reads both alike");
  labelFields_.clear();
  if (labels)
    for (const LoadedObject& input : inputs()) labelFields_.emplace_back(*input.image);
  if (!settings_.like.empty())
    lattice_ = readImage(settings_.like, settings_.load.image).image.lattice;
  else
    lattice_ = latticeAround(inputs(), notes_);
  if (settings_.plan.voxelSize > 0 || settings_.load.resolution > 0)
    lattice_ = cubicLattice(lattice_, settings_.load);
}

double FrameMaker::iso() const {
  double iso = 0;
  const Weights weights = withoutNegatives(job().weights);
  for (size_t k = 0; k < inputs().size(); ++k) iso += weights[k] * inputs()[k].iso;
  return iso;
}

Image FrameMaker::image() const {
  const Pullback pullback = this->pullback();
  if (!inputs()[0].labels) {
    std::vector<const Image*> images;
    std::vector<double> isos;
    for (const LoadedObject& input : inputs()) images.push_back(input.image.get()), isos.push_back(input.iso);
    return pullback.carry(images, lattice_, isos);
  }
  // The inputs themselves are not made anew.
  if (const std::optional<size_t> alone = aloneIn(job().weights))
    return nearestTo(*inputs()[*alone].image, lattice_);
  std::vector<const LabelField*> fields;
  for (const LabelField& field : labelFields_) fields.push_back(&field);
  return pullback.carryLabels(fields, lattice_);
}

MorphFrame FrameMaker::coloredShape() const {
  MorphFrame frame;
  frame.shape = makeShape_();
  if (!frame.shape.surface || colorName_.empty()) return frame;
  Pullback pullback = this->pullback();
  std::vector<openvdb::Vec3SGrid::ConstPtr> own;
  for (const LoadedObject& input : inputs()) own.push_back(input.colors);
  const openvdb::Vec3SGrid::Ptr colors = pullback.colors(*frame.shape.surface, own);
  colors->setName(colorName_);
  frame.colors = colors;
  return frame;
}

MorphFrame FrameMaker::make() const {
  MorphFrame frame;
  const bool carries = shapeSet_ || !sets_.empty() || settings_.velocity.wanted();
  const bool toImage = isImageOutput(settings_.output);
  const bool leaning = settings_.toFrameImages() && settings_.exrSlices.spine;
  const bool colored = settings_.holdsGrids() && !colorName_.empty();
  if ((surfaceWanted_ && !toImage) || leaning || colored || !settings_.reports.empty())
    frame = coloredShape();
  if (images_) frame.image = image();
  if (!settings_.holdsGrids()) return frame;
  bool half = true;
  for (const LoadedObject& input : inputs()) half = half && input.halfFloat;
  if (surfaceWanted_) {
    SurfaceOutput options;
    options.halfFloat = half;
    options.vdb.framesPerSecond = settings_.framesPerSecond;
    options.vdb.frame = job().number;
    frame.grids.push_back(surfaceGrid(*frame.shape.surface, options));
  }
  if (frame.colors) frame.grids.push_back(frame.colors);
  if (frame.image) {
    const bool labels = inputs()[0].labels;
    frame.grids.push_back(gridOf(*frame.image, labels ? "labels" : "image", labels));
    frame.image.reset();
  }
  if (!carries || settings_.method == Method::kSdf || settings_.method == Method::kLevelSet) return frame;
  Pullback pullback = this->pullback();
  GridBase::ConstPtr where = surfaceWanted_ ? frame.grids[0] : nullptr;
  for (size_t s = 0; s < sets_.size(); ++s) {
    if (progress_.cancelled()) throw Cancelled();
    const GridBase::ConstPtr grid = shapeSet_ == s
                                        ? density(pullback)
                                        : pullback.carry(readGrids(sets_[s], inputs()), {false, voxelSize()});
    if (shapeSet_ == s || !where) where = grid;
    if (shapeSet_ == s) frame.density = grid;
    frame.grids.push_back(grid);
  }
  if (settings_.velocity.wanted() && !job().rate.empty() && where)
    if (const GridBase::Ptr velocity = this->velocity(pullback, *where, frame.grids)) {
      const auto replaced = std::remove_if(frame.grids.begin(), frame.grids.end(), [&](const auto& grid) {
        return grid->getName() == velocity->getName();
      });
      frame.grids.erase(replaced, frame.grids.end());
      velocity->setSaveFloatAsHalf(half);
      frame.grids.push_back(velocity);
    }
  return frame;
}

Pullback FrameMaker::pullback() const {
  return settings_.method == Method::kDissolve ? dissolve(job().weights) : plan_->pullback(job().weights);
}

/// The voxel size that was asked for, world units; 0 where the grids keep their own.
double FrameMaker::voxelSize() const {
  if (settings_.plan.voxelSize > 0) return settings_.plan.voxelSize;
  if (settings_.load.resolution == 0) return 0;
  double size = 0;
  const Weights weights = withoutNegatives(job().weights);
  for (size_t k = 0; k < inputs().size(); ++k)
    size += weights[k] * inputs()[k].object.levelSet->voxelSize()[0];
  return size;
}

/// The fog that the shapes are part of; of solids that with a soft rim.
GridBase::ConstPtr FrameMaker::density(Pullback& pullback) const {
  std::vector<GridBase::ConstPtr> grids = readGrids(sets_[*shapeSet_], inputs());
  GridBase::ConstPtr like;
  for (const auto& grid : grids)
    if (grid && !like) like = grid;
  for (size_t k = 0; k < grids.size(); ++k) {
    if (!grids[k]) {
      const FloatGrid::Ptr fog = fogOf(*inputs()[k].object.levelSet);
      fog->setName(sets_[*shapeSet_].name);
      fog->setSaveFloatAsHalf(!like || like->saveFloatAsHalf());
      grids[k] = fog;
    }
    if (like && grids[k]->type() != like->type())
      grids[k] = asFloatGrid(openvdb::ConstPtrCast<GridBase>(grids[k]));
  }
  return pullback.carry(grids, {settings_.conserve, voxelSize()});
}

/// Null where the inputs' own velocities stand under its name.
GridBase::Ptr FrameMaker::velocity(const Pullback& pullback, const GridBase& where,
                                   const openvdb::GridCPtrVec& grids) const {
  const VelocitySettings& v = settings_.velocity;
  const openvdb::Vec3SGrid::Ptr velocity =
      pullback.velocity(where, job().rate, kShutter / settings_.framesPerSecond);
  velocity->setName(v.name);
  for (const GridBase::ConstPtr& grid : grids) {
    const bool isOwn = kVelocityNames.count(grid->getName()) || grid->getName() == v.name;
    if (v.add && isOwn) {
      addVectors(*velocity, *grid, 1);
      break;
    }
    if (grid->getName() == v.name) velocity->setName(v.name + "_morph");
  }
  const double unit = v.perFrame ? 1 / settings_.framesPerSecond : 1;
  if (unit != 1)
    for (auto value = velocity->beginValueOn(); value; ++value) value.setValue(*value * float(unit));
  velocity->insertMeta("velocity_unit", openvdb::StringMetadata(v.perFrame ? "frame" : "second"));
  velocity->insertMeta("fps", openvdb::FloatMetadata(float(settings_.framesPerSecond)));
  return velocity;
}

VdbOutput FrameMaker::fileOptions() const {
  VdbOutput options;
  for (const LoadedObject& input : inputs())
    if (input.file) {
      options.metadata = input.file->metadata();
      options.compression = input.file->compression();
      break;
    }
  return options;
}

Notes FrameMaker::takeNotes() { return std::exchange(notes_, {}); }

}  // namespace slicemorph
