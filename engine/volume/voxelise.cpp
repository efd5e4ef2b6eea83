#include "engine/volume/voxelise.h"

#include "engine/numerics/readable.h"
#include "engine/volume/manifold.h"
#include "engine/volume/mesh_measures.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;
using openvdb::Vec4I;
using Index = std::uint32_t;

/// Larger grids come from a mistyped voxel size.
constexpr double kMostVoxelsAlong = 8192;
/// Beyond this coordinate single precision has no fraction left, and 32-bit indices come near their limit.
constexpr double kFarthestVoxel = 1 << 24;

bool hasInside(const FloatGrid& grid) {
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      if (*value < 0) return true;
    }
  }
  return false;
}

/// Throws before anything is allocated.
void refuseAbsurdSize(const Mesh& mesh, double voxelSize) {
  std::ostringstream why;
  if (!(voxelSize > 0) || !std::isfinite(voxelSize)) {
    why << "voxel size " << voxelSize << " is no positive number of world units";
    throw InputError(why.str());
  }
  if (mesh.triangles.empty()) throw GeometryError("the mesh has no faces");
  const openvdb::BBoxd box = boundsOf(mesh.points);
  const double longest = box.extents()[int(box.maxExtent())];
  const double band = bandVoxelsOf(areaOf(mesh), voxelSize), farthest = farthestCoordinate(box);
  const double allowed = std::max(
      {longest / kMostVoxelsAlong, farthest / kFarthestVoxel, voxelSize * std::sqrt(band / kMostBandVoxels)});
  if (std::isfinite(allowed) && voxelSize >= allowed) return;
  why << "voxel size " << voxelSize << " would make a grid of "
      << readableCount(std::ceil(longest / voxelSize)) << " voxels along the longest side and about "
      << readableCount(band) << " voxels in the narrow band; at most " << readableCount(kMostVoxelsAlong)
      << " and " << readableCount(kMostBandVoxels)
      << " are allowed: for this surface a voxel size of at least " << allowed;
  throw InputError(why.str());
}

/// The quads at each point, grouped by point, with offsets in `starts`.
struct QuadsByPoint {
  std::vector<Index> starts, items;

  QuadsByPoint(const std::vector<Vec4I>& quads, size_t pointCount) : starts(pointCount + 1, 0) {
    for (const Vec4I& q : quads) {
      for (int k = 0; k < 4; ++k) ++starts[q[k] + 1];
    }
    for (size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
    std::vector<Index> next(starts.begin(), starts.end() - 1);
    items.resize(quads.size() * 4);
    for (size_t i = 0; i < quads.size(); ++i) {
      for (int k = 0; k < 4; ++k) items[next[quads[i][k]]++] = Index(i);
    }
  }
};

/// Whether no quad but `own` contains both points, so that a diagonal between them would be a new edge.
bool isFree(const QuadsByPoint& by, const std::vector<Vec4I>& quads, Index own, Index a, Index b) {
  for (Index i = by.starts[a]; i < by.starts[a + 1]; ++i) {
    const Vec4I& q = quads[by.items[i]];
    if (by.items[i] != own && (q[0] == b || q[1] == b || q[2] == b || q[3] == b)) return false;
  }
  return true;
}

/// Splits each quad along its shorter diagonal (of equal ones the first), unless that is already an edge and
/// the other is not.
std::vector<Vec3I> splitQuads(const std::vector<Vec3s>& points, const std::vector<Vec4I>& quads) {
  const QuadsByPoint by(quads, points.size());
  std::vector<Vec3I> triangles(quads.size() * 2);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, quads.size(), 4096),
                    [&](const tbb::blocked_range<size_t>& r) {
                      for (size_t i = r.begin(); i < r.end(); ++i) {
                        const Vec4I& q = quads[i];
                        const double d02 = (Vec3d(points[q[0]]) - Vec3d(points[q[2]])).lengthSqr();
                        const double d13 = (Vec3d(points[q[1]]) - Vec3d(points[q[3]])).lengthSqr();
                        int first = d13 < d02 ? 1 : 0;
                        if (!isFree(by, quads, Index(i), q[first], q[first + 2]) &&
                            isFree(by, quads, Index(i), q[1 - first], q[(3 - first)])) {
                          first = 1 - first;
                        }
                        triangles[2 * i] = Vec3I(q[first], q[first + 1], q[first + 2]);
                        triangles[2 * i + 1] = Vec3I(q[first], q[first + 2], q[(first + 3) % 4]);
                      }
                    });
  return triangles;
}

