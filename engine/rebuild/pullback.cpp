#include "engine/rebuild/pullback.h"

#include "engine/rebuild/flowing_density.h"
#include "engine/rebuild/still_images.h"
#include "engine/rebuild/velocity_grid.h"
#include "engine/rebuild/warp_colors.h"
#include "engine/rebuild/warp_image.h"
#include "engine/rebuild/warp_labels.h"
#include "engine/volume/faint_values.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

using openvdb::GridBase;
using Transform = openvdb::math::Transform;

/// Number of node maps that are kept. The grids of one file mostly share one or two transforms.
constexpr size_t kKeptMaps = 3;
/// The smallest half float above 0 (IEEE 754): what is less is read back as 0.
constexpr double kLeastHalf = 5.9604645e-8;

/// Throws unless exactly one item per object was given.
void checkCount(size_t given, const char* what, size_t objects) {
  if (given != objects)
    throw InputError(std::to_string(given) + " " + what + " were given for " + std::to_string(objects) +
                     " objects");
}

template <typename T>
void checkNoneIsNull(const std::vector<const T*>& given, const char* what) {
  for (size_t k = 0; k < given.size(); ++k)
    if (!given[k])
      throw InputError("object " + std::to_string(k + 1) + " of " + std::to_string(given.size()) +
                       " has no " + what + "; every object needs one");
}

void checkLattice(const ImageLattice& lattice) {
  if (lattice.size[0] > 0 && lattice.size[1] > 0 && lattice.size[2] > 0) return;
  throw InputError("an in-between of " + std::to_string(lattice.size[0]) + " x " +
                   std::to_string(lattice.size[1]) + " x " + std::to_string(lattice.size[2]) +
                   " voxels was asked for; it needs one along every axis");
}

void checkImages(const std::vector<const Image*>& images) {
  checkNoneIsNull(images, "image");
  for (size_t k = 0; k < images.size(); ++k) {
    const size_t count = std::visit([](const auto& values) { return values.size(); }, images[k]->values);
    if (count != images[k]->lattice.count())
      throw InputError("the image of object " + std::to_string(k + 1) + " has " + std::to_string(count) +
                       " values for " + std::to_string(images[k]->lattice.count()) + " voxels");
  }
}

/// Allowed rounding error of the sum of rates, relative to 1 + the sum of their magnitudes; the same
/// as for weights.
constexpr double kRateTolerance = 1e-6;

void checkRate(const Weights& rate, size_t objects) {
  checkCount(rate.size(), "rates", objects);
  double sum = 0, all = 0;
  for (double r : rate) {
    if (!std::isfinite(r)) throw InputError("a rate is " + std::to_string(r) + "; rates must be finite");
    sum += r, all += std::abs(r);
  }
  if (std::abs(sum) > kRateTolerance * (1 + all))
    throw InputError("the rates sum to " + std::to_string(sum) + "; they must sum to 0, as weights sum to 1");
}

}  // namespace

