#include "engine/render/render_fog.h"

#include "engine/render/black_body.h"
#include "engine/render/light_field.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/RayIntersector.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace slicemorph {
namespace {

using openvdb::BoolGrid;
using openvdb::tools::BoxSampler;
using FogIntersector =
    openvdb::tools::VolumeRayIntersector<BoolGrid, BoolGrid::TreeType::RootNodeType::ChildNodeType::LEVEL,
                                         ViewRay>;

constexpr double kHottestKelvin = 2200;  ///< colour temperature of the largest heat, an orange flame
/// Optical depth of the thickest fog of a sequence: e^-4, so 2 % of the light behind it is seen.
constexpr double kOpaque = 4;
/// Light that the thickest fog emits along a ray through it where it is hottest.
constexpr double kGlow = 6;
/// Rays end where less than this share of the background is visible.
constexpr double kUnseen = 1e-3;

void checkLinear(const openvdb::GridBase::ConstPtr& grid) {
  if (grid && !grid->transform().isLinear())
    throw InputError("grid \"" + grid->getName() + "\": its transform is no linear one; resample it first");
}

void requireFog(const Fog& fog) {
  checkLinear(fog.density);
  checkLinear(fog.heat);
  checkLinear(fog.colour);
}

/// Calls `visit` with boxes that contain all active voxels: one per leaf and one per tile.
template <typename Visit>
void visitActive(const FloatGrid& grid, const Visit& visit) {
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    openvdb::CoordBBox box;
    leaf->evalActiveBoundingBox(box);
    if (!box.empty()) visit(box);
  }
  auto tile = grid.tree().cbeginValueOn();
  for (tile.setMaxDepth(FloatGrid::TreeType::ValueOnCIter::LEAF_DEPTH - 1); tile; ++tile)
    visit(tile.getBoundingBox());
}

/// A mask, on the density's voxels, of where density or heat may be found.
BoolGrid::Ptr occupiedVoxels(const Fog& fog) {
  BoolGrid::Ptr occupied = BoolGrid::create(false);
  for (const FloatGrid::ConstPtr& grid : {fog.density, fog.heat}) {
    if (!grid) continue;
    visitActive(*grid, [&](const openvdb::CoordBBox& box) {
      const openvdb::BBoxd world = grid->transform().indexToWorld(box);
      // Interpolated values reach one voxel further.
      openvdb::CoordBBox reached = fog.density->transform().worldToIndexNodeCentered(world);
      reached.expand(1);
      occupied->sparseFill(reached, true);
    });
  }
  return occupied;
}

/// Sums of values and of their squares over the active voxels, added in the order of the leaves.
struct Sums {
  double values = 0, squares = 0;
};

Sums sumsOf(const FloatGrid& grid) {
  Sums sums;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    const double value = std::max(0.0f, *it), count = double(it.getVoxelCount());
    sums.values += count * value;
    sums.squares += count * value * value;
  }
  return sums;
}

/// The glow at a share of the largest heat: black-body colour times the fourth power of
/// the share (Stefan-Boltzmann).
class GlowTable {
 public:
  GlowTable() {
    for (size_t n = 0; n < kSteps; ++n) {
      const double heat = double(n) / (kSteps - 1);
      colours_[n] = blackBody(std::max(500.0, heat * kHottestKelvin)) * float(std::pow(heat, 4));
    }
  }
  Colour at(double heat) const {
    return colours_[size_t(std::floor(std::clamp(heat, 0.0, 1.0) * (kSteps - 1) + 0.5))];
  }

 private:
  static constexpr size_t kSteps = 1024;
  Colour colours_[kSteps];
};

/// Shared by all tasks.
struct Scene {
  const Fog& fog;
  const FogLook& look;
  CameraRays rays;
  FogIntersector intersector;
  std::optional<LightField> key, sky;  // not set if there is no density to be lit
  GlowTable glow;
  Colour keyColour, skyColour, groundColour;
};

/// Marches along rays. Each task needs its own, because accessors cache.
class Walker {
 public:
  explicit Walker(const Scene& scene)
      : scene_(scene), intersector_(scene.intersector), density_(scene.fog.density->getConstAccessor()) {
    if (scene.fog.heat) heat_.emplace(scene.fog.heat->getConstAccessor());
    if (scene.fog.colour) colour_.emplace(scene.fog.colour->getConstAccessor());
  }

  /// Adds what one ray meets: colour, coverage, and depth times coverage.
  void add(const ViewRay& ray, Pixel& pixel) {
    const auto& map = *scene_.fog.density->transform().baseMap();
    const Vec3d along = map.applyInverseJacobian(ray.dir());
    const double voxels = along.length();  // per world unit along the ray
    seen_ = 1;
    if (!intersector_.setIndexRay(ViewRay(map.applyInverseMap(ray.eye()), along / voxels))) return;
    double from = 0, to = 0;
    while (seen_ > kUnseen && intersector_.march(from, to)) {
      const int steps = std::max(1, int(std::ceil(to - from)));
      const double step = (to - from) / steps;
      for (int n = 0; n < steps && seen_ > kUnseen; ++n) {
        const double t = from + (n + 0.5) * step;
        meet(intersector_.getIndexPos(t), ray(t / voxels), step / voxels, pixel);
      }
    }
    pixel.cover += float(1 - seen_);
  }

