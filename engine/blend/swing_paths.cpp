#include "engine/blend/swing_paths.h"

#include "engine/numerics/smoothstep.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Angles by which the two chords of a path bend, half the angle of the swing: up to the first, a swing of 80 degrees, a
/// parabola comes at most .6 % nearer to the hinge and is as good; beyond the third, a swing of 200 degrees, the three
/// points tell no circle that anything swings on.
constexpr double kNone = 0.7, kAll = 0.95, kMost = 1.6, kTooFar = 1.75;

/// What the middle of a path is off the straight line, in lengths of the lattice's diagonal: where it is little a parabola
/// is as good, and the angles of what hardly moves tell nothing.
constexpr double kLeastBulge = 0.02, kWholeBulge = 0.05;

/// What turns at even speed is half way in the middle, so that both chords are about equally long.
constexpr double kLopsided = 0.6, kEven = 0.85;
double lopsided(double a, double b) { return std::min(a, b) / std::max(a, b); }

}  // namespace

SwingPaths::SwingPaths(const LatticeOnObjects& on) : on_(on) {
  if (on.objects() != 2 || !on.charts[0].bend.straight() || !on.charts[1].bend.straight()) return;
  const Lattice& lattice = on.lattice;
  scale_ = blendCharts(on.charts, {0.5, 0.5}).scale;
  const double diagonal = lattice.spacing * (scale_ * (lattice.size.asVec3d() - Vec3d(1.0))).length();
  std::vector<std::vector<Arc>> slabs(lattice.size[2]);
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const size_t i = lattice.index(x, y, z);
        const Vec3d middle = lattice.position(x, y, z);
        const Vec3d before = scale_ * (Vec3d(on.chart[0][i]) - middle),
                    after = scale_ * (Vec3d(on.chart[1][i]) - middle);
        const double product = before.length() * after.length();
        if (!(product > 0)) continue;
        const double bends = std::acos(std::min(std::max(-before.dot(after) / product, -1.0), 1.0));
        const double bulge = 0.5 * (before + after).length() / diagonal;
        const double share = smoothstep(bends, kNone, kAll) * (1 - smoothstep(bends, kMost, kTooFar)) *
                             smoothstep(bulge, kLeastBulge, kWholeBulge) *
                             smoothstep(lopsided(before.length(), after.length()), kLopsided, kEven);
        if (share == 0) continue;
        // Chords of a circle of diameter d subtend twice the angle whose sine is their length over d.
        const double diameter = (after - before).length() / std::sin(bends);
        const auto angle = [&](const Vec3d& chord) {
          return float(2 * std::asin(std::min(chord.length() / diameter, 1.0)));
        };
        slabs[size_t(z)].push_back(
            {i, openvdb::Vec3s(before), openvdb::Vec3s(after), angle(before), angle(after), float(share)});
      }
  });
  for (const std::vector<Arc>& slab : slabs) arcs_.insert(arcs_.end(), slab.begin(), slab.end());
}

VectorField SwingPaths::offsets(const Weights& weights) const {
  if (arcs_.empty() || weights[0] == 0 || weights[1] == 0) return {};
  const Weights path = pathWeights(weights);
  VectorField result(on_.lattice.count(), openvdb::Vec3s(0.f));
  tbb::parallel_for(size_t(0), arcs_.size(), [&](size_t k) {
    const Arc& arc = arcs_[k];
    // A point of the circle by its angle from the middle, in terms of both chords.
    const double a = arc.angleBefore, b = arc.angleAfter, angle = path[1] * b - path[0] * a;
    const double fallA = 1 - std::cos(a), fallB = 1 - std::cos(b), fall = 1 - std::cos(angle);
    const double whole = std::sin(a) * fallB + std::sin(b) * fallA;
    const double ofBefore = (fall * std::sin(b) - std::sin(angle) * fallB) / whole,
                 ofAfter = (fall * std::sin(a) + std::sin(angle) * fallA) / whole;
    const Vec3d offset = (ofBefore - path[0]) * Vec3d(arc.before) + (ofAfter - path[1]) * Vec3d(arc.after);
    result[arc.node] = openvdb::Vec3s(double(arc.share) * offset / scale_);
  });
  return result;
}

}  // namespace slicemorph
