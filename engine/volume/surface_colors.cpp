#include "engine/volume/surface_colors.h"

#include "engine/volume/color_sampler.h"
#include "engine/volume/voxelise.h"

#include <openvdb/math/Proximity.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::Vec3I;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;
using VectorLeaf = openvdb::Vec3STree::LeafNodeType;
using Leaves = openvdb::tree::LeafManager<openvdb::Vec3STree>;

/// Voxels beyond the level set's band in which triangles are searched, because its distances are not exact.
constexpr double kColorMargin = 1;
/// Marks voxels without a colour yet.
const Vec3s kNone(std::numeric_limits<float>::quiet_NaN());

/// Nearest-neighbour search among voxels. A balanced k-d tree in an array: the middle element of each range
/// splits it along one axis.
class VoxelTree {
 public:
  explicit VoxelTree(std::vector<Coord> voxels) : voxels_(std::move(voxels)) { build(0, voxels_.size(), 0); }

  /// Ties go to the voxel with the smallest coordinates.
  Coord nearest(const Coord& to) const {
    Nearest best;
    search(to, 0, voxels_.size(), 0, best);
    return best.voxel;
  }

 private:
  struct Nearest {
    std::int64_t squared = std::numeric_limits<std::int64_t>::max();
    Coord voxel;
  };

  void build(size_t first, size_t last, int axis) {
    if (last - first < 2) return;
    const size_t middle = (first + last) / 2;
    const auto begin = voxels_.begin();
    std::nth_element(begin + std::ptrdiff_t(first), begin + std::ptrdiff_t(middle),
                     begin + std::ptrdiff_t(last),
                     [axis](const Coord& a, const Coord& b) { return a[axis] < b[axis]; });
    const auto low = [&] { build(first, middle, (axis + 1) % 3); };
    const auto high = [&] { build(middle + 1, last, (axis + 1) % 3); };
    if (last - first > 8192)
      tbb::parallel_invoke(low, high);
    else
      low(), high();
  }

  void search(const Coord& to, size_t first, size_t last, int axis, Nearest& best) const {
    if (first == last) return;
    const size_t middle = (first + last) / 2;
    const Coord& own = voxels_[middle];
    std::int64_t squared = 0;
    for (int d = 0; d < 3; ++d) squared += std::int64_t(to[d] - own[d]) * (to[d] - own[d]);
    if (squared < best.squared || (squared == best.squared && own < best.voxel)) best = {squared, own};
    const std::int64_t beyond = std::int64_t(to[axis]) - own[axis];
    const auto low = [&] { search(to, first, middle, (axis + 1) % 3, best); };
    const auto high = [&] { search(to, middle + 1, last, (axis + 1) % 3, best); };
    beyond < 0 ? low() : high();
    if (beyond * beyond <= best.squared) beyond < 0 ? high() : low();
  }

  std::vector<Coord> voxels_;
};

/// A vec3s grid "Cd" on the active voxels of a level set.
Vec3SGrid::Ptr gridOn(const FloatGrid& levelSet) {
  const auto tree =
      std::make_shared<openvdb::Vec3STree>(levelSet.tree(), Vec3s(0.f), openvdb::TopologyCopy());
  if (tree->hasActiveTiles()) tree->voxelizeActiveTiles();
  const Vec3SGrid::Ptr grid = Vec3SGrid::create(tree);
  grid->setTransform(levelSet.transform().copy());
  grid->setName("Cd");
  return grid;
}

std::vector<Coord> voxelsWith(const Leaves& leaves, bool color) {
  std::vector<Coord> voxels;
  for (size_t i = 0; i < leaves.leafCount(); ++i)
    for (auto value = leaves.leaf(i).cbeginValueOn(); value; ++value)
      if (isColor(*value) == color) voxels.push_back(value.getCoord());
  return voxels;
}

/// Gives voxels without a colour that of the nearest voxel with one. Returns false if there is none.
bool fillFromNearest(Vec3SGrid& grid) {
  const Leaves leaves(grid.tree());
  const std::vector<Coord> missing = voxelsWith(leaves, false);
  if (missing.empty()) return true;
  std::vector<Coord> colored = voxelsWith(leaves, true);
  if (colored.empty()) return false;
  const VoxelTree tree(std::move(colored));
  std::vector<Vec3s> found(missing.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, missing.size(), 64),
                    [&](const tbb::blocked_range<size_t>& part) {
                      const Vec3SGrid::ConstAccessor values = grid.getConstAccessor();
                      for (size_t i = part.begin(); i < part.end(); ++i)
                        found[i] = values.getValue(tree.nearest(missing[i]));
                    });
  Vec3SGrid::Accessor values = grid.getAccessor();
  for (size_t i = 0; i < missing.size(); ++i) values.setValueOnly(missing[i], found[i]);
  return true;
}

/// The faces of a mesh as fans of triangles, in index space.
struct ColoredTriangles {
  Mesh mesh;
  std::vector<Vec3I> corners;        ///< per triangle: indices of its corners among the polygons' corners
  std::vector<std::uint32_t> faces;  ///< per triangle: the polygon that it is of
};

