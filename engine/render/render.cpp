#include "engine/render/render.h"

#include "engine/volume/color_sampler.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/RayIntersector.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

namespace slicemorph {
namespace {

// Two refinements of the intersection; with none, the silhouette shows terraces one voxel deep.
using Search = openvdb::tools::LinearSearchImpl<FloatGrid, 2, double>;
using SurfaceIntersector =
    openvdb::tools::LevelSetRayIntersector<FloatGrid, Search,
                                           FloatGrid::TreeType::RootNodeType::ChildNodeType::LEVEL, ViewRay>;

Colour mix(const Colour& a, const Colour& b, float t) { return a + (b - a) * t; }
float mix(float a, float b, float t) { return a + (b - a) * t; }

/// Two directions perpendicular to a unit vector.
struct Across {
  Vec3d a, b;
  explicit Across(const Vec3d& v) {
    a = v.cross(std::abs(v.x()) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).unit();
    b = v.cross(a);
  }
};

/// Size of the key light for soft shadows, relative to its distance.
constexpr double kSpread = 0.33;

/// Everything a task needs to shade a hit. Each task needs its own, because accessors cache.
class Shader {
 public:
  Shader(const FloatGrid& grid, const ViewBasis& basis, const SurfaceIntersector& intersector,
         const RenderOptions& options, const openvdb::Vec3SGrid* colors)
      : grid_(grid),
        basis_(basis),
        intersector_(intersector),
        accessor_(grid.getConstAccessor()),
        key_(towardsLight(options, basis)),
        acrossKey_(key_),
        intensity_(float(options.intensity)),
        voxelSize_(grid.voxelSize()[0]) {
    if (colors) colors_.emplace(*colors);
  }

  /// Normal from interpolated central differences: continuous over the surface, unlike the gradient
  /// of one cell.
  Vec3d normalAt(const Vec3d& world) const {
    const Vec3d index = grid_.worldToIndex(world);
    const openvdb::Coord base = openvdb::Coord::floor(index);
    const Vec3d in = index - base.asVec3d();
    // Voxels from one before to two after the cell, without those outside of it along two axes, which
    // are not needed.
    double v[4][4][4];
    const auto row = [&](int x, int y, int first, int last) {
      constexpr int kMask = int(FloatGrid::TreeType::LeafNodeType::DIM) - 1;
      const openvdb::Coord at = base.offsetBy(x - 1, y - 1, first - 1);
      const bool within = (at.z() & kMask) + last - first <= kMask;
      const auto* leaf = within ? accessor_.probeConstLeaf(at) : nullptr;
      const float* values = leaf ? leaf->buffer().data() + leaf->coordToOffset(at) : nullptr;
      for (int z = first; z <= last; ++z)
        v[x][y][z] = values ? values[z - first] : accessor_.getValue(at.offsetBy(0, 0, z - first));
    };
    for (const int x : {1, 2})
      for (const int y : {1, 2}) row(x, y, 0, 3);
    for (const int inner : {1, 2})
      for (const int outer : {0, 3}) row(inner, outer, 1, 2), row(outer, inner, 1, 2);
    Vec3d gradient(0.0);
    for (int c = 0; c < 8; ++c) {
      const int x = 1 + (c & 1), y = 1 + (c >> 1 & 1), z = 1 + (c >> 2);
      const double weight =
          (x == 2 ? in[0] : 1 - in[0]) * (y == 2 ? in[1] : 1 - in[1]) * (z == 2 ? in[2] : 1 - in[2]);
      gradient += weight * Vec3d(v[x + 1][y][z] - v[x - 1][y][z], v[x][y + 1][z] - v[x][y - 1][z],
                                 v[x][y][z + 1] - v[x][y][z - 1]);
    }
    const Vec3d normal = grid_.transform().baseMap()->applyIJT(gradient);
    return normal.lengthSqr() > 0 ? normal.unit() : basis_.back;
  }

  /// The share of the key light visible from a point, by `rays` rays to points on the light.
  float lit(const Vec3d& world, const Vec3d& normal, int first, int rays) const {
    int free = 0;
    for (int n = 0; n < rays; ++n) {
      const openvdb::Vec2d at = samplePosition(3 * (first + n) + 1);
      const Vec3d light =
          (key_ + acrossKey_.a * (kSpread * (at.x() - 0.5)) + acrossKey_.b * (kSpread * (at.y() - 0.5)))
              .unit();
      if (normal.dot(light) <= 0) continue;
      // Starts two voxels off the surface, else the surface would shadow itself in steps at the terminator.
      free += !intersector_.intersectsWS(ViewRay(world + normal * (2 * voxelSize_), light));
    }
    return float(free) / float(rays);
  }

