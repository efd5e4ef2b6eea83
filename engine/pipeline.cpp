#include "engine/pipeline.h"

#include "engine/check_objects.h"
#include "engine/frame/track.h"
#include "engine/match/choose_frames.h"
#include "engine/match/match_densities.h"
#include "engine/mean/match_through_mean.h"
#include "engine/plan_decisions.h"
#include "engine/rebuild/in_between.h"
#include "engine/rebuild/rejoin_components.h"
#include "engine/volume/same_grid.h"

#include <algorithm>
#include <cstdio>
#include <utility>

/// The whole method on one screen: a plan (measure, choose frames, slice, trace, match), then frame by
/// frame blend and rebuild.
namespace slicemorph {

namespace {

Plan withLattice(Plan plan, std::shared_ptr<const RegionShares> shares) {
  std::shared_ptr<const ContourPaths> paths;
  if (plan.options.path != ContourPath::kLinear)
    paths = std::make_shared<ContourPaths>(plan.options.path, plan.registration.map, plan.shapes.fields,
                                           plan.frames.charts, plan.options.slices);
  plan.lattice =
      std::make_unique<MovingLattice>(plan.registration.map, plan.shapes.fields, plan.frames.charts,
                                      std::move(shares), std::move(paths), plan.registration.swings);
  return plan;
}

/// Null if there are no regions.
std::shared_ptr<const RegionShares> regionShares(const Plan& plan) {
  if (plan.shapes.regions.empty()) return nullptr;
  return std::make_shared<RegionShares>(plan.shapes.regions, plan.shapes.fields, plan.frames.charts,
                                        plan.drawn);
}

/// Two densities that keep their positions are laid on each other wherever they are, not only at their shapes.
Plan withDensities(Plan plan) {
  if (!laysDensities(plan)) return plan;
  const Shapes& shapes = plan.shapes;
  DensityMatch match =
      matchDensities({shapes.densities[0], shapes.densities[1]}, {shapes.velocities[0], shapes.velocities[1]},
                     plan.frames.charts[0], plan.registration.map);
  char text[120];
  std::snprintf(text, sizeof text,
                "densities laid on each other: half way they differ by %.3f of their total, before %.3f",
                match.after, match.before);
  plan.registration.notes.push_back({"match.densities", Severity::kDetail, "", text});
  plan.registration.map = std::move(match.map), plan.registration.swings = false;
  return plan;
}

/// Completes a plan with measured shapes: coordinate frames, contours, registration and lattice.
/// `notes`: to put first.
Plan decided(Plan plan, const Notes& notes, Progress& progress) {
  const Shapes& shapes = plan.shapes;
  plan.frames.notes = notes;
  if (shapes.fields.size() < 2) return plan;  // nothing to match: every in-between is the one shape
  const FeaturesInReach reach = featuresInReach(shapes.features, shapes.fields);
  MorphOptions options = plan.options;
  options.features = reach.features;

  plan.frames = chooseFrames(shapes.fields, shapes.names, options, progress);
  plan.frames.notes.insert(plan.frames.notes.begin(), reach.notes.begin(), reach.notes.end());
  plan.frames.notes.insert(plan.frames.notes.begin(), notes.begin(), notes.end());
  const MatchObjects objects =
      measureObjects(shapes.fields, shapes.inner, plan.frames.charts, options.features);
  progress.report("slice", 0.05);
  SlicedObjects slices = sliceObjects(objects, options.slices);
  progress.report("trace contours", 0.08);
  plan.traced = traceObjects(std::move(slices));
  progress.report("match contours", 0.1);
  plan.registration = shapes.fields.size() == 2
                          ? registerObjects(objects, plan.traced, options.samples, kWholeRounds, progress)
                          : matchThroughMean(startRegistration(objects, plan.traced, options.samples),
                                             objects, plan.frames, shapes.names, options, progress);

  plan = withDensities(std::move(plan));
  if (plan.drawn.empty()) plan.drawn = plan.frames.charts;
  const std::shared_ptr<const RegionShares> shares = regionShares(plan);
  if (shares) checkRegions(shapes.regions, *shares, shapes.fields, shapes.names);
  return withLattice(std::move(plan), shares);
}

Notes plannedAnew(const char* why) {
  return {{"sequence.planned-anew", Severity::kNote, "", std::string("planned anew: ") + why}};
}

/// Tells whether at each of some world points of an in-between what some object has there is inside, or no farther outside
/// than a voxel.
class InSomeObject {
 public:
  InSomeObject(const Plan& plan, const Weights& weights, const MovingLattice::Pose& pose)
      : plan_(plan), pose_(pose) {
    for (size_t k = 0; k < weights.size(); ++k)
      if (weights[k] > 0) used_.push_back(k);
  }