 private:
  void meet(const Vec3d& index, const Vec3d& world, double length, Pixel& pixel) {
    const double density = std::max(0.0f, BoxSampler::sample(density_, index));
    const double thickness = density * scene_.look.extinction * length;
    const double stopped = seen_ * -std::expm1(-thickness);
    if (stopped > 0) {
      pixel.colour += lightAt(world) * float(stopped);
      pixel.depth += float(stopped * scene_.rays.depth(world));
    }
    if (heat_ && scene_.look.hottest > 0) {
      const double heat =
          BoxSampler::sample(*heat_, scene_.fog.heat->worldToIndex(world)) / scene_.look.hottest;
      if (heat > 0) pixel.colour += scene_.glow.at(heat) * float(scene_.look.emission * seen_ * length);
    }
    seen_ -= stopped;
  }

  Colour lightAt(const Vec3d& world) const {
    Colour albedo = scene_.look.albedo;
    if (colour_) albedo *= BoxSampler::sample(*colour_, scene_.fog.colour->worldToIndex(world));
    return albedo * (scene_.keyColour * scene_.key->at(world) + scene_.skyColour * scene_.sky->at(world) +
                     scene_.groundColour);
  }

  const Scene& scene_;
  FogIntersector intersector_;
  FloatGrid::ConstAccessor density_;
  std::optional<FloatGrid::ConstAccessor> heat_;
  std::optional<openvdb::Vec3SGrid::ConstAccessor> colour_;
  double seen_ = 1;  // visible share of what is behind
};

Pixel pixelAt(int column, int row, const Film& film, const Scene& scene, int samples, Walker& walker) {
  Pixel pixel;
  pixel.depth = 0;
  for (int n = 0; n < samples; ++n) {
    const openvdb::Vec2d at = film.position(column, row, n);
    walker.add(scene.rays(at.x(), at.y()), pixel);
  }
  pixel.depth = pixel.cover > 0 ? pixel.depth / pixel.cover : kFarAway;
  pixel.colour /= float(samples);
  pixel.cover /= float(samples);
  return pixel;
}

}  // namespace

FogMeasure measureFog(const Fog& fog) {
  requireFog(fog);
  FogMeasure measure;
  for (const FloatGrid::ConstPtr& grid : {fog.density, fog.heat}) {
    if (!grid || grid->activeVoxelCount() == 0) continue;
    const openvdb::BBoxd box = grid->transform().indexToWorld(grid->evalActiveVoxelBoundingBox());
    measure.box.expand(box);
  }
  const Sums sums = sumsOf(*fog.density);
  if (sums.values > 0) {
    measure.density = sums.squares / sums.values;
    measure.thickness = std::cbrt(sums.values / measure.density * fog.density->transform().voxelVolume());
  }
  if (fog.heat)
    for (auto it = fog.heat->cbeginValueOn(); it; ++it)
      measure.hottest = std::max(measure.hottest, double(*it));
  return measure;
}

FogLook lookOf(const std::vector<FogMeasure>& measures) {
  FogLook look;
  double most = 0, thickest = 0;
  for (const FogMeasure& measure : measures) {
    most = std::max(most, measure.density * measure.thickness);
    thickest = std::max(thickest, measure.thickness);
    look.hottest = std::max(look.hottest, measure.hottest);
  }
  if (most > 0) look.extinction = kOpaque / most;
  if (thickest > 0) look.emission = kGlow / thickest;
  return look;
}

Picture renderFog(const Fog& fog, const FogLook& look, const Camera& camera, const RenderOptions& options) {
  Film film(camera, options);
  requireFog(fog);
  const BoolGrid::Ptr occupied = occupiedVoxels(fog);
  if (occupied->empty()) {
    for (int row = 0; row < options.height; ++row)
      for (int column = 0; column < options.width; ++column) film.set(column, row, Pixel());
    return film.take();
  }
  const CameraRays rays(camera, double(options.width) / options.height,
                        fog.density->transform().indexToWorld(occupied->evalActiveVoxelBoundingBox()));
  Scene scene{fog, look, rays, FogIntersector(*occupied, /*dilate=*/0), {}, {}, {}, {}, {}, {}};
  if (fog.density->activeVoxelCount() > 0) {
    scene.key.emplace(*fog.density, towardsLight(options, rays.basis()), look.extinction);
    scene.sky.emplace(*fog.density, camera.up.unit(), look.extinction);
  }
  scene.keyColour = Colour(1.25f, 1.19f, 1.1f) * float(options.intensity);
  scene.skyColour = Colour(0.13f, 0.155f, 0.20f);
  scene.groundColour = Colour(0.035f, 0.032f, 0.03f);
  constexpr int kRowsATask = 4;  // few, because fog is unevenly distributed over the rows
  tbb::parallel_for(
      tbb::blocked_range<int>(0, options.height, kRowsATask),
      [&](const tbb::blocked_range<int>& range) {
        Walker walker(scene);
        for (int row = range.begin(); row < range.end(); ++row)
          for (int column = 0; column < options.width; ++column)
            film.set(column, row, pixelAt(column, row, film, scene, options.samples, walker));
      },
      tbb::simple_partitioner());
  return film.take();
}

}  // namespace slicemorph
