#include "engine/slicemorph.h"

#include "engine/blend/moving_lattice.h"
#include "engine/errors.h"
#include "engine/frame/track.h"
#include "engine/match/choose_frames.h"
#include "engine/match/register.h"
#include "engine/rebuild/carrier.h"
#include "engine/rebuild/crumbs.h"
#include "engine/rebuild/rebuild.h"
#include "engine/volume/same_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

/// The whole pipeline on one screen: a plan (volume -> frames -> slices -> contours -> match), then one frame after
/// another (blend -> rebuild).
namespace slicemorph {

struct MorphPlan::Impl {
  MorphOptions options;
  std::vector<size_t> shapeOf;                 ///< the distinct shape of each object; equal objects share one
  std::vector<FloatGrid::ConstPtr> levelSets;  ///< per distinct shape, as all below
  Fields fields;
  std::vector<Fields> inner;                   ///< further surfaces, each per distinct shape; null where one has none
  Frames frames;
  Registration registration;
  std::unique_ptr<MovingLattice> lattice;
  std::vector<int> pieces;                     ///< of each shape
  std::vector<Landmark> shapeLandmarks;        ///< the options', per distinct shape

  void measure(const std::vector<Object>& objects, const Impl* before, Progress& progress);
  void measureInner(const std::vector<Object>& objects);
  void decide(Progress& progress);
  bool follow(const Impl& before, Progress& progress);

