#include "engine/reconstruct/plate_surface.h"

#include "engine/reconstruct/first_guess.h"
#include "engine/reconstruct/plate_data.h"
#include "engine/reconstruct/zero_on_contours.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Iterations of the solver; in a band the initial guess is already close.
constexpr int kWholeSteps = 400, kBandSteps = 40;
constexpr int kContourReach = 3;     ///< nodes around a contour that are always solved for
constexpr double kLeastSlope = 0.3;  ///< of a surface that is nearly parallel to a plane
/// Rounds of solving again around pixels where the surface contradicts their plane.
constexpr int kVerdictRounds = 3;

/// The finest lattice, aligned so that it can be coarsened `levels` times, down to a spacing like
/// the planes' gap.
Lattice finestLattice(const PlaneSet& planes, double h, int levels) {
  const double coarse = h * (1 << levels), margin = planes.gap + 3.5 * coarse;
  Lattice lattice;
  lattice.spacing = h;
  for (int a = 0; a < 3; ++a) {
    lattice.origin[a] = coarse * std::floor((planes.box.min()[a] - margin) / coarse);
    lattice.size[a] =
        (int(std::ceil((planes.box.max()[a] + margin - lattice.origin[a]) / coarse)) << levels) + 1;
  }
  return lattice;
}

Lattice coarser(const Lattice& lattice, int level) {
  Lattice out = lattice;
  out.spacing = lattice.spacing * (1 << level);
  for (int a = 0; a < 3; ++a) out.size[a] = ((lattice.size[a] - 1) >> level) + 1;
  return out;
}

/// Trilinear interpolation to half the spacing.
std::vector<float> refined(const PlateSurface& coarse, const Lattice& lattice) {
  std::vector<float> values(lattice.count());
  tbb::parallel_for(0, lattice.size[2], [&](int k) {
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0]; ++i) {
        float sum = 0;
        for (int c = 0; c < 8; ++c)
          sum += coarse.values[coarse.lattice.index((i + (c & 1)) / 2, (j + (c >> 1 & 1)) / 2,
                                                    (k + (c >> 2)) / 2)];
        values[lattice.index(i, j, k)] = sum / 8;
      }
  });
  return values;
}

/// Where the surface meets a plane at an oblique angle, the distance within the plane is larger than the
/// distance to the surface. Where the function is flat, slopes are kept.
PlaneSlopes measuredSlopes(const PlaneSet& planes, const PlateSurface& surface, PlaneSlopes slopes) {
  tbb::parallel_for(size_t(0), slopes.size(), [&](size_t i) {
    const PlaneSection& s = planes.sections[i];
    for (size_t e = 0; e < s.edges.size(); ++e) {
      const Vec3d middle = s.frame.toWorld(0.5 * (s.edges[e].a + s.edges[e].b));
      const Vec3d g = gradientAt(surface.lattice, surface.values, cellPoint(surface.lattice, middle));
      const double whole = g.length(), across = g.dot(s.frame.normal);
      if (whole > 1e-6)
        slopes[i][e] = float(
            std::clamp(std::sqrt(std::max(0.0, 1 - across * across / (whole * whole))), kLeastSlope, 1.0));
    }
  });
  return slopes;
}

void markAround(const Lattice& lattice, const Vec3d& p, int reach, NodeMarks& on) {
  const openvdb::Coord c = lattice.coordOf(cellPoint(lattice, p).cell);
  for (int k = c[2] - reach + 1; k <= c[2] + reach; ++k)
    for (int j = c[1] - reach + 1; j <= c[1] + reach; ++j)
      for (int i = c[0] - reach + 1; i <= c[0] + reach; ++i)
        if (lattice.holds({i, j, k})) on[lattice.index(i, j, k)] = true;
}

