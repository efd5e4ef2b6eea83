#include "engine/render/render.h"

#include "engine/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/RayTracer.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;

using Ray = openvdb::math::Ray<double>;
// Two refinements of the crossing: with none, the silhouette of one voxel shows as terraces.
using Search = openvdb::tools::LinearSearchImpl<FloatGrid, 2, double>;
using Intersector =
    openvdb::tools::LevelSetRayIntersector<FloatGrid, Search,
                                           FloatGrid::TreeType::RootNodeType::ChildNodeType::LEVEL, Ray>;

/// Right, up and backwards (towards the viewer): a right-handed orthonormal set.
struct Basis {
  Vec3d right, up, back;
  Vec3d toWorld(const Vec3d& v) const { return right * v.x() + up * v.y() + back * v.z(); }
};

Basis basisOf(const Vec3d& direction, const Vec3d& up, const char* who) {
  const Vec3d side = direction.cross(up);
  if (!(side.length() > 1e-6 * direction.length() * up.length())) {
    throw InputError(std::string(who) + ": the direction of view must not be zero or along `up`");
  }
  Basis basis;
  basis.back = -direction.unit();
  basis.right = side.unit();
  basis.up = basis.back.cross(basis.right);
  return basis;
}

/// Turns a picture position (-1..1 across and up, at the picture's own aspect) into a ray.
class RayMaker {
 public:
  RayMaker(const Camera& camera, double aspect, double depth)
      : basis_(basisOf(camera.target - camera.position, camera.up, "camera")), eye_(camera.position) {
    orthographic_ = camera.orthographicHeight > 0;
    const double half =
        orthographic_ ? camera.orthographicHeight / 2 : std::tan(camera.verticalFov * kPi / 360);
    across_ = basis_.right * (half * aspect);
    upwards_ = basis_.up * half;
    // An orthographic camera has no near side: start behind everything.
    if (orthographic_) eye_ += basis_.back * depth;
  }

  Ray operator()(double x, double y) const {
    const Vec3d offset = across_ * x + upwards_ * y;
    if (orthographic_) return Ray(eye_ + offset, -basis_.back);
    return Ray(eye_, (offset - basis_.back).unit());
  }

  const Basis& basis() const { return basis_; }

 private:
  Basis basis_;
  Vec3d eye_, across_, upwards_;
  bool orthographic_ = false;
};

/// Positions in the unit square: the R2 sequence, even at any length (Roberts 2018).
openvdb::Vec2d samplePosition(int n) {
  const double x = 0.5 + 0.7548776662466927 * n, y = 0.5 + 0.5698402909980532 * n;
  return {x - std::floor(x), y - std::floor(y)};
}

using Colour = openvdb::Vec3s;

float mix(float a, float b, float t) { return a + (b - a) * t; }
Colour mix(const Colour& a, const Colour& b, float t) { return a + (b - a) * t; }

/// Darker above, lighter below, a little darker in the corners. `x`, `y` in -1..1.
Colour backgroundAt(double x, double y) {
  const float t = float(0.5 - 0.5 * y);
  const float smooth = t * t * (3 - 2 * t);
  const float grey = mix(0.045f, 0.26f, smooth) * float(1 - 0.12 * (x * x + 0.5 * y * y));
  return Colour(grey * 0.97f, grey, grey * 1.04f);
}

/// Everything a task needs to colour a hit; its caches are not shared.
class Shader {
 public:
  Shader(const FloatGrid& grid, const Basis& basis, const Intersector& intersector, Shading shading)
      : grid_(grid),
        basis_(basis),
        intersector_(intersector),
        accessor_(grid.getConstAccessor()),
        shading_(shading) {
    voxelSize_ = grid.voxelSize()[0];
  }

  Colour operator()(const Vec3d& world, const Vec3d& viewDirection, const openvdb::Vec2d& lightSample) {
    Vec3d normal = normalAt(grid_.worldToIndex(world));
    if (shading_ == Shading::kNormals) return Colour(normal * 0.5 + Vec3d(0.5));
    if (normal.dot(viewDirection) > 0) normal -= viewDirection * normal.dot(viewDirection);
    return clay(world, normal, -viewDirection, lightSample);
  }

 private:
  double sample(const Vec3d& index) const { return openvdb::tools::BoxSampler::sample(accessor_, index); }

