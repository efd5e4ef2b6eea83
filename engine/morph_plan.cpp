#include "engine/blend/surface_stretch.h"
#include "engine/pipeline.h"
#include "engine/plan_decisions.h"
#include "engine/rebuild/pullback.h"
#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

/// Implementation of the library's public class MorphPlan on top of a Plan.
namespace slicemorph {

struct MorphPlan::Impl {
  explicit Impl(Plan p) : plan(std::move(p)) {}

  Plan plan;

  /// The map of the frame that was made last: its grids follow it mostly.
  struct LastMap {
    Weights weights;  ///< of the objects
    std::shared_ptr<const SurfaceMap> map;
  };
  LastMap last() const {
    const std::lock_guard lock(mutex_);
    return last_;
  }
  void setLast(LastMap last) const {
    const std::lock_guard lock(mutex_);
    last_ = std::move(last);
  }

 private:
  mutable std::mutex mutex_;
  mutable LastMap last_;
};

namespace {

/// Spacing of the nodes at which images are pulled back: this share of the lattice's spacing; without a
/// lattice, the object's diagonal over kImageNodes. Chosen by hand.
constexpr double kImageShare = 0.75, kImageNodes = 64;

size_t shapeOfObject(const Shapes& shapes, size_t object) {
  if (object >= shapes.shapeOf.size())
    throw InputError("there is no object " + std::to_string(object) + "; there are " +
                     std::to_string(shapes.shapeOf.size()));
  return shapes.shapeOf[object];
}

/// The regions with their weights per object instead of per shape.
std::unique_ptr<RegionShares> sharesOfObjects(const Plan& plan) {
  std::vector<Region> regions = plan.shapes.regions;
  for (size_t r = 0; r < regions.size(); ++r)
    regions[r].weights = withoutNegatives(plan.options.regions[r].weights);
  return std::make_unique<RegionShares>(std::move(regions), plan.shapes.fields, plan.frames.charts,
                                        plan.drawn);
}

}  // namespace

MorphPlan::MorphPlan(std::vector<Object> objects, const MorphOptions& options, Progress* progress) {
  Progress none;
  impl_.reset(new Impl(planMorph(objects, options, progress ? *progress : none)));
}

MorphPlan::MorphPlan(std::vector<Object> objects, const MorphPlan& before, Progress* progress) {
  if (objects.size() != before.objectCount())
    throw InputError(std::to_string(objects.size()) + " objects were given to follow a plan of " +
                     std::to_string(before.objectCount()));
  if (before.impl_->plan.lattice && before.impl_->plan.registration.base.of.empty())
    throw InputError("a plan that was decided before cannot be followed by another");
  Progress none;
  impl_.reset(new Impl(planNext(objects, before.impl_->plan, progress ? *progress : none)));
}

MorphPlan::MorphPlan(Made, std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

MorphPlan MorphPlan::decidedBefore(std::vector<Object> objects, const MorphOptions& options,
                                   const std::string& decisions, Progress* progress) {
  Progress none;
  Plan plan = planDecided(objects, options, decisions, progress ? *progress : none);
  return MorphPlan(Made(), std::unique_ptr<Impl>(new Impl(std::move(plan))));
}

std::string MorphPlan::decisions() const { return bytesOfDecisions(impl_->plan); }

MorphPlan::~MorphPlan() = default;
MorphPlan::MorphPlan(MorphPlan&&) noexcept = default;
MorphPlan& MorphPlan::operator=(MorphPlan&&) noexcept = default;

InBetween MorphPlan::frame(const Weights& weights) const {
  impl_->setLast({});  // frees its memory first
  RebuiltShape made = makeInBetween(impl_->plan, weights);
  impl_->setLast({weights, std::move(made.map)});
  return std::move(made.shape);
}

Pullback MorphPlan::pullback(const Weights& weights) const {
  const Plan& plan = impl_->plan;
  const Shapes& shapes = plan.shapes;
  auto pullback = std::make_unique<Pullback::Impl>();
  pullback->shapeWeights = shapes.weightsFrom(weights);
  pullback->alone = shapes.regions.empty() ? aloneIn(weights) : std::nullopt;
  pullback->weights = withoutNegatives(weights);
  pullback->shapeOf = shapes.shapeOf;
  if (!shapes.regions.empty() && plan.lattice) pullback->regions = sharesOfObjects(plan);
  for (const auto& field : shapes.fields) pullback->anchors.push_back(field->anchor());
  pullback->carrying.anchor = pullback->anchors[0];
  pullback->carrying.lattice = plan.lattice.get();
  pullback->densities = laysDensities(plan);
  pullback->sizes.assign(shapes.fields.size(), 1);
  pullback->fields = shapes.fields;
  pullback->imageSpacing = shapes.fields[0]->box().extents().length() / kImageNodes;
  if (plan.lattice) {
    if (const Impl::LastMap last = impl_->last(); last.map && last.weights == weights)
      pullback->surface = last.map, pullback->carrying.pose = last.map->pose;
    else
      pullback->carrying.pose =
          std::make_shared<const LatticePose>(plan.lattice->poseAt(pullback->shapeWeights));
    const Chart& chart = pullback->carrying.pose->chart;
    for (size_t k = 0; k < shapes.fields.size(); ++k)
      pullback->sizes[k] = chart.meanScale() / plan.frames.charts[k].meanScale();
    pullback->imageSpacing = plan.registration.map.lattice.spacing * chart.meanScale() * kImageShare;
  }
  return Pullback(std::move(pullback));
}

std::vector<Vec3d> MorphPlan::correspond(const std::vector<Vec3d>& points, size_t from, size_t to) const {
  const Plan& plan = impl_->plan;
  const size_t a = shapeOfObject(plan.shapes, from), b = shapeOfObject(plan.shapes, to);
  if (!plan.lattice || a == b) return points;
  return plan.lattice->carryPoints(points, plan.lattice->poseOf(a), plan.lattice->poseOf(b));
}

std::vector<Vec3d> MorphPlan::carryPoints(const std::vector<Vec3d>& points, size_t from,
                                          const Weights& to) const {
  const Plan& plan = impl_->plan;
  const size_t shape = shapeOfObject(plan.shapes, from);
  const Weights w = plan.shapes.weightsFrom(to);
  if (!plan.lattice || plan.shapes.aloneAt(w) == shape) return points;
  return plan.lattice->carryPoints(points, plan.lattice->poseOf(shape), plan.lattice->poseAt(w));
}

std::vector<Vec3d> MorphPlan::carryPoints(const std::vector<Vec3d>& points, const Weights& from,
                                          const Weights& to) const {
  const Plan& plan = impl_->plan;
  const Weights a = plan.shapes.weightsFrom(from), b = plan.shapes.weightsFrom(to);
  if (a == b || !plan.lattice) return points;
  return plan.lattice->carryPoints(points, plan.lattice->poseAt(a), plan.lattice->poseAt(b));
}

void MorphPlan::passSmoothly(const Stretch& before, const Stretch& after) {
  if (objectCount() != 2 || (before.plan && before.plan->objectCount() != 2) ||
      (after.plan && after.plan->objectCount() != 2))
    throw InputError("only plans of two objects follow each other");
  Plan& plan = impl_->plan;
  if (!plan.lattice) return;
  // By the neighbouring plan, in this one's time.
  const auto along = [](const Stretch& stretch, size_t from, size_t to) -> PathTangents::Neighbour {
    if (!stretch.plan) return {};
    return [=](const std::vector<Vec3d>& points) {
      std::vector<Vec3d> moved = stretch.plan->correspond(points, from, to);
      for (size_t i = 0; i < points.size(); ++i)
        moved[i] = points[i] + stretch.ratio * (moved[i] - points[i]);
      return moved;
    };
  };
  std::array<PathTangents::Neighbour, 2> of;
  of[plan.shapes.shapeOf[0]] = along(before, 1, 0), of[plan.shapes.shapeOf[1]] = along(after, 0, 1);
  plan.lattice->passSmoothly(of);
  impl_->setLast({});
}

FrameStrain MorphPlan::strain(const Weights& weights) const {
  const Plan& plan = impl_->plan;
  const Weights w = withoutNegatives(plan.shapes.weightsFrom(weights));
  FrameStrain strain;
  if (!plan.lattice) return strain;
  const LatticePose pose = plan.lattice->poseAt(w);
  strain.meanStretch = 0;
  for (size_t k = 0; k < w.size(); ++k) {
    if (w[k] == 0) continue;
    const SurfaceStretch s = surfaceStretch(*plan.lattice, *plan.shapes.fields[k], k, pose);
    strain.meanStretch += w[k] * s.mean, strain.worstStretch = std::max(strain.worstStretch, s.worst);
    strain.muchStretched += w[k] * s.beyond, strain.meanTurn += w[k] * s.turned;
  }
  return strain;
}

std::vector<TurnChoice> MorphPlan::turnChoices() const { return impl_->plan.frames.choices; }

double MorphPlan::overlap() const { return impl_->plan.registration.overlapAfter; }

size_t MorphPlan::objectCount() const { return impl_->plan.shapes.shapeOf.size(); }

Notes MorphPlan::notes() const {
  Notes notes = impl_->plan.frames.notes;
  const Notes& matching = impl_->plan.registration.notes;
  notes.insert(notes.end(), matching.begin(), matching.end());
  return notes;
}

std::vector<SlicePicture> MorphPlan::slicePictures() const {
  const Plan& plan = impl_->plan;
  const TracedObjects& traced = plan.traced;
  const std::vector<size_t>& order = plan.shapes.order;
  std::vector<size_t> shape(traced.stacks.size());  // in the order in which the objects were given
  for (size_t k = 0; k < shape.size(); ++k) shape[order[k]] = k;
  std::vector<SlicePicture> pictures(traced.planes.z0.size());
  for (size_t i = 0; i < pictures.size(); ++i) {
    pictures[i].u = traced.planes.z0[i] / plan.frames.halfLength;
    for (size_t k : shape) {
      pictures[i].objects.emplace_back();
      for (const Contour& c : traced.stacks[k][i])
        pictures[i].objects.back().push_back({c.points, c.hole(), -1});
    }
  }
  for (const ContourPair& pair : plan.registration.pairs) {
    const size_t a = order[pair.objectA], b = order[pair.objectB];
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
