#include "slicemorph/slicemorph.h"

#include "engine/blend/moving_lattice.h"
#include "engine/frame/track.h"
#include "engine/frame/typical_order.h"
#include "engine/match/choose_frames.h"
#include "engine/match/features.h"
#include "engine/match/register.h"
#include "engine/mean/match_through_mean.h"
#include "engine/rebuild/pullback.h"
#include "engine/rebuild/rebuild.h"
#include "engine/rebuild/small_components.h"
#include "engine/volume/same_grid.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

/// The whole pipeline on one screen: a plan (volume -> frames -> slices -> contours -> match), then one frame
/// after another (blend -> rebuild).
namespace slicemorph {

struct MorphPlan::Impl {
  MorphOptions options;
  std::vector<size_t> shapeOf;                 ///< the distinct shape of each object; equal objects share one
  std::vector<FloatGrid::ConstPtr> levelSets;  ///< per distinct shape, as all below
  Fields fields;
  std::vector<Fields> inner;  ///< further surfaces, each per distinct shape; null where one has none
  Frames frames;
  Registration registration;
  std::unique_ptr<MovingLattice> lattice;
  std::vector<int> pieces;         ///< of each shape
  std::vector<size_t> order;       ///< of the distinct shapes: their numbers in the objects' order
  std::vector<std::string> names;  ///< of each shape
  std::vector<Feature> features;   ///< the options', of the shapes
  std::vector<Region> regions;     ///< the options', of the shapes
  std::vector<Chart> drawn;        ///< the charts of the first frame, on which regions are drawn

  void measure(const std::vector<Object>& objects, const Impl* before, Progress& progress);
  void measureInner(const std::vector<Object>& objects);
  void reorder(const std::vector<size_t>& by);
  void takeGuidance(const std::vector<Object>& objects);
  void decide(Progress& progress);
  bool follow(const Impl& before, Progress& progress);
  void move(bool following);