  /// Central differences, interpolated: continuous over the surface, unlike the gradient of one cell.
  Vec3d normalAt(const Vec3d& index) const {
    Vec3d gradient;
    for (int a = 0; a < 3; ++a) {
      Vec3d step(0.0);
      step[a] = 1;
      gradient[a] = sample(index + step) - sample(index - step);
    }
    const Vec3d world = grid_.transform().baseMap()->applyIJT(gradient);
    return world.lengthSqr() > 0 ? world.unit() : basis_.back;
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

  bool lit(const Vec3d& world, const Vec3d& normal, const Vec3d& light) {
    // Two voxels off the surface, else it shadows itself in steps at the terminator.
    return !intersector_.intersectsWS(Ray(world + normal * (2 * voxelSize_), light));
  }

  Colour clay(const Vec3d& world, const Vec3d& normal, const Vec3d& toViewer,
              const openvdb::Vec2d& lightSample) {
    static const Colour albedo(0.53f, 0.435f, 0.355f);
    static const Vec3d fillLight = Vec3d(0.85, 0.1, 0.5).unit(), rimLight = Vec3d(0.45, 0.6, -0.75).unit();
    const double spread = 0.4;  // of the key light, for soft shadows
    const Vec3d keyLight =
        Vec3d(-0.8 + spread * (lightSample.x() - 0.5), 0.75 + spread * (lightSample.y() - 0.5), 0.5).unit();
    const Vec3d key = basis_.toWorld(keyLight);
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
    light += Colour(1.0f, 0.94f, 0.86f) * (1.12f * direct + 0.06f * wrapped) * mix(0.7f, 1.0f, open);
    light += Colour(0.55f, 0.66f, 0.85f) * (0.2f * fill) * mix(0.6f, 1.0f, open);
    light += Colour(0.9f, 0.95f, 1.0f) * (0.5f * rim);
    const float highlight = std::pow(std::max(0.0f, float(normal.dot((key + toViewer).unit()))), 28.0f);
    const float gloss = shines ? 0.08f * highlight : 0.0f;
    return albedo * light + Colour(gloss + 0.05f * grazing * sky);
  }

  const FloatGrid& grid_;
  const Basis& basis_;
  Intersector intersector_;
  FloatGrid::ConstAccessor accessor_;
  Shading shading_;
  double voxelSize_ = 1;
};

void check(const FloatGrid& levelSet, const RenderOptions& options) {
  for (const int side : {options.width, options.height}) {
    if (side < 1 || side > 16384) {
      throw InputError("picture size " + std::to_string(options.width) + " x " +
                       std::to_string(options.height) + ": width and height must be 1 to 16384 pixels");
    }
  }
  if (options.samples < 1 || options.samples > 64) {
    throw InputError("samples " + std::to_string(options.samples) + ": must be 1 to 64 a pixel");
  }
  if (levelSet.getGridClass() != openvdb::GRID_LEVEL_SET || !levelSet.hasUniformVoxels()) {
    throw InputError("grid \"" + levelSet.getName() +
                     "\": only level sets with cubic voxels can be drawn; convert it first");
  }
}

/// The pixels of a few rows; each task writes only its own.
class RowPainter {
 public:
  RowPainter(const RayMaker& rays, const RenderOptions& options) : rays_(rays), options_(options) {}

  void paint(Picture& image, int row, const Intersector* intersector, Shader* shader) const {
    float* out = &image.rgba[size_t(4) * row * image.width];
    for (int column = 0; column < image.width; ++column, out += 4) {
      const openvdb::Vec4s pixel = colourOf(column, row, intersector, shader);
      std::copy(pixel.asPointer(), pixel.asPointer() + 4, out);
    }
  }

 private:
  openvdb::Vec4s colourOf(int column, int row, const Intersector* intersector, Shader* shader) const {
    Colour sum(0.0f);
    int hits = 0;
    for (int n = 0; intersector && n < options_.samples; ++n) {
      const openvdb::Vec2d at = samplePosition(n);
      const Ray ray =
          rays_(2 * (column + at.x()) / options_.width - 1, 1 - 2 * (row + at.y()) / options_.height);
      Vec3d world;
      if (!intersector->intersectsWS(ray, world)) continue;
      ++hits;
      sum += (*shader)(world, ray.dir(), samplePosition(3 * n + 1));
    }
    const float cover = float(hits) / float(options_.samples);
    Colour colour = sum / float(options_.samples);
    if (!options_.background) return {colour[0], colour[1], colour[2], cover};
    colour += backgroundAt(2 * (column + 0.5) / options_.width - 1, 1 - 2 * (row + 0.5) / options_.height) *
              (1 - cover);
    return {colour[0], colour[1], colour[2], 1.0f};
  }