/// Faces outside the box are left out: repair has dropped them, and they may be arbitrarily large.
ColoredTriangles trianglesOf(const PolygonMesh& polygons, const openvdb::math::Transform& transform,
                             const openvdb::BBoxd& box) {
  ColoredTriangles result;
  std::vector<char> inside;
  for (const Vec3s& p : polygons.points) {
    const Vec3d index = transform.worldToIndex(Vec3d(p));
    inside.push_back(box.isInside(index));
    result.mesh.points.emplace_back(index);
  }
  for (size_t f = 0; f < polygons.faceCount(); ++f) {
    const std::uint32_t first = polygons.faceStarts[f];
    for (std::uint32_t k = first + 1; k + 1 < polygons.faceStarts[f + 1]; ++k) {
      const Vec3I corners(first, k, k + 1);
      const Vec3I t(polygons.corners[first], polygons.corners[k], polygons.corners[k + 1]);
      if (!inside[t[0]] || !inside[t[1]] || !inside[t[2]]) continue;
      result.mesh.triangles.push_back(t);
      result.corners.push_back(corners);
      result.faces.push_back(std::uint32_t(f));
    }
  }
  return result;
}

/// The point of a triangle nearest to a voxel, in barycentric coordinates.
struct TrianglePoint {
  int triangle = -1;
  Vec3d weights;
  double squared = std::numeric_limits<double>::max();  ///< of the distance, voxels
};

/// Searches the triangles stored at a voxel and its 26 neighbours: OpenVDB propagates triangles from voxel to
/// voxel and may lose the nearest one where several are near. Each task needs its own.
class NearestTrianglePoint {
 public:
  NearestTrianglePoint(const Mesh& mesh, const openvdb::Int32Grid& triangles)
      : mesh_(mesh), triangles_(triangles.getConstAccessor()) {}

  TrianglePoint at(const Coord& voxel) {
    tried_.clear();
    TrianglePoint best;
    tryTriangle(triangles_.getValue(voxel), voxel.asVec3d(), best);
    for (auto c = openvdb::CoordBBox(voxel.offsetBy(-1), voxel.offsetBy(1)).begin(); c; ++c)
      tryTriangle(triangles_.getValue(*c), voxel.asVec3d(), best);
    return best;
  }

 private:
  void tryTriangle(int triangle, const Vec3d& p, TrianglePoint& best) {
    if (triangle < 0 || std::find(tried_.begin(), tried_.end(), triangle) != tried_.end()) return;
    tried_.push_back(triangle);
    const Vec3I& t = mesh_.triangles[size_t(triangle)];
    const Vec3d a(mesh_.points[t[0]]), b(mesh_.points[t[1]]), c(mesh_.points[t[2]]);
    if (squaredDistanceToBox(p, a, b, c) > best.squared) return;
    TrianglePoint point;
    point.triangle = triangle;
    point.squared = (openvdb::math::closestPointOnTriangleToPoint(a, b, c, p, point.weights) - p).lengthSqr();
    if (point.squared < best.squared || (point.squared == best.squared && triangle < best.triangle))
      best = point;
  }

  static double squaredDistanceToBox(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const double outside =
          std::max({std::min({a[i], b[i], c[i]}) - p[i], p[i] - std::max({a[i], b[i], c[i]}), 0.0});
      sum += outside * outside;
    }
    return sum;
  }

  const Mesh& mesh_;
  openvdb::Int32Grid::ConstAccessor triangles_;
  std::vector<int> tried_;
};

/// Propagates the triangles to neighbours once more.
openvdb::Int32Grid::Ptr improved(const openvdb::Int32Grid& triangles, const Mesh& mesh) {
  const openvdb::Int32Grid::Ptr result = triangles.deepCopy();
  openvdb::tree::LeafManager<openvdb::Int32Tree>(result->tree()).foreach ([&](auto& leaf, size_t) {
    NearestTrianglePoint nearest(mesh, triangles);
    for (auto value = leaf.beginValueOn(); value; ++value)
      value.setValue(nearest.at(value.getCoord()).triangle);
  });
  return result;
}