  /// Clay-like shading. `shines`: share of the key light that is visible.
  Colour operator()(const Vec3d& world, Vec3d normal, const Vec3d& viewDirection, float shines) const {
    const Colour albedo = albedoAt(world);
    static const Vec3d fillLight = Vec3d(0.85, 0.1, 0.5).unit(), rimLight = Vec3d(0.45, 0.6, -0.75).unit();
    if (normal.dot(viewDirection) > 0) normal -= viewDirection * normal.dot(viewDirection);
    const Vec3d toViewer = -viewDirection;
    const float open = openness(world, normal);

    const float facing = float(normal.dot(key_));
    // Shadows are not black, so that what is in them can be seen.
    const float direct = std::max(0.0f, facing) * mix(0.3f, 1.0f, shines);
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
    const float highlight = std::pow(std::max(0.0f, float(normal.dot((key_ + toViewer).unit()))), 28.0f);
    const float gloss = shines * 0.08f * intensity_ * highlight;
    return albedo * light + Colour(gloss + 0.05f * grazing * sky);
  }

 private:
  double sample(const Vec3d& index) const { return openvdb::tools::BoxSampler::sample(accessor_, index); }

  /// Colours are given in display space (gamma 2.2); as paint they are slightly darker than white paper.
  Colour albedoAt(const Vec3d& world) const {
    static const Colour clay(0.53f, 0.435f, 0.355f);
    if (!colors_) return clay;
    const std::optional<Colour> own = colors_->at(world);
    if (!own) return clay;
    Colour albedo;
    for (int i = 0; i < 3; ++i) albedo[i] = 0.85f * std::pow(std::clamp((*own)[i], 0.0f, 1.0f), 2.2f);
    return albedo;
  }

  /// How open the surface is at the scale of the narrow band: 1 open, 0 deep in a crease.
  float openness(const Vec3d& world, const Vec3d& normal) const {
    double open = 1;
    for (const double reach : {1.0, 2.2}) {
      const double seen = sample(grid_.worldToIndex(world + normal * (reach * voxelSize_))) / voxelSize_;
      open -= 0.5 * std::clamp((reach - seen) / reach, 0.0, 1.0);
    }
    return float(std::clamp(open, 0.0, 1.0));
  }

  const FloatGrid& grid_;
  const ViewBasis& basis_;
  SurfaceIntersector intersector_;
  FloatGrid::ConstAccessor accessor_;
  Vec3d key_;
  Across acrossKey_;
  float intensity_;
  double voxelSize_;
  std::optional<ColorSampler> colors_;
};

void requireRenderable(const FloatGrid& levelSet, const Camera& camera) {
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

/// The hit of a ray through a pixel.
struct Hit {
  bool there = false;
  float depth = kFarAway;
  float lit = -1;  ///< share of the key light that is visible; negative: not known yet
  Vec3d world, normal, direction;
};

/// A square part of a picture. First the centres of its pixels, and of those around it, are traced. The light
/// is traced for one pixel in four; where these agree, pixels in between take the same value. Pixels get more
/// rays only where the shape ends or turns sharply in them, or a shadow's edge crosses them.
class Part {
 public:
  static constexpr int kSize = 64;

  Part(int column, int row, Film& film, const CameraRays& rays, const RenderOptions& options,
       const SurfaceIntersector& intersector, const Shader& shader)
      : film_(film),
        rays_(rays),
        options_(options),
        intersector_(intersector),
        shader_(shader),
        left_(column),
        top_(row),
        right_(std::min(column + kSize, options.width)),
        bottom_(std::min(row + kSize, options.height)),
        hits_(kStride * kStride) {}

  void draw() {
    const int around = options_.samples > 1 ? 1 : 0;
    for (int y = top_ - around; y < bottom_ + around; ++y)
      for (int x = left_ - around; x < right_ + around; ++x) at(x, y) = look(x, y, 0);
    for (int y = top_; y <= bottom_; y += 2)
      for (int x = left_; x <= right_; x += 2) light(at(x, y));
    for (int y = top_; y < bottom_; ++y)
      for (int x = left_; x < right_; ++x)
        if (Hit& hit = at(x, y); hit.there && hit.lit < 0) hit.lit = litBetween(x, y);
    for (int y = top_; y < bottom_; ++y)
      for (int x = left_; x < right_; ++x) film_.set(x, y, pixel(x, y));
  }

 private:
  static constexpr int kStride = kSize + 2;
  /// Neighbours whose normals have a smaller cosine (18 degrees) count as different parts of the surface.
  static constexpr double kSmooth = 0.95;

  Hit& at(int x, int y) { return hits_[size_t((y - top_ + 1) * kStride + x - left_ + 1)]; }

  Hit look(int x, int y, int sample) const {
    const openvdb::Vec2d position = film_.position(x, y, sample);
    const ViewRay ray = rays_(position.x(), position.y());
    Hit hit;
    hit.there = intersector_.intersectsWS(ray, hit.world);
    if (!hit.there) return hit;
    hit.depth = float(rays_.depth(hit.world));
    hit.normal = shader_.normalAt(hit.world);
    hit.direction = ray.dir();
    return hit;
  }

  void light(Hit& hit) const {
    if (hit.there) hit.lit = shader_.lit(hit.world, hit.normal, 0, options_.samples);
  }

  bool alike(const Hit& a, const Hit& b) const {
    if (a.there != b.there) return false;
    if (!a.there) return true;
    // Within 30 degrees of the tangent plane from each other, which allows for grazing views.
    return a.normal.dot(b.normal) > kSmooth &&
           std::abs((a.world - b.world).dot(a.normal)) < 0.5 * std::abs((a.world - b.world).length());
  }

  float litBetween(int x, int y) {
    const int x0 = x - ((x - left_) & 1), y0 = y - ((y - top_) & 1);
    Hit& hit = at(x, y);
    float lit = -1;
    for (const int cy : {y0, y0 + ((y - top_) & 1) * 2})
      for (const int cx : {x0, x0 + ((x - left_) & 1) * 2}) {
        const bool known = cx <= right_ && cy <= bottom_ && at(cx, cy).lit >= 0;
        if (!known || !alike(hit, at(cx, cy)) || (lit >= 0 && lit != at(cx, cy).lit))
          return light(hit), hit.lit;
        lit = at(cx, cy).lit;
      }
    if (lit > 0 && lit < 1) light(hit), lit = hit.lit;
    return lit;
  }

  bool needsMore(int x, int y) {
    const Hit& hit = at(x, y);
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
      if (!alike(hit, at(x + dx, y + dy))) return true;
    // Shadows have soft edges; only the steep ones of nearby objects need more rays.
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {0, -1}})
      if (hit.there && x + dx >= left_ && y + dy >= top_ && std::abs(hit.lit - at(x + dx, y + dy).lit) > 0.5)
        return true;
    return false;
  }