  const RayMaker& rays_;
  const RenderOptions& options_;
};

std::vector<Vec3d> cornersOf(const std::vector<openvdb::BBoxd>& boxes) {
  std::vector<Vec3d> corners;
  for (const auto& box : boxes) {
    if (box.empty()) throw InputError("camera: a box to be seen is empty");
    for (int n = 0; n < 8; ++n) {
      corners.emplace_back((n & 1 ? box.max() : box.min()).x(), (n & 2 ? box.max() : box.min()).y(),
                           (n & 4 ? box.max() : box.min()).z());
    }
  }
  if (corners.empty()) throw InputError("camera: no box to be seen");
  return corners;
}

/// Middle of the points' box along the basis, and half its size.
struct Extent {
  Vec3d middle, half;
};

Extent extentAlong(const std::vector<Vec3d>& points, const Basis& basis) {
  Vec3d lo(std::numeric_limits<double>::max()), hi(-std::numeric_limits<double>::max());
  for (const Vec3d& p : points) {
    const Vec3d local(p.dot(basis.right), p.dot(basis.up), p.dot(basis.back));
    lo = openvdb::math::minComponent(lo, local);
    hi = openvdb::math::maxComponent(hi, local);
  }
  return {basis.toWorld((lo + hi) / 2), (hi - lo) / 2};
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

Camera frameAll(const std::vector<openvdb::BBoxd>& boxes, const FrameAllOptions& options) {
  const std::vector<Vec3d> corners = cornersOf(boxes);
  const Basis basis = basisOf(options.direction, options.up, "camera");
  if (!(options.aspect > 0) || !(options.margin >= 0 && options.margin < 0.5)) {
    throw InputError("camera: the aspect must be above 0 and the margin 0 to 0.5");
  }
  const Extent extent = extentAlong(corners, basis);
  const double share = 1 - 2 * options.margin;
  const double radius = std::max(extent.half.length(), std::numeric_limits<double>::min());

  Camera camera;
  camera.target = extent.middle;
  camera.up = options.up;
  if (!(options.verticalFov > 0)) {
    camera.orthographicHeight = 2 * std::max(extent.half.y(), extent.half.x() / options.aspect) / share;
    camera.position = camera.target + basis.back * (2 * radius);
    return camera;
  }
  camera.verticalFov = options.verticalFov;
  const double tanUp = std::tan(options.verticalFov * kPi / 360) * share, tanAcross = tanUp * options.aspect;
  double distance = 0;
  for (const Vec3d& corner : corners) {
    const Vec3d p = corner - camera.target;
    const double fit = std::max(std::abs(p.dot(basis.right)) / tanAcross, std::abs(p.dot(basis.up)) / tanUp);
    distance = std::max(distance, fit + p.dot(basis.back));
  }
  camera.position = camera.target + basis.back * std::max(distance, 1e-6 * radius);
  return camera;
}

Picture renderSurface(const FloatGrid& levelSet, const Camera& camera, const RenderOptions& options) {
  check(levelSet, options);
  Picture image{options.width, options.height, std::vector<float>(size_t(4) * options.width * options.height)};
  double depth = 0;
  if (!levelSet.empty()) {
    const openvdb::BBoxd box = levelSet.transform().indexToWorld(levelSet.evalActiveVoxelBoundingBox());
    depth = box.extents().length() + (box.getCenter() - camera.position).length();
  }
  const RayMaker rays(camera, double(options.width) / options.height, depth);
  const RowPainter painter(rays, options);
  constexpr int kRowsATask = 8;
  const tbb::blocked_range<int> rows(0, image.height, kRowsATask);
  if (levelSet.empty()) {
    for (int row = 0; row < image.height; ++row) painter.paint(image, row, nullptr, nullptr);
    return image;
  }
  const Intersector original(levelSet);
  tbb::parallel_for(
      rows,
      [&](const tbb::blocked_range<int>& range) {
        const Intersector intersector(original);
        Shader shader(levelSet, rays.basis(), original, options.shading);
        for (int row = range.begin(); row < range.end(); ++row)
          painter.paint(image, row, &intersector, &shader);
      },
      tbb::simple_partitioner());
  return image;
}

}  // namespace slicemorph
