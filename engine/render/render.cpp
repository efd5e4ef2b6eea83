#include "engine/render/render.h"

#include "engine/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/RayIntersector.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace slicemorph {
namespace {

// Two refinements of the crossing: with none, the silhouette of one voxel shows as terraces.
using Search = openvdb::tools::LinearSearchImpl<FloatGrid, 2, double>;
using Intersector =
    openvdb::tools::LevelSetRayIntersector<FloatGrid, Search,
                                           FloatGrid::TreeType::RootNodeType::ChildNodeType::LEVEL, ViewRay>;

Colour mix(const Colour& a, const Colour& b, float t) { return a + (b - a) * t; }
float mix(float a, float b, float t) { return a + (b - a) * t; }

/// Two directions across a unit vector.
struct Across {
  Vec3d a, b;
  explicit Across(const Vec3d& v) {
    a = v.cross(std::abs(v.x()) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).unit();
    b = v.cross(a);
  }
};

/// Everything a task needs to colour a hit; its caches are not shared.
class Shader {
 public:
  Shader(const FloatGrid& grid, const ViewBasis& basis, const Intersector& intersector,
         const RenderOptions& options)
      : grid_(grid),
        basis_(basis),
        intersector_(intersector),
        accessor_(grid.getConstAccessor()),
        key_(towardsLight(options, basis)),
        acrossKey_(key_),
        intensity_(float(options.intensity)),
        voxelSize_(grid.voxelSize()[0]) {}

  /// Central differences, interpolated: continuous over the surface, unlike the gradient of one cell.
  Vec3d normalAt(const Vec3d& world) const {
    const Vec3d index = grid_.worldToIndex(world);
    Vec3d gradient;
    for (int a = 0; a < 3; ++a) {
      Vec3d step(0.0);
      step[a] = 1;
      gradient[a] = sample(index + step) - sample(index - step);
    }
    const Vec3d normal = grid_.transform().baseMap()->applyIJT(gradient);
    return normal.lengthSqr() > 0 ? normal.unit() : basis_.back;
  }

  /// Clay. `lightSample`: where on the key light, in the unit square.
  Colour operator()(const Vec3d& world, Vec3d normal, const Vec3d& viewDirection,
                    const openvdb::Vec2d& lightSample) {
    static const Colour albedo(0.53f, 0.435f, 0.355f);
    static const Vec3d fillLight = Vec3d(0.85, 0.1, 0.5).unit(), rimLight = Vec3d(0.45, 0.6, -0.75).unit();
    if (normal.dot(viewDirection) > 0) normal -= viewDirection * normal.dot(viewDirection);
    const Vec3d toViewer = -viewDirection;
    const double spread = 0.33;  // of the key light, for soft shadows
    const Vec3d key = (key_ + acrossKey_.a * (spread * (lightSample.x() - 0.5)) +
                       acrossKey_.b * (spread * (lightSample.y() - 0.5)))
                          .unit();
    const float open = openness(world, normal);

    const float facing = float(normal.dot(key));
    // Shadows are not black: what lies in them must be seen too.
    const bool shines = facing > 0 && lit(world, normal, key);
    const float direct = std::max(0.0f, facing) * (shines ? 1.0f : 0.3f);
    const float wrapped = std::max(0.0f, (facing + 0.4f) / 1.4f);
    const float fill = std::max(0.0f, float(normal.dot(basis_.toWorld(fillLight)) + 0.35) / 1.35f);
    const float grazing = std::pow(1 - std::max(0.0f, float(normal.dot(toViewer))), 3.0f);
    const float rim = std::max(0.0f, float(normal.dot(basis_.toWorld(rimLight)))) * (0.25f + 0.75f * grazing);
    const float sky = float(0.5 + 0.5 * normal.dot(basis_.up));

    Colour light =
        mix(Colour(0.12f, 0.105f, 0.095f), Colour(0.18f, 0.20f, 0.235f), sky) * mix(0.45f, 1.0f, open);
    light +=
        Colour(1.0f, 0.94f, 0.86f) * intensity_ * (1.12f * direct + 0.06f * wrapped) * mix(0.7f, 1.0f, open);
    light += Colour(0.55f, 0.66f, 0.85f) * (0.2f * fill) * mix(0.6f, 1.0f, open);
    light += Colour(0.9f, 0.95f, 1.0f) * (0.5f * rim);
    const float highlight = std::pow(std::max(0.0f, float(normal.dot((key + toViewer).unit()))), 28.0f);
    const float gloss = shines ? 0.08f * intensity_ * highlight : 0.0f;
    return albedo * light + Colour(gloss + 0.05f * grazing * sky);
  }

 private:
  double sample(const Vec3d& index) const { return openvdb::tools::BoxSampler::sample(accessor_, index); }

