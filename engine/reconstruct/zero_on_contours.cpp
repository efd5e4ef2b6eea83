#include "engine/reconstruct/zero_on_contours.h"

#include "engine/numerics/lattice_cell.h"

#include <tbb/parallel_for.h>

#include <algorithm>

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
  // Sums per node near a contour, not per node of the lattice.
  std::vector<std::uint32_t> nodes;
  nodes.reserve(points.size() * 8);
  for (const CellPoint& point : points)
    for (const std::uint32_t corner : corners) nodes.push_back(point.cell + corner);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::vector<std::array<std::uint32_t, 8>> slots(points.size());
  tbb::parallel_for(size_t(0), points.size(), [&](size_t p) {
    for (size_t c = 0; c < 8; ++c)
      slots[p][c] = std::uint32_t(std::lower_bound(nodes.begin(), nodes.end(), points[p].cell + corners[c]) -
                                  nodes.begin());
  });
  std::vector<float> change(nodes.size(), 0), weights(nodes.size(), 0);
  for (int sweep = 0; sweep < kMeetingSweeps; ++sweep) {
    for (size_t p = 0; p < points.size(); ++p) {
      const float rest = float(valueAt(lattice, values, points[p]));
      for (int c = 0; c < 8; ++c) {
        const float weight = points[p].weight(c);
        weights[slots[p][size_t(c)]] += weight;
        change[slots[p][size_t(c)]] += weight * rest;
      }
    }
    for (size_t n = 0; n < nodes.size(); ++n) {
      if (weights[n] > 0) values[nodes[n]] -= change[n] / weights[n];
      change[n] = weights[n] = 0;
    }
  }
  return values;
}

}  // namespace slicemorph