  Weights shapeWeights(const Weights& weights) const;
  std::optional<size_t> aloneAt(const Weights& shapeWeights) const;
  double frameVoxelSize(const Weights& weights) const;
  int piecesOf(const Weights& weights) const;
};

namespace {

/// Nodes that carry images lie this share of the matching's lattice apart; without one that many on the
/// object's diagonal.
constexpr double kImageShare = 0.75, kImageNodes = 64;

void check(const Feature& feature, size_t objects) {
  const bool disk = feature.kind == Feature::Kind::kDisk;
  const auto count = [&](const char* what, size_t given) {
    if (given != objects)
      throw InputError("feature '" + feature.name + "' has " + what + " for " + std::to_string(given) +
                       " objects; there are " + std::to_string(objects));
  };
  count("places", feature.places.size());
  if (disk) count("normals", feature.normals.size()), count("radii", feature.radii.size());
  const size_t least = feature.kind == Feature::Kind::kLine ? 2 : 1;
  for (const auto& places : feature.places)
    if (places.size() < least)
      throw InputError("feature '" + feature.name + "' has " + std::to_string(places.size()) +
                       " places on an object; it needs " + std::to_string(least));
  for (const auto& places : feature.places)
    for (const Vec3d& p : places)
      if (!std::isfinite(p.lengthSqr()))
        throw InputError("feature '" + feature.name + "' has a place that is not finite");
  for (size_t k = 0; disk && k < objects; ++k)
    if (!(feature.radii[k] > 0) || !(feature.normals[k].length() > 0))
      throw InputError("feature '" + feature.name + "': a disk's radius and normal must not be 0");
}

void check(const std::vector<Object>& objects, const MorphOptions& options) {
  if (objects.empty()) throw InputError("a morph needs at least one object");
  for (const Object& o : objects)
    if (!o.levelSet || o.levelSet->empty()) throw GeometryError("'" + o.name + "' is empty");
  const auto range = [](const char* name, int value, int low, int high) {
    if (value < low || value > high)
      throw InputError(std::string(name) + " is " + std::to_string(value) + "; it must be from " +
                       std::to_string(low) + " to " + std::to_string(high));
  };
  range("slices", options.slices, 8, 1024);
  range("samples", options.samples, 16, 4096);
  for (const Feature& feature : options.features) check(feature, objects.size());
  for (const Region& region : options.regions) {
    if (region.object >= objects.size())
      throw InputError("region '" + region.name + "' is drawn on object " +
                       std::to_string(region.object + 1) + "; there are " + std::to_string(objects.size()));
    if (region.weights.size() != objects.size())
      throw InputError("region '" + region.name + "' has " + std::to_string(region.weights.size()) +
                       " weights for " + std::to_string(objects.size()) + " objects");
    const Vec3d box = region.box.extents();
    if ((region.kind == Region::Kind::kSphere && !(region.radius > 0)) ||
        (region.kind == Region::Kind::kBox && !(box[0] > 0 && box[1] > 0 && box[2] > 0)) ||
        (region.kind == Region::Kind::kSpine && !(region.from < region.to)) || !(region.border >= 0))
      throw InputError("region '" + region.name + "' has no extent, or a border below 0");
  }
  if (options.voxelSize < 0 || !std::isfinite(options.voxelSize))
    throw InputError("voxel size is " + std::to_string(options.voxelSize) + "; it must be positive");
}

/// The node spacing of the map: finer than any feature the matching can make, coarse enough to be cheap.
int nodeStep(const std::vector<Chart>& charts, double halfLength, double voxelSize) {
  const double voxels = 2 * halfLength * charts[0].scale[0] / voxelSize;
  return voxels > 400 ? 8 : 4;
}

}  // namespace

MorphPlan::MorphPlan(std::vector<Object> objects, const MorphOptions& options, Progress* progress)
    : impl_(std::make_unique<Impl>()) {
  check(objects, options);
  Progress none;
  Progress& sink = progress ? *progress : none;
  impl_->options = options;
  impl_->measure(objects, nullptr, sink);
  impl_->decide(sink);
}

MorphPlan::MorphPlan(std::vector<Object> objects, const MorphPlan& before, Progress* progress)
    : impl_(std::make_unique<Impl>()) {
  if (objects.size() != before.objectCount())
    throw InputError(std::to_string(objects.size()) + " objects were given to follow a plan of " +
                     std::to_string(before.objectCount()));
  check(objects, before.impl_->options);
  Progress none;
  Progress& sink = progress ? *progress : none;
  impl_->options = before.impl_->options;
  impl_->measure(objects, before.impl_.get(), sink);
  if (!impl_->follow(*before.impl_, sink)) impl_->decide(sink);
}

/// Takes the objects, with the fields that an earlier plan of the same objects has already.
void MorphPlan::Impl::measure(const std::vector<Object>& objects, const Impl* before, Progress& progress) {
  for (const Object& object : objects) {
    shapeOf.push_back(indexOfSame(levelSets, object.levelSet));
    if (shapeOf.back() == names.size()) names.push_back("'" + object.name + "'");
  }
  order.resize(levelSets.size());
  std::iota(order.begin(), order.end(), size_t(0));
  if (before && before->order.size() == order.size()) reorder(before->order);
  progress.report("measure distances", 0);
  fields.resize(levelSets.size());
  pieces.resize(levelSets.size());
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) {
    if (before && k < before->levelSets.size() && isSame(*before->levelSets[k], *levelSets[k])) {
      levelSets[k] = before->levelSets[k], fields[k] = before->fields[k], pieces[k] = before->pieces[k];
      return;
    }
    fields[k] = std::make_shared<DistanceField>(levelSets[k]);
    pieces[k] = countPieces(*levelSets[k]);
  });
  // The slicing direction is the first object's: then it is the one that the others are laid on.
  if (!before && fields.size() > 2 && options.axis.length() == 0) reorder(typicalOrder(fields));
  measureInner(objects);
  takeGuidance(objects);
}

/// Puts the shapes in another order, so that nothing depends on the one in which they were given.
void MorphPlan::Impl::reorder(const std::vector<size_t>& by) {
  std::vector<size_t> place(by.size());
  for (size_t i = 0; i < by.size(); ++i) place[by[i]] = i;
  for (size_t& shape : shapeOf) shape = place[shape];
  const auto moved = [&](auto& list) {
    auto old = std::exchange(list, {});
    for (size_t i : by)
      if (i < old.size()) list.push_back(old[i]);
  };
  moved(levelSets), moved(names), moved(order), moved(fields), moved(pieces);
}