  /// How open the surface is at the scale of the narrow band: 1 open, 0 deep in a crease.
  float openness(const Vec3d& world, const Vec3d& normal) const {
    double open = 1;
    for (const double reach : {1.0, 2.2}) {
      const double seen = sample(grid_.worldToIndex(world + normal * (reach * voxelSize_))) / voxelSize_;
      open -= 0.5 * std::clamp((reach - seen) / reach, 0.0, 1.0);
    }
    return float(std::clamp(open, 0.0, 1.0));
  }

  bool lit(const Vec3d& world, const Vec3d& normal, const Vec3d& light) {
    // Two voxels off the surface, else it shadows itself in steps at the terminator.
    return !intersector_.intersectsWS(ViewRay(world + normal * (2 * voxelSize_), light));
  }

  const FloatGrid& grid_;
  const ViewBasis& basis_;
  Intersector intersector_;
  FloatGrid::ConstAccessor accessor_;
  Vec3d key_;
  Across acrossKey_;
  float intensity_;
  double voxelSize_;
};

void check(const FloatGrid& levelSet, const Camera& camera) {
  if (levelSet.getGridClass() != openvdb::GRID_LEVEL_SET || !levelSet.hasUniformVoxels()) {
    throw InputError("grid \"" + levelSet.getName() +
                     "\": only level sets with cubic voxels can be drawn; convert it first");
  }
  if (camera.orthographicHeight > 0) return;
  const Vec3d index = levelSet.worldToIndex(camera.position);
  if (levelSet.tree().getValue(openvdb::Coord::round(index)) < 0) {
    std::ostringstream message;
    const openvdb::BBoxd box = surfaceBox(levelSet);
    message << "camera: " << camera.position
            << " lies inside the surface; it must be outside, for example beyond " << box.min() << " to "
            << box.max();
    throw InputError(message.str());
  }
}

Pixel pixelAt(int column, int row, const Film& film, const CameraRays& rays, const RenderOptions& options,
              const Intersector& intersector, Shader& shader) {
  Pixel pixel;
  int hits = 0;
  for (int n = 0; n < options.samples; ++n) {
    const openvdb::Vec2d at = film.place(column, row, n);
    const ViewRay ray = rays(at.x(), at.y());
    Vec3d world;
    if (!intersector.intersectsWS(ray, world)) continue;
    const Vec3d normal = shader.normalAt(world);
    if (hits++ == 0) pixel.depth = float(rays.depth(world)), pixel.normal = Colour(normal);
    pixel.colour += shader(world, normal, ray.dir(), samplePosition(3 * n + 1));
  }
  pixel.colour /= float(options.samples);
  pixel.cover = float(hits) / float(options.samples);
  return pixel;
}

}  // namespace

openvdb::BBoxd surfaceBox(const FloatGrid& levelSet) {
  openvdb::CoordBBox box;
  for (auto it = levelSet.cbeginValueOn(); it; ++it) {
    if (*it >= 0) continue;
    if (it.isVoxelValue()) {
      box.expand(it.getCoord());
    } else {
      box.expand(it.getBoundingBox());
    }
  }
  if (box.empty())
    throw GeometryError("grid \"" + levelSet.getName() + "\" has no inside: there is nothing to see");
  const openvdb::BBoxd index(box.min().asVec3d() - Vec3d(1.0), box.max().asVec3d() + Vec3d(1.0));
  return levelSet.transform().indexToWorld(index);
}

Picture renderSurface(const FloatGrid& levelSet, const Camera& camera, const RenderOptions& options) {
  Film film(options);
  check(levelSet, camera);
  const openvdb::CoordBBox active = levelSet.evalActiveVoxelBoundingBox();
  const openvdb::BBoxd box = levelSet.empty() ? openvdb::BBoxd() : levelSet.transform().indexToWorld(active);
  const CameraRays rays(camera, double(options.width) / options.height, box);
  if (levelSet.empty()) {
    for (int row = 0; row < options.height; ++row)
      for (int column = 0; column < options.width; ++column) film.set(column, row, Pixel());
    return film.take();
  }
  const Intersector original(levelSet);
  constexpr int kRowsATask = 8;
  tbb::parallel_for(
      tbb::blocked_range<int>(0, options.height, kRowsATask),
      [&](const tbb::blocked_range<int>& range) {
        const Intersector intersector(original);
        Shader shader(levelSet, rays.basis(), original, options);
        for (int row = range.begin(); row < range.end(); ++row)
          for (int column = 0; column < options.width; ++column)
            film.set(column, row, pixelAt(column, row, film, rays, options, intersector, shader));
      },
      tbb::simple_partitioner());
  return film.take();
}

}  // namespace slicemorph
