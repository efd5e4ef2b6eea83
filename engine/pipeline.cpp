#include "engine/slicemorph.h"

#include "engine/blend/moving_lattice.h"
#include "engine/errors.h"
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
  std::vector<size_t> shapeOf;                 ///< the distinct shape of each object; equal objects share one
  std::vector<FloatGrid::ConstPtr> levelSets;  ///< per distinct shape, as all below
  Fields fields;
  Frames frames;
  Registration registration;
  std::unique_ptr<MovingLattice> lattice;
  std::vector<int> pieces;                     ///< of each shape
  double voxelSize = 0;

  Weights shapeWeights(const Weights& weights) const;
  double frameVoxelSize(const Weights& weights) const;
  int piecesOf(const Weights& weights) const;
};

namespace {

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
  Impl& p = *impl_;
  p.voxelSize = options.voxelSize;
  for (const Object& object : objects) p.shapeOf.push_back(indexOfSame(p.levelSets, object.levelSet));

  sink.report("measure distances", 0);
  p.fields.resize(p.levelSets.size());
  p.pieces.resize(p.levelSets.size());
  tbb::parallel_for(size_t(0), p.fields.size(), [&](size_t k) {
    p.fields[k] = std::make_shared<DistanceField>(p.levelSets[k]);
    p.pieces[k] = countPieces(*p.levelSets[k]);
  });
  if (p.fields.size() < 2) return;  // nothing to match: every in-between is the one shape
  p.frames = chooseFrames(p.fields, options, sink);
  p.registration = registerObjects(p.fields, p.frames, options, sink);
  p.lattice = std::make_unique<MovingLattice>(p.registration.map, p.fields, p.frames.charts);
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
  if (p.lattice) carrier->carrying.pose = p.lattice->poseAt(carrier->shapeWeights);
  return Carrier(std::move(carrier));
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
  if (voxelSize > 0) return voxelSize;
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