Pullback::Pullback(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Pullback::~Pullback() = default;
Pullback::Pullback(Pullback&&) noexcept = default;
Pullback& Pullback::operator=(Pullback&&) noexcept = default;

GridBase::ConstPtr Pullback::carry(const std::vector<GridBase::ConstPtr>& grids,
                                   const PullbackOptions& options) {
  Impl& p = *impl_;
  checkCount(grids.size(), "grids", p.weights.size());
  const auto first = std::find_if(grids.begin(), grids.end(), [](const auto& grid) { return bool(grid); });
  if (first == grids.end()) throw InputError("none of the objects has a grid to carry");
  const GridBase& prototype = **first;
  if (!canCarry(prototype))
    throw InputError("values of the type " + prototype.valueType() + " cannot be carried");
  std::vector<CarriedGrid> carried;
  const size_t heaviest = size_t(std::max_element(p.weights.begin(), p.weights.end()) - p.weights.begin());
  bool half = true;
  for (size_t k = 0; k < grids.size(); ++k) {
    if (!grids[k]) continue;
    half = half && grids[k]->saveFloatAsHalf();
    if (p.alone == k && options.voxelSize == 0) return grids[k];
    if (!p.counts(k) || !(isBlended(prototype) || k == heaviest)) continue;
    const size_t shape = p.shapeOf[k];
    carried.push_back({grids[k], shape, p.anchors[shape], p.weights[k], k});
  }
  // What flows is hardly compressed: where two frames lie on each other, small changes of volume are the map's errors.
  const bool flowing = options.dropFaint && p.densities && carried.size() == 2;
  PullbackOptions own = options;
  own.conserve = options.conserve && !flowing;
  const GridBase::Ptr result = warped(carried, prototype, own);
  if (flowing) {
    const double t = carried[1].weight;
    const double total = (1 - t) * totalOf(*carried[0].grid) + t * totalOf(*carried[1].grid);
    carried[0].weight = -1, carried[1].weight = 1;
    takeNearerDetail(*result, *warped(carried, prototype, own), t);
    if (options.conserve) scaleToTotal(*result, total);
  }
  for (auto meta = prototype.beginMeta(); meta != prototype.endMeta(); ++meta)
    if (meta->first.compare(0, 5, "file_") != 0) result->insertMeta(meta->first, *meta->second);
  result->setSaveFloatAsHalf(half);
  if (options.dropFaint) {
    double least = half ? kLeastHalf : 0;
    double faintest = std::numeric_limits<double>::infinity();
    for (const CarriedGrid& c : carried) faintest = std::min(faintest, faintestValue(*c.grid));
    if (std::isfinite(faintest)) least = std::max(least, faintest);
    dropFainter(*result, least);
  }
  return result;
}

GridBase::Ptr Pullback::warped(const std::vector<CarriedGrid>& carried, const GridBase& prototype,
                               const PullbackOptions& options) {
  if (!carried.empty()) {
    const Transform::Ptr transform = options.voxelSize > 0
                                         ? Transform::createLinearTransform(options.voxelSize)
                                         : commonTransform(carried);
    const openvdb::CoordBBox box = boxOf(carried, impl_->carrying, *transform);
    if (!box.empty())
      return warpGrids(carried, impl_->nodesFor(box, *transform), impl_->local(), *transform,
                       options.conserve);
  }
  GridBase::Ptr empty = prototype.copyGridWithNewTree();
  empty->setTransform(prototype.transform().copy());
  return empty;
}

Image Pullback::carry(const std::vector<const Image*>& images, const ImageLattice& on,
                      const std::vector<double>& isos) const {
  const Impl& p = *impl_;
  checkCount(images.size(), "images", p.weights.size());
  if (!isos.empty()) checkCount(isos.size(), "isovalues", p.weights.size());
  checkImages(images);
  checkLattice(on);
  p.refuseRegions();
  std::vector<CarriedImage> carried;
  for (size_t k = 0; k < images.size(); ++k) {
    if (p.alone == k) return resampledTo(*images[k], on);
    const size_t shape = p.shapeOf[k];
    if (p.weights[k] > 0)
      carried.push_back({images[k], shape, p.anchors[shape], p.weights[k],
                         p.fields.empty() ? nullptr : p.fields[shape].get(), p.sizes[shape],
                         isos.empty() ? std::nullopt : std::optional<double>(isos[k])});
  }
  if (p.still() || allSame(carried)) return blendStill(carried, on);
  return warpImages(carried, imageNodes(on, p.carrying, p.imageSpacing), on);
}

Image Pullback::carryLabels(const std::vector<const LabelField*>& labels, const ImageLattice& on) const {
  const Impl& p = *impl_;
  checkCount(labels.size(), "label maps", p.weights.size());
  checkNoneIsNull(labels, "label map");
  checkLattice(on);
  p.refuseRegions();
  std::vector<CarriedLabels> carried;
  for (size_t k = 0; k < labels.size(); ++k)
    if (p.weights[k] > 0)
      carried.push_back(
          {labels[k], p.shapeOf[k], p.anchors[p.shapeOf[k]], p.weights[k] * p.sizes[p.shapeOf[k]]});
  return warpLabels(carried, imageNodes(on, p.carrying, p.imageSpacing), on);
}

openvdb::Vec3SGrid::Ptr Pullback::colors(const FloatGrid& surface,
                                         const std::vector<openvdb::Vec3SGrid::ConstPtr>& colors) {
  Impl& p = *impl_;
  checkCount(colors.size(), "grids of colours", p.weights.size());
  if (p.alone && colors[*p.alone]) return colorsAround(surface, *colors[*p.alone]);
  if (p.fields.empty())
    throw InputError("a dissolve makes no surface, so there is none whose colours it could blend");
  std::vector<CarriedColors> carried, uncounted;
  for (size_t k = 0; k < colors.size(); ++k) {
    if (!colors[k]) continue;
    const size_t shape = p.shapeOf[k];
    // If only objects without colours have weight, the colours of the others are used.
    (p.counts(k) ? carried : uncounted).push_back({colors[k], p.fields[shape].get(), shape, p.weights[k], k});
  }
  if (carried.empty()) {
    carried = std::move(uncounted);
    for (CarriedColors& c : carried) c.weight = 1;
  }
  if (carried.empty()) throw InputError("none of the objects has colours");
  const openvdb::CoordBBox box = surface.evalActiveVoxelBoundingBox();
  if (box.empty()) return openvdb::Vec3SGrid::create();
  return warpColors(surface, carried, p.nodesFor(box, surface.transform()), p.local());
}

openvdb::Vec3SGrid::Ptr Pullback::velocity(const GridBase& where, const Weights& rate,
                                           const VelocityOptions& options) const {
  const Impl& p = *impl_;
  checkRate(rate, p.weights.size());
  if (!(options.reach >= 0))
    throw InputError("velocities reach for " + std::to_string(options.reach) + "; it must be 0 or more");
  if (!(options.tolerance >= 0))
    throw InputError("the tolerance of velocities is " + std::to_string(options.tolerance) +
                     "; it must be 0 or more");
  auto result = openvdb::Vec3SGrid::create();
  result->setTransform(where.transform().copy());
  const openvdb::MaskTree::Ptr body = activeVoxels(where);
  openvdb::CoordBBox box;
  if (p.carrying.lattice && body->evalActiveVoxelBoundingBox(box)) {
    Weights shapeRate(p.shapeWeights.size(), 0);
    for (size_t k = 0; k < rate.size(); ++k) shapeRate[p.shapeOf[k]] += rate[k];
    const MovingLattice& lattice = *p.carrying.lattice;
    const MovingLattice::Pose& pose = *p.carrying.pose;
    const LatticeMotion motion = lattice.motionAt(p.shapeWeights, shapeRate, pose);
    const int step = carryingStep(box);
    VelocityFinder finder = lattice.velocityFinder(motion, pose, where.transform(), step);
    if (p.surface && p.surface->nodes.step == step && *p.surface->transform == where.transform())
      finder.knows(p.surface->nodes);
    for (const Impl::Nodes& made : p.nodes)
      if (made.map.step == step && *made.transform == where.transform()) finder.knows(made.map);
    const auto velocities = [&](const NodeMap& nodes, const std::vector<char>& wanted) {
      return finder.find(nodes, wanted);
    };
    result = velocityGrid(step, velocities, *body, where.transform(), options);
  }
  result->setName("vel");
  result->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  return result;
}

bool Pullback::Impl::still() const {
  const std::optional<size_t> shape = aloneIn(shapeWeights);
  for (size_t k = 0; k < weights.size(); ++k)
    if (weights[k] > 0 && shape != shapeOf[k]) return false;
  return !regions;
}

bool Pullback::Impl::counts(size_t object) const {
  if (weights[object] != 0) return true;
  for (size_t r = 0; regions && r < regions->count(); ++r)
    if (regions->region(r).weights[object] != 0) return true;
  return false;
}

LocalWeights Pullback::Impl::local() const { return {weights, regions.get()}; }

void Pullback::Impl::refuseRegions() const {
  if (regions)
    throw InputError("regions with weights of their own are for shapes and grids, not for in-between images");
}

const NodeMap& Pullback::Impl::nodesFor(const openvdb::CoordBBox& box, const Transform& transform) {
  const auto same =
      std::find_if(nodes.begin(), nodes.end(), [&](const Nodes& n) { return *n.transform == transform; });
  openvdb::CoordBBox all = box;
  if (same != nodes.end()) {
    if (same->box.isInside(box)) return same->map;
    all.expand(same->box);
    nodes.erase(same);
  }
  if (nodes.size() == kKeptMaps) nodes.erase(nodes.begin());
  nodes.push_back({transform.copy(), all, carryingNodes(all, carrying, transform, carryingStep(all))});
  return nodes.back().map;
}

}  // namespace slicemorph
