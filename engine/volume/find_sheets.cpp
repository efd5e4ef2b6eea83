#include "engine/volume/find_sheets.h"

#include "engine/volume/mesh_measures.h"
#include "engine/volume/surface_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

using Index = std::uint32_t;

/// Points of a shell at which winding numbers are taken.
constexpr size_t kSamples = 64;
/// Distance from the surface, in the mesh's diagonals: above the rounding of coordinates, below any feature.
constexpr double kBeside = 1e-6;
/// A wall has 0 on one side and 1 on the other, so 1/2 in the mean, or that and a whole number; a sheet a whole
/// number. The limit is half way between.
constexpr double kWall = 0.25;

/// The mean of the winding numbers on both sides.
double windingOf(const SurfacePoint& s, const WindingNumber& winding, double beside) {
  return (winding.at(s.point - beside * s.normal) + winding.at(s.point + beside * s.normal)) / 2;
}

/// The share of a shell's area that is a wall between inside and outside of what `winding` is of.
double wallShare(const std::vector<SurfacePoint>& samples, const WindingNumber& winding, double beside) {
  size_t walls = 0;
  for (const SurfacePoint& s : samples) {
    const double both = windingOf(s, winding, beside);
    walls += std::abs(both - std::floor(both) - 0.5) <= kWall;
  }
  return samples.empty() ? 0 : double(walls) / double(samples.size());
}

}  // namespace

std::vector<size_t> findSheets(const Mesh& mesh, const std::vector<std::vector<Index>>& shells,
                               const WindingNumber& all) {
  const double beside = kBeside * boundsOf(mesh.points).extents().length();
  std::vector<std::vector<SurfacePoint>> samples(shells.size());
  std::vector<char> sheet(shells.size()), open(shells.size());
  tbb::parallel_for(size_t(0), shells.size(), [&](size_t i) {
    samples[i] = sampleSurface(mesh, shells[i], kSamples);
    const bool only = shells[i].size() == mesh.triangles.size();
    const double share = only ? wallShare(samples[i], all, beside)
                              : wallShare(samples[i], WindingNumber(mesh, shells[i]), beside);
    open[i] = share < kLeastEnclosing;
    sheet[i] = open[i] && wallShare(samples[i], all, beside) < kLeastWall;
  });
  // Without the sheets others may be walls no more.
  for (bool more = std::count(sheet.begin(), sheet.end(), 1) > 0; more;) {
    more = false;
    std::vector<Index> kept;
    for (size_t i = 0; i < shells.size(); ++i)
      if (!sheet[i]) kept.insert(kept.end(), shells[i].begin(), shells[i].end());
    const WindingNumber rest(mesh, std::move(kept));
    std::vector<char> now = sheet;
    tbb::parallel_for(size_t(0), shells.size(), [&](size_t i) {
      if (!sheet[i] && open[i]) now[i] = wallShare(samples[i], rest, beside) < kLeastWall;
    });
    more = now != sheet;
    sheet = std::move(now);
  }
  std::vector<size_t> sheets;
  for (size_t i = 0; i < shells.size(); ++i)
    if (sheet[i]) sheets.push_back(i);
  return sheets;
}

}  // namespace slicemorph