/// The marked nodes that may be solved for: those at least two nodes from the border.
std::vector<std::uint32_t> markedNodes(const Lattice& lattice, const NodeMarks& on) {
  std::vector<std::vector<std::uint32_t>> slabs(lattice.size[2]);
  tbb::parallel_for(2, lattice.size[2] - 2, [&](int k) {
    for (int j = 2; j < lattice.size[1] - 2; ++j)
      for (size_t n = lattice.index(2, j, k), end = n + lattice.size[0] - 4; n < end; ++n)
        if (on[n]) slabs[k].push_back(std::uint32_t(n));
  });
  size_t count = 0;
  for (const auto& slab : slabs) count += slab.size();
  std::vector<std::uint32_t> active;
  active.reserve(count);
  for (const auto& slab : slabs) active.insert(active.end(), slab.begin(), slab.end());
  return active;
}

/// Nodes near the current surface or near a contour.
std::vector<std::uint32_t> activeNodes(const PlaneSet& planes, const PlateSurface& surface) {
  const Lattice& lattice = surface.lattice;
  if (isSolvedWhole(lattice)) return markedNodes(lattice, NodeMarks(lattice.count(), true));
  const double band = kBandNodes * lattice.spacing;
  NodeMarks on(lattice.count(), false);
  for (size_t n = 0; n < on.size(); ++n)
    if (std::abs(surface.values[n]) < band) on[n] = true;
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges)
      markAround(lattice, planes.world(int(i), e.a), kContourReach, on);
  return markedNodes(lattice, on);
}

/// Far from the contours no condition fixes the surface, but a plane still tells inside from outside. Solves
/// again around pixels that contradict their plane, until there are none or kVerdictRounds are over.
PlateSurface withVerdicts(const PlaneSet& planes, int stride, const PlateSettings& settings,
                          std::vector<PlateDatum> data, PlateSurface surface) {
  NodeMarks on(surface.lattice.count(), true);
  for (int round = 0; round < kVerdictRounds; ++round) {
    const BrokenPixels broken = brokenPixels(planes, surface.lattice, surface.values, on, stride);
    if (broken.at.empty()) break;
    data.insert(data.end(), broken.data.begin(), broken.data.end());
    std::fill(on.begin(), on.end(), false);
    for (const Vec3d& p : broken.at) markAround(surface.lattice, p, int(kBandNodes), on);
    solvePlate(surface.lattice, markedNodes(surface.lattice, on), data, settings, surface.values);
  }
  return surface;
}

/// `done` of `all` levels are done; each has about four times the nodes at the surface of the one before.
void reportLevel(Progress* progress, int done, int all) {
  if (!progress) return;
  if (progress->cancelled()) throw Cancelled();
  progress->report("reconstruct", (std::pow(4.0, done) - 1) / (std::pow(4.0, all) - 1));
}

}  // namespace

PlateSurface plateSurface(const PlaneSet& planes, double voxelSize, Progress* progress) {
  int top = 0;
  while (voxelSize * (2 << top) <= planes.gap) ++top;
  const Lattice finest = finestLattice(planes, voxelSize, top);
  PlaneSlopes slopes;
  for (const PlaneSection& section : planes.sections) slopes.emplace_back(section.edges.size(), 1.0f);
  PlateSurface surface;
  for (int level = top; level >= 0; --level) {
    reportLevel(progress, top - level, top + 1);
    const Lattice lattice = coarser(finest, level);
    surface = {lattice, level == top ? firstGuess(planes, lattice) : refined(surface, lattice)};
    if (level < top) slopes = measuredSlopes(planes, surface, std::move(slopes));
    std::vector<PlateDatum> data = plateData(planes, slopes, lattice, 1 << level);
    PlateSettings settings;
    settings.iterations = isSolvedWhole(lattice) ? kWholeSteps : kBandSteps;
    solvePlate(lattice, activeNodes(planes, surface), data, settings, surface.values);
    surface = withVerdicts(planes, 1 << level, settings, std::move(data), std::move(surface));
  }
  surface.values = zeroOnContours(planes, surface.lattice, std::move(surface.values));
  return surface;
}

}  // namespace slicemorph