/// Mean colour of a picture on a triangle over a square of one voxel around a point, which would hide finer detail.
/// Samples lie in pairs on either side of the point, as near as the triangle is wide there, so that colours that
/// change evenly are exact. `uvs`: of the corners.
Vec3s textureOf(const Texture& texture, const openvdb::Vec2d (&uvs)[3], const Vec3d (&at)[3],
                const Vec3d& weights) {
  constexpr int kAlong = 4;  // samples along the square's side; finer detail is looked up in halved pictures
  const auto uvAt = [&](const Vec3d& w) { return uvs[0] * w[0] + uvs[1] * w[1] + uvs[2] * w[2]; };
  const Vec3d ab = at[1] - at[0], ac = at[2] - at[0], normal = ab.cross(ac);
  const openvdb::Vec2d size(texture.width(), texture.height());
  const openvdb::Vec2d uvAb = (uvs[1] - uvs[0]) * size, uvAc = (uvs[2] - uvs[0]) * size;
  const double area = normal.length(), texelArea = std::abs(uvAb[0] * uvAc[1] - uvAb[1] * uvAc[0]);
  if (!(area > 0)) return texture.at(uvAt(weights));
  const double texels = std::sqrt(texelArea / area);  // per voxel
  if (texels <= 1) return texture.at(uvAt(weights));
  const Vec3d along = ab.unit(), across = (normal / area).cross(along);
  ColorMean mean;
  for (int j = 0; j < kAlong; ++j)
    for (int i = 0; i < kAlong; ++i) {
      const Vec3d d = along * ((i + 0.5) / kAlong - 0.5) + across * ((j + 0.5) / kAlong - 0.5);
      // The move in weights of the corners.
      const double b = d.cross(ac).dot(normal) / (area * area), c = ab.cross(d).dot(normal) / (area * area);
      const Vec3d move(-b - c, b, c);
      double share = 1;
      for (int k = 0; k < 3; ++k)
        if (move[k] != 0) share = std::min(share, weights[k] / std::abs(move[k]));
      mean.add(texture.at(uvAt(weights + move * std::max(share, 0.0)), texels / kAlong), 1);
    }
  return mean.value().value_or(Vec3s(1.f));
}

Vec3s colorOf(const TrianglePoint& point, const ColoredTriangles& triangles, const PolygonMesh& polygons) {
  if (point.triangle < 0) return kNone;
  const size_t triangle = size_t(point.triangle);
  const Vec3I& corners = triangles.corners[triangle];
  ColorMean mean;
  for (int k = 0; k < 3; ++k)
    if (point.weights[k] > 0) mean.add(polygons.colors[corners[k]], point.weights[k]);
  const Vec3s color = mean.value().value_or(polygons.colors[corners[0]]);
  if (polygons.textureOfFace.empty()) return color;
  const int texture = polygons.textureOfFace[triangles.faces[triangle]];
  if (texture < 0) return color;
  openvdb::Vec2d uvs[3];
  Vec3d at[3];
  for (int k = 0; k < 3; ++k) {
    uvs[k] = openvdb::Vec2d(polygons.uvs[corners[k]]);
    at[k] = Vec3d(triangles.mesh.points[triangles.mesh.triangles[triangle][k]]);
  }
  return color * textureOf(*polygons.textures[size_t(texture)], uvs, at, point.weights);
}

}  // namespace

Vec3SGrid::Ptr colorsAround(const FloatGrid& levelSet, const PolygonMesh& mesh) {
  if (mesh.colors.empty()) return nullptr;
  const openvdb::CoordBBox band = levelSet.evalActiveVoxelBoundingBox();
  const ColoredTriangles triangles =
      trianglesOf(mesh, levelSet.transform(), {band.min().asVec3d(), band.max().asVec3d()});
  const auto near = improved(
      *nearestTriangles(triangles.mesh, levelSet.transform(), kHalfWidth + kColorMargin), triangles.mesh);
  const Vec3SGrid::Ptr grid = gridOn(levelSet);
  Leaves(grid->tree()).foreach ([&](VectorLeaf& leaf, size_t) {
    NearestTrianglePoint nearest(triangles.mesh, *near);
    for (auto value = leaf.beginValueOn(); value; ++value)
      value.setValue(colorOf(nearest.at(value.getCoord()), triangles, mesh));
  });
  return fillFromNearest(*grid) ? grid : nullptr;
}

Vec3SGrid::Ptr colorsAround(const FloatGrid& levelSet, const Vec3SGrid& colors) {
  const Vec3SGrid::Ptr grid = gridOn(levelSet);
  Leaves(grid->tree()).foreach ([&](VectorLeaf& leaf, size_t) {
    const ColorSampler sampler(colors);
    for (auto value = leaf.beginValueOn(); value; ++value) {
      const Vec3d world = levelSet.transform().indexToWorld(value.getCoord());
      value.setValue(sampler.between(sampler.toIndex(world)).value().value_or(kNone));
    }
  });
  return fillFromNearest(*grid) ? grid : nullptr;
}

std::vector<Vec3s> colorsAt(const Vec3SGrid& colors, const std::vector<Vec3s>& points) {
  std::vector<Vec3s> result(points.size(), Vec3s(0.f));
  tbb::parallel_for(tbb::blocked_range<size_t>(0, points.size(), 256),
                    [&](const tbb::blocked_range<size_t>& part) {
                      const ColorSampler sampler(colors);
                      for (size_t i = part.begin(); i < part.end(); ++i)
                        result[i] = sampler.at(Vec3d(points[i])).value_or(Vec3s(0.f));
                    });
  return result;
}

bool isColorName(const std::string& name) {
  static const std::set<std::string> names{"Cd", "cd", "color", "colour", "Color", "rgb", "albedo"};
  return names.count(name) > 0;
}

}  // namespace slicemorph
