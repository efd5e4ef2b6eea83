#include "engine/reconstruct/label_level_set.h"

#include "slicemorph/errors.h"

#include <openvdb/tools/Dense.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <string>

namespace slicemorph {

namespace {

/// Positions of the lattice's nodes along the stack: node k is at first + (k - cap) step.
struct FineSteps {
  double first = 0, last = 0, step = 1;
  int cap = 0, count = 0;

  double position(int k) const { return first + (k - cap) * step; }
};

FineSteps fineSteps(const ScoreStack& stack) {
  const auto& planes = stack.planes;
  double least = 1e300, ends = 0;
  for (size_t k = 0; k + 1 < planes.size(); ++k)
    least = std::min(least, planes[k + 1].position - planes[k].position);
  ends = std::max(planes[1].position - planes[0].position,
                  planes.back().position - planes[planes.size() - 2].position);
  FineSteps s;
  s.first = planes.front().position, s.last = planes.back().position;
  // With even gaps, every plane coincides with nodes.
  const double pixel = std::max(stack.pixel[0], stack.pixel[1]);
  s.step = least / std::max(1.0, std::round(least / pixel));
  s.cap = int(std::ceil(0.5 * ends / s.step)) + 1;
  s.count = int(std::round((s.last - s.first) / s.step)) + 1 + 2 * s.cap;
  return s;
}

/// Half the label's lead at a position. Beyond the ends it is that of the end plane minus an elliptic cap as
/// high as the label is deep, at most half a gap.
LabelScore leadAt(const SliceScores& scores, int label, double position) {
  const auto& planes = scores.stack().planes;
  const double first = planes.front().position, last = planes.back().position;
  const double beyond = std::max(first - position, position - last);
  if (beyond <= 1e-9 * (last - first))
    return scores.marginAt(std::min(std::max(position, first), last), label);
  LabelScore lead = scores.marginAt(position < first ? first : last, label);
  if (lead.values.empty()) return lead;
  const double gap =
      position < first ? planes[1].position - first : last - planes[planes.size() - 2].position;
  const double depth = std::max(double(*std::max_element(lead.values.begin(), lead.values.end())), 1e-6);
  const double q = beyond / std::min(0.5 * gap, depth);
  const double less = depth * (q < 1 ? 1 - std::sqrt(1 - q * q) : q);
  for (float& v : lead.values) v = float(v - less);
  return lead;
}

}  // namespace

FloatGrid::Ptr labelLevelSet(const SliceScores& scores, int label, const StackPlacement& placement) {
  const ScoreStack& stack = scores.stack();
  const FineSteps fine = fineSteps(stack);
  const float band = 3 * std::max(stack.pixel[0], stack.pixel[1]);
  std::vector<LabelScore> leads(size_t(fine.count));
  tbb::parallel_for(0, fine.count,
                    [&](int k) { leads[size_t(k)] = leadAt(scores, label, fine.position(k)); });
  PixelBox box;
  for (const LabelScore& l : leads) box = hull(box, l.box);
  if (box.empty()) throw GeometryError("no plane holds label " + std::to_string(label));
  box = box.grown(1);
  const openvdb::CoordBBox bounds({box.x0, box.y0, 0}, {box.x1 - 1, box.y1 - 1, fine.count - 1});
  openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(bounds, band);
  tbb::parallel_for(0, fine.count, [&](int k) {
    const LabelScore& l = leads[size_t(k)];
    for (int y = l.box.y0; y < l.box.y1; ++y)
      for (int x = l.box.x0; x < l.box.x1; ++x)
        dense.setValue(openvdb::Coord(x, y, k),
                       std::min(std::max(-l.values[l.box.index(x, y)], -band), band));
  });
  FloatGrid::Ptr grid = FloatGrid::create(band);
  openvdb::tools::copyFromDense(dense, *grid, 0.0f);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  const Vec3d up = fine.step * placement.along,
              corner = placement.origin + fine.position(0) * placement.along;
  const auto &x = placement.stepX, &y = placement.stepY;
  grid->setTransform(openvdb::math::Transform::createLinearTransform(
      openvdb::Mat4d(x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0, up[0], up[1], up[2], 0.0, corner[0],
                     corner[1], corner[2], 1.0)));
  return grid;
}

}  // namespace slicemorph
