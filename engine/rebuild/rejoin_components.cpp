#include "engine/rebuild/rejoin_components.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <set>
#include <unordered_set>

namespace slicemorph {

namespace {

using openvdb::Coord;
using Accessor = FloatGrid::Accessor;

/// Most joints of one frame, each of which takes a labelling of all components; limbs are few.
constexpr int kMostJoints = 16;
/// How far from the gap its sides are looked at to tell how thick they are, voxels.
constexpr int kClimb = 4;
/// Least radius of a joint, voxels: then voxels that share faces are inside all along it, for which half a voxel's diagonal
/// is needed.
constexpr double kLeastRadius = 0.9;

/// No voxel is nearer than this to a joint's surface, voxels: one exactly on it would get faces of no extent.
constexpr double kOffSurface = 1e-3;

template <typename Visit>
void forEachNeighbour(const Coord& c, const Visit& visit) {
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) visit(c.offsetBy(x, y, z), std::sqrt(double(x * x + y * y + z * z)));
}

/// The two sides of a gap, voxels.
struct Gap {
  Coord from, to;
};

/// The shortest way through the narrow band, the less the farther outside, from a component to another one.
std::optional<Gap> gapFrom(const std::unordered_set<Coord>& own, const Accessor& values, double background) {
  struct Reached {
    double length;
    Coord at, from;
    bool operator<(const Reached& o) const { return length != o.length ? length > o.length : at > o.at; }
  };
  std::unordered_set<Coord> done;
  std::priority_queue<Reached> open;
  const auto step = [&](const Reached& r) {
    forEachNeighbour(r.at, [&](const Coord& c, double distance) {
      const double value = values.getValue(c);
      if (value >= background || own.count(c) || done.count(c)) return;
      const double length = r.length + distance * (1 + std::max(value, 0.0) / background);
      if (length <= 4 * kHalfWidth) open.push({length, c, r.from});
    });
  };
  for (const Coord& c : own) step({0, c, c});
  while (!open.empty()) {
    const Reached r = open.top();
    open.pop();
    if (!done.insert(r.at).second) continue;
    if (values.getValue(r.at) < 0) return Gap{r.from, r.at};
    step(r);
  }
  return std::nullopt;
}

/// The deepest voxel of one side that one comes to from `c` in few steps, each of them deeper.
template <typename IsOnSide>
Coord deepestNear(Coord c, const Accessor& values, const IsOnSide& isOnSide) {
  for (int i = 0; i < kClimb; ++i) {
    Coord best = c;
    forEachNeighbour(c, [&](const Coord& n, double) {
      if (values.getValue(n) < values.getValue(best) && isOnSide(n)) best = n;
    });
    if (best == c) break;
    c = best;
  }
  return c;
}

/// A cone with round ends, voxels.
struct Joint {
  Vec3d from, to;
  double fromRadius, toRadius;

  double distance(const Vec3d& p) const {
    const Vec3d along = to - from;
    const double t = std::clamp((p - from).dot(along) / std::max(along.lengthSqr(), 1e-12), 0.0, 1.0);
    return (p - from - t * along).length() - (fromRadius + t * (toRadius - fromRadius));
  }
};

void add(FloatGrid& grid, const Joint& joint) {
  const double h = grid.voxelSize()[0], background = grid.background();
  Accessor values = grid.getAccessor();
  openvdb::CoordBBox box(Coord::round(joint.from), Coord::round(joint.from));
  box.expand(Coord::round(joint.to));
  box.expand(int(std::ceil(std::max(joint.fromRadius, joint.toRadius) + kHalfWidth)));
  for (auto it = box.begin(); it; ++it) {
    double d = joint.distance((*it).asVec3d()) * h;
    if (std::abs(d) < kOffSurface * h) d = kOffSurface * h;
    if (d < values.getValue(*it) && d < background) values.setValueOn(*it, float(std::max(d, -background)));
  }
}

using Belongs = std::function<bool(const std::vector<Vec3d>&)>;

/// World points along a joint, a voxel apart.
std::vector<Vec3d> pointsAlong(const FloatGrid& grid, const Joint& joint) {
  const int steps = std::max(int(std::ceil((joint.to - joint.from).length())), 1);
  std::vector<Vec3d> points;
  for (int i = 0; i <= steps; ++i)
    points.push_back(grid.indexToWorld(joint.from + (joint.to - joint.from) * (double(i) / steps)));
  return points;
}

bool rejoin(FloatGrid& grid, const LooseComponent& component, const Belongs& belongs) {
  const double h = grid.voxelSize()[0];
  const Accessor values = grid.getAccessor();
  const bool thick = std::any_of(component.voxels.begin(), component.voxels.end(),
                                 [&](const Coord& c) { return values.getValue(c) <= -h; });
  if (!thick) return false;
  const std::unordered_set<Coord> own(component.voxels.begin(), component.voxels.end());
  const std::optional<Gap> gap = gapFrom(own, values, grid.background());
  if (!gap) return false;
  const auto isOwn = [&](const Coord& c) { return own.count(c) > 0; };
  const Coord from = deepestNear(gap->from, values, isOwn),
              to = deepestNear(gap->to, values, [&](const Coord&c) { return !isOwn(c); });
  const auto radius = [&](const Coord& c) { return std::max(-values.getValue(c) / h, kLeastRadius); };
  const Joint joint{from.asVec3d(), to.asVec3d(), radius(from), radius(to)};
  if (!belongs(pointsAlong(grid, joint))) return false;
  add(grid, joint);
  return true;
}

}  // namespace

Rejoined rejoinComponents(FloatGrid& levelSet, int allowed, const Belongs& belongs) {
  std::set<Coord> hopeless;  // components, by their first voxels
  for (int joints = 0; joints < kMostJoints; ++joints) {
    std::vector<LooseComponent> loose = looseComponents(levelSet, allowed);
    const bool any = std::any_of(loose.rbegin(), loose.rend(), [&](const LooseComponent& component) {
      const Coord first = *std::min_element(component.voxels.begin(), component.voxels.end());
      if (hopeless.count(first)) return false;
      const bool joined = rejoin(levelSet, component, belongs);
      if (!joined) hopeless.insert(first);
      return joined;
    });
    if (!any) return {joints, std::move(loose)};
  }
  return {kMostJoints, looseComponents(levelSet, allowed)};
}

}  // namespace slicemorph
