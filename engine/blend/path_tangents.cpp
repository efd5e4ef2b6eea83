#include "engine/blend/path_tangents.h"

#include <tbb/parallel_for.h>

namespace slicemorph {

PathTangents::PathTangents(const LatticeOnObjects& on, const std::array<Neighbour, 2>& of) : on_(on) {
  if (on.objects() != 2 || !on.charts[0].bend.straight() || !on.charts[1].bend.straight()) return;
  const auto world = [&](size_t k, size_t i) { return on.anchor[k] + Vec3d(on.position[k][i]); };
  for (size_t k = 0; k < 2; ++k) {
    if (!of[k]) continue;
    std::vector<Vec3d> own(on.lattice.count());
    tbb::parallel_for(size_t(0), own.size(), [&](size_t i) { own[i] = world(k, i); });
    const std::vector<Vec3d> beyond = of[k](own);
    more_[k].resize(own.size());
    tbb::parallel_for(size_t(0), own.size(), [&](size_t i) {
      // Of either object the way that leads away from the other one goes on where the straight path ends.
      const Vec3d straight = world(1 - k, i) - own[i], onwards = own[i] - beyond[i];
      more_[k][i] = openvdb::Vec3s((k == 0 ? 0.5 : -0.5) * (onwards - straight));
    });
  }
}

void PathTangents::add(const Weights& weights, VectorField& offsets) const {
  if (weights[0] == 0 || weights[1] == 0) return;
  // The cubic's terms for the velocities at its ends.
  const double t = weights[1], left = 1 - t, factor[2] = {t * left * left, -t * t * left};
  const Chart chart = blendCharts(on_.charts, weights);
  const Mat3d toAxes = chart.axes.transpose();
  for (size_t k = 0; k < 2; ++k) {
    if (more_[k].empty()) continue;
    offsets.resize(on_.lattice.count(), openvdb::Vec3s(0.f));
    tbb::parallel_for(size_t(0), offsets.size(), [&](size_t i) {
      offsets[i] += openvdb::Vec3s(toAxes * (factor[k] * Vec3d(more_[k][i])) / chart.scale);
    });
  }
}

}  // namespace slicemorph
