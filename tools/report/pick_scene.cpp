#include "tools/report/pick_scene.h"

#include "engine/spine/limbs.h"
#include "engine/volume/level_set.h"
#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "slicemorph/measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

/// Most triangles of all meshes together: with positions and where they go a page stays below 20 MB.
constexpr size_t kMostTriangles = 240000;
/// Voxels along the longest side of a mesh that is coarser than its input, at first and at last.
constexpr double kFineVoxels = 160, kCoarseVoxels = 40;
/// A coarser mesh must keep this share of the area, or thin parts are lost. Chosen by hand.
constexpr double kKeptArea = 0.93;
/// Limbs meet if a carried one lies within this share of its length of the other, in the mean of its outer half. Chosen by
/// hand: a leg's neighbour is half its length away.
constexpr double kLimbReach = 0.4;

double areaOf(const Mesh& mesh) {
  double area = 0;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const openvdb::Vec3s &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    area += (b - a).cross(c - a).length() / 2;
  }
  return area;
}

/// The shape's surface with at most so many triangles, or nearly so where it would lose thin parts.
Mesh shownMesh(const FloatGrid& levelSet, const openvdb::Vec3SGrid* colors, size_t mostTriangles) {
  Mesh best = meshForFile(levelSet, colors);
  const double area = areaOf(best);
  openvdb::BBoxd box;
  for (const openvdb::Vec3s& p : best.points) box.expand(Vec3d(p));
  const double longest = box.empty() ? 0 : box.extents()[box.maxExtent()];
  for (double voxels = kFineVoxels; best.triangles.size() > mostTriangles && voxels >= kCoarseVoxels;
       voxels *= 0.8) {
    const double voxel = longest / voxels;
    if (voxel <= levelSet.voxelSize()[0]) continue;
    try {
      const FloatGrid::Ptr coarse = toLevelSet(levelSet.copy(), voxel).grid;
      const openvdb::Vec3SGrid::Ptr around = colors ? colorsAround(*coarse, *colors) : nullptr;
      Mesh mesh = meshForFile(*coarse, around.get());
      if (areaOf(mesh) < kKeptArea * area) break;
      best = std::move(mesh);
    } catch (const GeometryError&) {
      break;  // too thin for these voxels
    }
  }
  return best;
}

std::vector<Vec3d> worldPoints(const Mesh& mesh) {
  std::vector<Vec3d> points;
  points.reserve(mesh.points.size());
  for (const openvdb::Vec3s& p : mesh.points) points.push_back(Vec3d(p) + mesh.origin);
  return points;
}

std::vector<openvdb::Vec3s> relativeTo(const Vec3d& origin, const std::vector<Vec3d>& points) {
  std::vector<openvdb::Vec3s> relative;
  relative.reserve(points.size());
  for (const Vec3d& p : points) relative.emplace_back(p - origin);
  return relative;
}

double lengthOf(const std::vector<Vec3d>& line) {
  double length = 0;
  for (size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).length();
  return length;
}

/// Mean distance of the outer halves, as a share of the shorter one's length.
double apart(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = a.size() / 2; i < a.size(); ++i) sum += (a[i] - b[i]).length(), ++count;
  const double length = std::min(lengthOf(a), lengthOf(b));
  return length > 0 ? sum / double(count) / length : std::numeric_limits<double>::infinity();
}

/// Gives limbs that the map lays on each other one group: those that lie nearest first.
void groupLimbs(PickScene& scene, const MorphPlan& plan) {
  struct Meeting {
    double apart;
    size_t shape, limb, with;  ///< a limb of a shape, and one of the first
  };
  std::vector<Meeting> meetings;
  std::vector<PickLimb>& first = scene.shapes[0].limbs;
  for (size_t k = 1; k < scene.shapes.size(); ++k)
    for (size_t i = 0; i < scene.shapes[k].limbs.size(); ++i) {
      const std::vector<Vec3d> carried = plan.correspond(scene.shapes[k].limbs[i].line, k, 0);
      for (size_t j = 0; j < first.size(); ++j) {
        const double distance = apart(carried, first[j].line);
        if (distance < kLimbReach) meetings.push_back({distance, k, i, j});
      }
    }
  std::stable_sort(meetings.begin(), meetings.end(),
                   [](const Meeting& a, const Meeting& b) { return a.apart < b.apart; });
  std::vector<std::vector<bool>> taken(scene.shapes.size(), std::vector<bool>(first.size(), false));
  for (const Meeting& m : meetings) {
    PickLimb& limb = scene.shapes[m.shape].limbs[m.limb];
    if (limb.group >= 0 || taken[m.shape][m.with]) continue;
    taken[m.shape][m.with] = true;
    limb.group = first[m.with].group = int(m.with);
  }
}

}  // namespace

PickScene pickScene(const PickSceneJob& job, const Progress& cancel) {
  PickScene scene;
  const size_t count = job.levelSets.size();
  scene.up = job.up.length() > 0 ? job.up : Vec3d(0, 0, 1);
  for (size_t k = 0; k < count; ++k) {
    if (cancel.cancelled()) throw Cancelled();
    const openvdb::Vec3SGrid* colors = k < job.colors.size() ? job.colors[k].get() : nullptr;
    scene.shapes.push_back(
        {job.names[k], shownMesh(*job.levelSets[k], colors, kMostTriangles / std::max<size_t>(count, 2))});
    for (const Limb& limb : findLimbs(DistanceField(job.levelSets[k])))
      scene.shapes[k].limbs.push_back({limb.line});
  }
  if (!job.plan) return scene;
  for (size_t k = 0; k < count; ++k) {
    const std::vector<Vec3d> points = worldPoints(scene.shapes[k].mesh);
    for (size_t other = 0; other < count; ++other) {
      if (other == k) continue;
      if (cancel.cancelled()) throw Cancelled();
      scene.shapes[k].meets.push_back(
          relativeTo(scene.shapes[other].mesh.origin, job.plan->correspond(points, k, other)));
    }
  }
  groupLimbs(scene, *job.plan);
  scene.overlap = job.plan->overlap(), scene.turns = job.plan->turnChoices();
  return scene;
}

}  // namespace slicemorph