/// Features and regions, of the shapes.
void MorphPlan::Impl::takeGuidance(const std::vector<Object>& objects) {
  for (const Feature& feature : options.features) {
    Feature own{feature.name, feature.kind, {}, {}, {}};
    own.places.resize(levelSets.size()), own.normals.resize(levelSets.size()),
        own.radii.resize(levelSets.size());
    for (size_t k = objects.size(); k-- > 0;) {
      own.places[shapeOf[k]] = feature.places[k];
      if (feature.kind != Feature::Kind::kDisk) continue;
      own.normals[shapeOf[k]] = feature.normals[k], own.radii[shapeOf[k]] = feature.radii[k];
    }
    features.push_back(std::move(own));
  }
  for (Region region : options.regions) {
    region.object = shapeOf[region.object];
    region.weights = shapeWeights(region.weights);
    regions.push_back(std::move(region));
  }
}

/// Surfaces that only one shape has tell nothing.
void MorphPlan::Impl::measureInner(const std::vector<Object>& objects) {
  size_t count = 0;
  for (const Object& object : objects) count = std::max(count, object.inner.size());
  for (size_t n = 0; n < count; ++n) {
    std::vector<FloatGrid::ConstPtr> grids(levelSets.size());
    for (size_t k = 0; k < objects.size(); ++k)
      if (n < objects[k].inner.size() && objects[k].inner[n] && !objects[k].inner[n]->empty())
        grids[shapeOf[k]] = objects[k].inner[n];
    if (grids.size() - size_t(std::count(grids.begin(), grids.end(), nullptr)) < 2) continue;
    Fields surface(levelSets.size());
    tbb::parallel_for(size_t(0), surface.size(), [&](size_t k) {
      if (grids[k]) surface[k] = std::make_shared<DistanceField>(grids[k]);
    });
    inner.push_back(std::move(surface));
  }
}

void MorphPlan::Impl::decide(Progress& progress) {
  if (fields.size() < 2) return;  // nothing to match: every in-between is the one shape
  Notes notes = std::move(frames.notes);
  MorphOptions ofShapes = options;
  ofShapes.features = featuresInReach(features, fields, notes);
  frames = chooseFrames(fields, names, ofShapes, progress);
  frames.notes.insert(frames.notes.begin(), notes.begin(), notes.end());
  registration = fields.size() == 2 ? registerObjects(fields, inner, frames, ofShapes, progress)
                                    : matchThroughMean(startRegistration(fields, frames, ofShapes, progress),
                                                       fields, inner, frames, names, ofShapes, progress);
  if (drawn.empty()) drawn = frames.charts;
  move(false);
}

/// From the matching to the lattice that moves.
void MorphPlan::Impl::move(bool following) {
  std::shared_ptr<const RegionShares> shares;
  if (!regions.empty()) shares = std::make_shared<RegionShares>(regions, fields, frames.charts, drawn);
  for (size_t r = 0; r < regions.size() && !following; ++r)
    if (const size_t k = regions[r].object; !shares->holdsAnything(r, *fields[k])) {
      const openvdb::BBoxd& box = fields[k]->box();
      std::ostringstream text;
      text << "region '" << regions[r].name << "' holds nothing of " << names[k]
           << ", on which it is drawn; that lies between (" << box.min()[0] << ", " << box.min()[1] << ", "
           << box.min()[2] << ") and (" << box.max()[0] << ", " << box.max()[1] << ", " << box.max()[2]
           << ")";
      throw InputError(text.str());
    }
  std::shared_ptr<const ContourPaths> paths;
  if (options.path != ContourPath::kLinear)
    paths =
        std::make_shared<ContourPaths>(options.path, registration.map, fields, frames.charts, options.slices);
  lattice = std::make_unique<MovingLattice>(registration.map, fields, frames.charts, shares, paths);
}

/// Goes on from an earlier plan of the same objects, if that is a start.
bool MorphPlan::Impl::follow(const Impl& before, Progress& progress) {
  drawn = before.drawn;
  // Features were said of where the objects began.
  features.clear();
  if (shapeOf != before.shapeOf) {
    drawn.clear();
    frames.notes = {{"sequence.planned-anew", Severity::kNote, "",
                     "planned anew: other objects are equal than in the frame before"}};
    return false;
  }
  if (fields.size() < 2) return true;
  if (fields == before.fields) {
    frames = before.frames, registration = before.registration;
    move(true);
    return true;
  }
  frames = trackFrames(before.frames, before.fields, fields, names, options.align);
  MorphOptions following = options;
  following.features.clear();
  std::optional<Registration> next =
      followRegistration(before.registration, fields, inner, frames, following, progress);
  if (!next) {
    frames.notes = {
        {"sequence.planned-anew", Severity::kNote, "",
         "planned anew: the objects are not where those of the frame before lead to, as after a cut"}};
    return false;
  }
  registration = std::move(*next);
  move(true);
  return true;
}