  bool operator()(const std::vector<Vec3d>& points) {
    if (own_.empty())
      for (size_t k : used_) own_.push_back(plan_.lattice->poseOf(k));
    std::vector<char> inside(points.size(), 0);
    for (size_t n = 0; n < used_.size(); ++n) {
      const DistanceField& field = *plan_.shapes.fields[used_[n]];
      const DistanceField::Sampler distance(field);
      const std::vector<Vec3d> on = plan_.lattice->carryPoints(points, pose_, own_[n]);
      for (size_t i = 0; i < on.size(); ++i)
        if (distance(field.relative(on[i])) < field.voxelSize()) inside[i] = 1;
    }
    return std::count(inside.begin(), inside.end(), 0) == 0;
  }

 private:
  const Plan& plan_;
  const MovingLattice::Pose& pose_;
  std::vector<size_t> used_;
  std::vector<MovingLattice::Pose> own_;  ///< of the used objects; found when first asked for
};

}  // namespace

bool laysDensities(const Plan& plan) {
  const std::vector<FloatGrid::ConstPtr>& densities = plan.shapes.densities;
  if (densities.size() != 2 || plan.options.align != Align::kNone || !plan.shapes.features.empty())
    return false;
  for (size_t k = 0; k < 2; ++k)
    if (!densities[k] || densities[k]->empty() || !plan.frames.charts[k].bend.straight()) return false;
  return true;
}

Plan planMorph(const std::vector<Object>& objects, const MorphOptions& options, Progress& progress) {
  checkObjects(objects, options);
  progress.report("measure distances", 0);
  Plan plan;
  plan.options = options;
  plan.shapes = measureShapes(objects, options, nullptr);
  return decided(std::move(plan), {}, progress);
}

Plan planNext(const std::vector<Object>& objects, const Plan& before, Progress& progress) {
  checkObjects(objects, before.options);
  progress.report("measure distances", 0);
  Plan plan;
  plan.options = before.options;
  plan.shapes = measureShapes(objects, plan.options, &before.shapes);
  plan.shapes.features.clear();  // they hold for the sequence's first frame only
  const Shapes& shapes = plan.shapes;
  if (shapes.shapeOf != before.shapes.shapeOf)
    return decided(std::move(plan), plannedAnew("other objects are equal than in the frame before"),
                   progress);
  plan.drawn = before.drawn;
  if (shapes.fields.size() < 2) return plan;
  if (shapes.fields == before.shapes.fields) {
    plan.frames = before.frames, plan.traced = before.traced, plan.registration = before.registration;
  } else {
    plan.frames =
        trackFrames(before.frames, before.shapes.fields, shapes.fields, shapes.names, plan.options.align);
    const MatchObjects moved = measureObjects(shapes.fields, shapes.inner, plan.frames.charts, {});
    std::optional<Registration> next = followRegistration(before.registration, moved, progress);
    if (!next)
      return decided(
          std::move(plan),
          plannedAnew("the objects are not where those of the frame before lead to, as after a cut"),
          progress);
    plan.registration = std::move(*next);
    plan = withDensities(std::move(plan));
  }
  const std::shared_ptr<const RegionShares> shares = regionShares(plan);
  return withLattice(std::move(plan), shares);
}

Plan planDecided(const std::vector<Object>& objects, const MorphOptions& options,
                 const std::string& decisions, Progress& progress) {
  checkObjects(objects, options);
  progress.report("measure distances", 0);
  Plan plan;
  plan.options = options;
  plan.shapes = measureShapes(objects, options, nullptr);
  plan = withDecisions(std::move(plan), decisions);
  if (plan.shapes.fields.size() < 2) return plan;
  const std::shared_ptr<const RegionShares> shares = regionShares(plan);
  return withLattice(std::move(plan), shares);
}

RebuiltShape makeInBetween(const Plan& plan, const Weights& ofObjects) {
  const Shapes& shapes = plan.shapes;
  const double wanted = plan.options.voxelSize;
  const Weights weights = shapes.weightsFrom(ofObjects);
  if (const std::optional<size_t> alone = shapes.aloneAt(weights))
    return {{resampledTo(shapes.levelSets[*alone], shapes.voxelSizeAt(weights, wanted))}, nullptr};
  const auto pose = std::make_shared<const LatticePose>(plan.lattice->poseAt(weights));  // blend
  RebuiltShape result = rebuildInBetween({*plan.lattice, shapes.fields, plan.frames}, weights, pose,
                                         shapes.voxelSizeAt(pose->mean, wanted));
  FloatGrid& surface = *result.shape.surface;
  const Rejoined rejoined =
      rejoinComponents(surface, shapes.piecesAt(pose->mean), InSomeObject(plan, weights, *pose));
  result.shape.smallComponents = removeSmallComponents(surface, rejoined.loose);
  fillVoxelVoids(surface);
  return result;
}

}  // namespace slicemorph
