#include "engine/reconstruct/zero_on_contours.h"

#include "engine/numerics/lattice_cell.h"

namespace slicemorph {

namespace {

/// Sweeps over the contour points: correcting one changes the values at others in the same cells.
constexpr int kMeetingSweeps = 10;

}  // namespace

std::vector<float> zeroOnContours(const PlaneSet& planes, const Lattice& lattice, std::vector<float> values) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(lattice);
  std::vector<CellPoint> points;
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges)
      for (const Vec2d& p : {e.a, 0.5 * (e.a + e.b)})
        points.push_back(cellPoint(lattice, planes.world(int(i), p)));
  std::vector<float> change(lattice.count(), 0), weights(lattice.count(), 0);
  for (int sweep = 0; sweep < kMeetingSweeps; ++sweep) {
    std::vector<std::uint32_t> touched;
    for (const CellPoint& point : points) {
      const float rest = float(valueAt(lattice, values, point));
      for (int c = 0; c < 8; ++c) {
        const std::uint32_t n = point.cell + corners[c];
        const float weight = point.weight(c);
        if (weights[n] == 0 && weight > 0) touched.push_back(n);
        weights[n] += weight;
        change[n] += weight * rest;
      }
    }
    for (std::uint32_t n : touched) {
      values[n] -= change[n] / weights[n];
      change[n] = weights[n] = 0;
    }
  }
  return values;
}

}  // namespace slicemorph