InBetween MorphPlan::frame(const Weights& weights) const {
  const Impl& p = *impl_;
  const Weights w = p.shapeWeights(weights);
  if (const std::optional<size_t> alone = p.aloneAt(w))
    return {resampledTo(p.levelSets[*alone], p.frameVoxelSize(w))};

  const MovingLattice::Pose pose = p.lattice->poseAt(w);
  const double voxelSize = p.frameVoxelSize(pose.mean);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  const int step = nodeStep({pose.chart}, p.frames.halfLength, voxelSize);
  const NodeMap nodes = p.lattice->nodesNearSurface(pose, *transform, step);
  DistanceBlend blend{p.lattice->localWeights(w), {}, pose.chart.meanScale()};
  for (const Chart& chart : p.frames.charts) blend.sizes.push_back(chart.meanScale());
  InBetween result{rebuildLevelSet(nodes, p.fields, blend, *transform), nodes.foldShare};
  result.smallComponents = removeSmallComponents(*result.surface, p.piecesOf(pose.mean));
  return result;
}

Pullback MorphPlan::pullback(const Weights& weights) const {
  const Impl& p = *impl_;
  auto pullback = std::make_unique<Pullback::Impl>();
  pullback->alone = p.regions.empty() ? aloneIn(weights) : std::nullopt;
  pullback->weights = withoutNegatives(weights);
  pullback->shapeOf = p.shapeOf;
  pullback->shapeWeights = p.shapeWeights(weights);
  if (!p.regions.empty() && p.lattice) {
    std::vector<Region> ofObjects = p.regions;
    for (size_t r = 0; r < ofObjects.size(); ++r)
      ofObjects[r].weights = withoutNegatives(p.options.regions[r].weights);
    pullback->regions =
        std::make_unique<RegionShares>(std::move(ofObjects), p.fields, p.frames.charts, p.drawn);
  }
  for (const auto& field : p.fields) pullback->anchors.push_back(field->anchor());
  pullback->carrying.anchor = pullback->anchors[0];
  pullback->carrying.lattice = p.lattice.get();
  pullback->sizes.assign(p.fields.size(), 1);
  pullback->fields = p.fields;
  pullback->imageSpacing = p.fields[0]->box().extents().length() / kImageNodes;
  if (p.lattice) {
    pullback->carrying.pose = p.lattice->poseAt(pullback->shapeWeights);
    const Chart& chart = pullback->carrying.pose.chart;
    for (size_t k = 0; k < p.fields.size(); ++k)
      pullback->sizes[k] = chart.meanScale() / p.frames.charts[k].meanScale();
    pullback->imageSpacing = p.registration.map.lattice.spacing * chart.meanScale() * kImageShare;
  }
  return Pullback(std::move(pullback));
}

std::vector<Vec3d> MorphPlan::correspond(const std::vector<Vec3d>& points, size_t from, size_t to) const {
  const Impl& p = *impl_;
  if (from >= p.shapeOf.size() || to >= p.shapeOf.size())
    throw InputError("there is no object " + std::to_string(std::max(from, to)) + "; there are " +
                     std::to_string(p.shapeOf.size()));
  if (!p.lattice || p.shapeOf[from] == p.shapeOf[to]) return points;
  return p.lattice->carryPoints(points, p.lattice->poseOf(p.shapeOf[from]), p.lattice->poseOf(p.shapeOf[to]));
}

std::vector<Vec3d> MorphPlan::carryPoints(const std::vector<Vec3d>& points, size_t from,
                                          const Weights& to) const {
  const Impl& p = *impl_;
  const Weights w = p.shapeWeights(to);
  if (!p.lattice || p.aloneAt(w) == p.shapeOf.at(from)) return points;
  return p.lattice->carryPoints(points, p.lattice->poseOf(p.shapeOf[from]), p.lattice->poseAt(w));
}

std::vector<Vec3d> MorphPlan::carryPoints(const std::vector<Vec3d>& points, const Weights& from,
                                          const Weights& to) const {
  const Impl& p = *impl_;
  const Weights a = p.shapeWeights(from), b = p.shapeWeights(to);
  if (a == b || !p.lattice) return points;
  return p.lattice->carryPoints(points, p.lattice->poseAt(a), p.lattice->poseAt(b));
}