  Pixel pixel(int x, int y) {
    const Hit& middle = at(x, y);
    Pixel pixel;
    int hits = 0, samples = 1;
    const auto add = [&](const Hit& hit) {
      if (!hit.there) return;
      if (hits++ == 0) pixel.depth = hit.depth, pixel.normal = Colour(hit.normal);
      pixel.colour += shader_(hit.world, hit.normal, hit.direction, hit.lit);
    };
    add(middle);
    if (options_.samples > 1 && needsMore(x, y)) {
      samples = options_.samples;
      for (int n = 1; n < samples; ++n) {
        Hit hit = look(x, y, n);
        if (hit.there) hit.lit = shader_.lit(hit.world, hit.normal, n, 1);
        add(hit);
      }
    }
    pixel.colour /= float(samples);
    pixel.cover = float(hits) / float(samples);
    return pixel;
  }

  Film& film_;
  const CameraRays& rays_;
  const RenderOptions& options_;
  SurfaceIntersector intersector_;  ///< a copy, because it caches
  const Shader& shader_;
  int left_, top_, right_, bottom_;
  std::vector<Hit> hits_;
};

}  // namespace

openvdb::BBoxd surfaceBox(const FloatGrid& levelSet) {
  const openvdb::tree::LeafManager<const openvdb::FloatTree> leaves(levelSet.tree());
  openvdb::CoordBBox box = tbb::parallel_reduce(
      leaves.leafRange(32), openvdb::CoordBBox(),
      [](const auto& range, openvdb::CoordBBox part) {
        for (auto leaf = range.begin(); leaf; ++leaf)
          for (auto value = leaf->cbeginValueOn(); value; ++value)
            if (*value < 0) part.expand(value.getCoord());
        return part;
      },
      [](openvdb::CoordBBox a, const openvdb::CoordBBox& b) {
        a.expand(b);
        return a;
      });
  auto tile = levelSet.cbeginValueOn();
  for (tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1); tile; ++tile)
    if (*tile < 0) box.expand(tile.getBoundingBox());
  if (box.empty())
    throw GeometryError("grid \"" + levelSet.getName() + "\" has no inside: there is nothing to see");
  const openvdb::BBoxd index(box.min().asVec3d() - Vec3d(1.0), box.max().asVec3d() + Vec3d(1.0));
  return levelSet.transform().indexToWorld(index);
}

Picture renderSurface(const FloatGrid& levelSet, const Camera& camera, const RenderOptions& options,
                      const openvdb::Vec3SGrid* colors) {
  Film film(camera, options);
  requireRenderable(levelSet, camera);
  const openvdb::CoordBBox active = levelSet.evalActiveVoxelBoundingBox();
  const openvdb::BBoxd box = levelSet.empty() ? openvdb::BBoxd() : levelSet.transform().indexToWorld(active);
  const CameraRays rays(camera, double(options.width) / options.height, box);
  if (levelSet.empty()) {
    for (int row = 0; row < options.height; ++row)
      for (int column = 0; column < options.width; ++column) film.set(column, row, Pixel());
    return film.take();
  }
  const SurfaceIntersector intersector(levelSet);
  const int across = (options.width + Part::kSize - 1) / Part::kSize,
            down = (options.height + Part::kSize - 1) / Part::kSize;
  tbb::parallel_for(
      tbb::blocked_range<int>(0, across * down, 1),
      [&](const tbb::blocked_range<int>& range) {
        const Shader shader(levelSet, rays.basis(), intersector, options, colors);
        for (int n = range.begin(); n < range.end(); ++n)
          Part(n % across * Part::kSize, n / across * Part::kSize, film, rays, options, intersector, shader)
              .draw();
      },
      tbb::simple_partitioner());
  return film.take();
}

}  // namespace slicemorph