  Weights shapeWeights(const Weights& weights) const;
  double frameVoxelSize(const Weights& weights) const;
  int piecesOf(const Weights& weights) const;
};

namespace {

/// Nodes that carry images lie this share of the matching's lattice apart; without one that many on the object's diagonal.
constexpr double kImageShare = 0.75, kImageNodes = 64;

void check(const std::vector<Object>& objects, const MorphOptions& options) {
  if (objects.empty()) throw InputError("a morph needs at least one object");
  for (const Object& o : objects)
    if (!o.levelSet || o.levelSet->empty()) throw GeometryError("'" + o.name + "' is empty");
  const auto range = [](const char* name, int value, int low, int high) {
    if (value < low || value > high)
      throw InputError(std::string(name) + " is " + std::to_string(value) + "; it must be from " + std::to_string(low) +
                       " to " + std::to_string(high));
  };
  range("slices", options.slices, 8, 1024);
  range("samples", options.samples, 16, 4096);
  for (const Landmark& mark : options.landmarks)
    if (mark.size() != objects.size())
      throw InputError("a landmark has " + std::to_string(mark.size()) + " places for " + std::to_string(objects.size()) +
                       " objects");
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
  for (const Object& object : objects) shapeOf.push_back(indexOfSame(levelSets, object.levelSet));
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
  measureInner(objects);
  std::vector<Landmark> landmarks;  // of the distinct shapes
  for (const Landmark& mark : options.landmarks) {
    landmarks.emplace_back(levelSets.size());
    for (size_t k = objects.size(); k-- > 0;) landmarks.back()[shapeOf[k]] = mark[k];
  }
  shapeLandmarks = std::move(landmarks);
}

/// Surfaces that only one shape has tell nothing.
void MorphPlan::Impl::measureInner(const std::vector<Object>& objects) {
  size_t count = 0;
  for (const Object& object : objects) count = std::max(count, object.inner.size());
  for (size_t n = 0; n < count; ++n) {
    std::vector<FloatGrid::ConstPtr> grids(levelSets.size());
    for (size_t k = 0; k < objects.size(); ++k)
      if (n < objects[k].inner.size() && objects[k].inner[n] && !objects[k].inner[n]->empty()) grids[shapeOf[k]] = objects[k].inner[n];
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
  std::vector<std::string> notes = std::move(frames.notes);
  MorphOptions ofShapes = options;
  ofShapes.landmarks = shapeLandmarks;
  frames = chooseFrames(fields, ofShapes, progress);
  frames.notes.insert(frames.notes.begin(), notes.begin(), notes.end());
  registration = registerObjects(fields, inner, frames, ofShapes, progress);
  lattice = std::make_unique<MovingLattice>(registration.map, fields, frames.charts);
}

/// Goes on from an earlier plan of the same objects, if that is a start.
bool MorphPlan::Impl::follow(const Impl& before, Progress& progress) {
  if (shapeOf != before.shapeOf) {
    frames.notes = {"planned anew: other objects are equal than in the frame before"};
    return false;
  }
  if (fields.size() < 2) return true;
  if (fields == before.fields) {
    frames = before.frames, registration = before.registration;
    lattice = std::make_unique<MovingLattice>(*before.lattice);
    return true;
  }
  frames = trackFrames(before.frames, before.fields, fields, options.align);
  std::optional<Registration> next = followRegistration(before.registration, fields, inner, frames, options, progress);
  if (!next) {
    frames.notes = {"planned anew: the objects are not where those of the frame before lead to, as after a cut"};
    return false;
  }
  registration = std::move(*next);
  lattice = std::make_unique<MovingLattice>(registration.map, fields, frames.charts);
  return true;
}

InBetween MorphPlan::frame(const Weights& weights) const {
  const Impl& p = *impl_;
  const Weights w = p.shapeWeights(weights);
  const double voxelSize = p.frameVoxelSize(w);
  for (size_t k = 0; k < w.size(); ++k)
    if (w[k] == 1) return {resampledTo(p.levelSets[k], voxelSize)};

  const MovingLattice::Pose pose = p.lattice->poseAt(w);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  const int step = nodeStep({pose.chart}, p.frames.halfLength, voxelSize);
  const NodeMap nodes = p.lattice->nodesNearSurface(pose, *transform, step);
  std::vector<double> factors;  // every object's distances count in units of its own size
  for (size_t k = 0; k < w.size(); ++k) factors.push_back(w[k] * pose.chart.meanScale() / p.frames.charts[k].meanScale());
  InBetween result{rebuildLevelSet(nodes, p.fields, factors, *transform), nodes.foldShare};
  result.crumbs = removeCrumbs(*result.surface, p.piecesOf(w));
  return result;
}

Carrier MorphPlan::carrier(const Weights& weights) const {
  const Impl& p = *impl_;
  auto carrier = std::make_unique<Carrier::Impl>();
  carrier->weights = weights;
  carrier->shapeOf = p.shapeOf;
  carrier->shapeWeights = p.shapeWeights(weights);
  for (const auto& field : p.fields) carrier->anchors.push_back(field->anchor());
  carrier->carrying.anchor = carrier->anchors[0];
  carrier->carrying.lattice = p.lattice.get();
  carrier->sizes.assign(p.fields.size(), 1);
  carrier->fields = p.fields;
  carrier->imageSpacing = p.fields[0]->box().extents().length() / kImageNodes;
  if (p.lattice) {
    carrier->carrying.pose = p.lattice->poseAt(carrier->shapeWeights);
    const Chart& chart = carrier->carrying.pose.chart;
    for (size_t k = 0; k < p.fields.size(); ++k) carrier->sizes[k] = chart.meanScale() / p.frames.charts[k].meanScale();
    carrier->imageSpacing = p.registration.map.lattice.spacing * chart.meanScale() * kImageShare;
  }
  return Carrier(std::move(carrier));
}

std::vector<Vec3d> MorphPlan::correspond(const std::vector<Vec3d>& points, size_t from, size_t to) const {
  const Impl& p = *impl_;
  if (from >= p.shapeOf.size() || to >= p.shapeOf.size())
    throw InputError("there is no object " + std::to_string(std::max(from, to)) + "; there are " + std::to_string(p.shapeOf.size()));
  Weights start(p.shapeOf.size(), 0), end = start;
  start[from] = end[to] = 1;
  return carryPoints(points, start, end);
}

std::vector<Vec3d> MorphPlan::carryPoints(const std::vector<Vec3d>& points, const Weights& from, const Weights& to) const {
  const Impl& p = *impl_;
  const Weights a = p.shapeWeights(from), b = p.shapeWeights(to);
  if (a == b || !p.lattice) return points;
  return p.lattice->carryPoints(points, p.lattice->poseAt(a), p.lattice->poseAt(b));
}

Weights MorphPlan::Impl::shapeWeights(const Weights& weights) const {
  if (weights.size() != shapeOf.size())
    throw InputError(std::to_string(weights.size()) + " weights were given for " + std::to_string(shapeOf.size()) +
                     " objects");
  double sum = 0;
  for (double w : weights) {
    if (!(w >= 0)) throw InputError("weight " + std::to_string(w) + " is negative; weights are 0 or more");
    sum += w;
  }
  if (std::abs(sum - 1) > 1e-6) throw InputError("the weights sum to " + std::to_string(sum) + "; they must sum to 1");
  Weights result(levelSets.size(), 0);
  for (size_t k = 0; k < weights.size(); ++k) result[shapeOf[k]] += weights[k] / sum;
  for (size_t k = 0; k < result.size(); ++k)
    if (result[k] > 1 - 1e-9) {
      result.assign(result.size(), 0);
      result[k] = 1;
    }
  return result;
}

double MorphPlan::Impl::frameVoxelSize(const Weights& weights) const {
  if (options.voxelSize > 0) return options.voxelSize;
  double size = 0;
  for (size_t k = 0; k < weights.size(); ++k) size += weights[k] * levelSets[k]->voxelSize()[0];
  return size;
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

std::vector<std::string> MorphPlan::notes() const {
  std::vector<std::string> notes = impl_->frames.notes;
  notes.insert(notes.end(), impl_->registration.notes.begin(), impl_->registration.notes.end());
  return notes;
}

std::vector<SlicePicture> MorphPlan::slicePictures() const {
  const Registration& r = impl_->registration;
  std::vector<SlicePicture> pictures(r.planes.z0.size());
  for (size_t i = 0; i < pictures.size(); ++i) {
    pictures[i].u = r.planes.z0[i] / impl_->frames.halfLength;
    for (const ContourStack& stack : r.stacks) {
      pictures[i].objects.emplace_back();
      for (const Contour& c : stack[i]) pictures[i].objects.back().push_back({c.points, c.hole(), -1});
    }
  }
  for (const ContourPair& pair : r.pairs)
    if (pair.objectB == pair.objectA + 1)
      pictures[pair.slice].objects[pair.objectA][pair.contourA].partner = int(pair.contourB);
  return pictures;
}

}  // namespace slicemorph