Weights MorphPlan::Impl::shapeWeights(const Weights& weights) const {
  if (weights.size() != shapeOf.size())
    throw InputError(std::to_string(weights.size()) + " weights were given for " +
                     std::to_string(shapeOf.size()) + " objects");
  double sum = 0;
  for (double w : weights) {
    if (!(w >= kLeastWeight))
      throw InputError("weight " + std::to_string(w) + " is below " + std::to_string(kLeastWeight) +
                       "; weights are 0 or more");
    sum += w;
  }
  if (std::abs(sum - 1) > 1e-6)
    throw InputError("the weights sum to " + std::to_string(sum) + "; they must sum to 1");
  Weights result(levelSets.size(), 0);
  for (size_t k = 0; k < weights.size(); ++k) result[shapeOf[k]] += weights[k] / sum;
  if (const std::optional<size_t> alone = aloneIn(result)) {
    result.assign(result.size(), 0);
    result[*alone] = 1;
  }
  return result;
}

/// The shape that an in-between is, if it is one.
std::optional<size_t> MorphPlan::Impl::aloneAt(const Weights& shapeWeights) const {
  const std::optional<size_t> alone = aloneIn(shapeWeights);
  for (const Region& region : regions)
    if (aloneIn(region.weights) != alone) return std::nullopt;
  return alone;
}

double MorphPlan::Impl::frameVoxelSize(const Weights& weights) const {
  if (options.voxelSize > 0) return options.voxelSize;
  double size = 0;
  double least = 1e300;
  for (size_t k = 0; k < weights.size(); ++k) {
    const double own = levelSets[k]->voxelSize()[0];
    size += weights[k] * own, least = std::min(least, own);
  }
  return std::max(size, 0.5 * least);  // weights below 0 might lead to nothing
}

/// No in-between has more pieces than the richest of its objects, crumbs not counted.
int MorphPlan::Impl::piecesOf(const Weights& weights) const {
  int most = 1;
  for (size_t k = 0; k < weights.size(); ++k)
    if (weights[k] > 0) most = std::max(most, pieces[k]);
  return most;
}

MorphPlan::~MorphPlan() = default;
MorphPlan::MorphPlan(MorphPlan&&) noexcept = default;
MorphPlan& MorphPlan::operator=(MorphPlan&&) noexcept = default;

size_t MorphPlan::objectCount() const { return impl_->shapeOf.size(); }

Notes MorphPlan::notes() const {
  Notes notes = impl_->frames.notes;
  notes.insert(notes.end(), impl_->registration.notes.begin(), impl_->registration.notes.end());
  return notes;
}

std::vector<SlicePicture> MorphPlan::slicePictures() const {
  const Registration& r = impl_->registration;
  const size_t objects = r.stacks.size();
  std::vector<size_t> shape(objects);  // in the order in which the objects were given
  for (size_t k = 0; k < objects; ++k) shape[impl_->order[k]] = k;
  std::vector<SlicePicture> pictures(r.planes.z0.size());
  for (size_t i = 0; i < pictures.size(); ++i) {
    pictures[i].u = r.planes.z0[i] / impl_->frames.halfLength;
    for (size_t k : shape) {
      pictures[i].objects.emplace_back();
      for (const Contour& c : r.stacks[k][i]) pictures[i].objects.back().push_back({c.points, c.hole(), -1});
    }
  }
  for (const ContourPair& pair : r.pairs) {
    const size_t a = impl_->order[pair.objectA], b = impl_->order[pair.objectB];
    if (b == a + 1) pictures[pair.slice].objects[a][pair.contourA].partner = int(pair.contourB);
    if (a == b + 1) pictures[pair.slice].objects[b][pair.contourB].partner = int(pair.contourA);
  }
  return pictures;
}

std::optional<size_t> aloneIn(const Weights& weights) {
  constexpr double kNothing = 1e-9;
  std::optional<size_t> alone;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (std::abs(weights[k]) < kNothing) continue;
    if (alone || std::abs(weights[k] - 1) > kNothing) return std::nullopt;
    alone = k;
  }
  return alone;
}

Weights withoutNegatives(const Weights& weights) {
  Weights result;
  double sum = 0;
  for (double w : weights) result.push_back(std::max(w, 0.0)), sum += result.back();
  for (double& w : result) w /= sum;
  return result;
}

}  // namespace slicemorph