/// volumeToMesh winds faces inwards as seen from values below the isovalue, but a fog volume's inside is
/// above it.
bool windsInwards(const FloatGrid& grid) {
  const bool fog = grid.getGridClass() == openvdb::GRID_FOG_VOLUME;
  const Vec3d origin = grid.indexToWorld(Vec3d(0.0));
  const Vec3d x = grid.indexToWorld(Vec3d(1, 0, 0)) - origin, y = grid.indexToWorld(Vec3d(0, 1, 0)) - origin;
  const bool mirrored = x.cross(y).dot(grid.indexToWorld(Vec3d(0, 0, 1)) - origin) < 0;
  return fog == mirrored;
}

Mesh rawSurface(const FloatGrid& grid, double iso) {
  Mesh mesh;
  std::vector<Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, mesh.points, quads, iso);
  if (windsInwards(grid)) {
    for (Vec4I& q : quads) std::swap(q[1], q[3]);
  }
  mesh.triangles = splitQuads(mesh.points, quads);
  return mesh;
}

/// A copy whose values differ from `iso` by at least a thousandth of the smaller range on either side of it.
/// Voxels exactly on the surface could shrink parts of it to a point, with faces of no extent.
FloatGrid::Ptr awayFrom(const FloatGrid& grid, double iso) {
  double below = 0, above = 0;
  for (auto value = grid.cbeginValueOn(); value; ++value) {
    below = std::max(below, iso - *value);
    above = std::max(above, *value - iso);
  }
  const double step = below > 0 && above > 0 ? std::min(below, above) : std::max(below, above);
  const float low = float(iso - 1e-3 * step), high = float(iso + 1e-3 * step);
  FloatGrid::Ptr copy = grid.deepCopy();
  for (auto value = copy->beginValueAll(); value; ++value) {
    if (*value > low && *value < high) value.setValue(*value < iso ? low : high);
  }
  return copy;
}

}  // namespace

double bandVoxelsOf(double area, double voxelSize) { return area / (voxelSize * voxelSize) * 2 * kHalfWidth; }

FloatGrid::Ptr voxelise(const Mesh& mesh, double voxelSize) {
  refuseAbsurdSize(mesh, voxelSize);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  FloatGrid::Ptr grid =
      openvdb::tools::meshToLevelSet<FloatGrid>(*transform, mesh.points, mesh.triangles, float(kHalfWidth));
  requireInside(*grid);
  return grid;
}

void requireInside(const FloatGrid& grid) {
  if (hasInside(grid)) return;
  std::ostringstream why;
  why << "nothing lies inside the surface at voxel size " << grid.voxelSize()[0]
      << ": it is open, or thinner than a voxel everywhere";
  throw GeometryError(why.str());
}

FloatGrid::Ptr unsignedDistance(const Mesh& mesh, double voxelSize, double halfWidth) {
  refuseAbsurdSize(mesh, voxelSize);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  std::vector<Vec3s> points(mesh.points.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, points.size(), 4096),
                    [&](const tbb::blocked_range<size_t>& r) {
                      for (size_t i = r.begin(); i < r.end(); ++i)
                        points[i] = Vec3s(transform->worldToIndex(Vec3d(mesh.points[i])));
                    });
  return openvdb::tools::meshToVolume<FloatGrid>(
      openvdb::tools::QuadAndTriangleDataAdapter<Vec3s, Vec3I>(points, mesh.triangles), *transform,
      float(halfWidth), float(halfWidth), openvdb::tools::UNSIGNED_DISTANCE_FIELD);
}

openvdb::Int32Grid::Ptr nearestTriangles(const Mesh& mesh, const openvdb::math::Transform& transform,
                                         double halfWidth) {
  using openvdb::tools::QuadAndTriangleDataAdapter;
  auto nearest = openvdb::Int32Grid::create(openvdb::Int32(openvdb::util::INVALID_IDX));
  openvdb::util::NullInterrupter never;
  openvdb::tools::meshToVolume<FloatGrid>(
      never, QuadAndTriangleDataAdapter<Vec3s, Vec3I>(mesh.points, mesh.triangles), transform,
      float(halfWidth), float(halfWidth), openvdb::tools::UNSIGNED_DISTANCE_FIELD, nearest.get());
  return nearest;
}

Mesh surfaceOf(const FloatGrid& grid, double iso) {
  ManifoldMesh result = makeManifold(rawSurface(grid, iso));
  if (result.coincident > 0) result = makeManifold(rawSurface(*awayFrom(grid, iso), iso));
  return std::move(result.mesh);
}

}  // namespace slicemorph
