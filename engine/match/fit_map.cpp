#include "engine/match/fit_map.h"

#include "engine/match/fit_field.h"
#include "engine/match/fold_guard.h"

#include <tbb/parallel_for.h>

namespace slicemorph {

namespace {

/// Steps of a fit on a lattice as fine as kFineSpacing, a share of the objects' size, and on coarser ones, which finer ones
/// follow. Over eight pairs of meshes 80 steps on all, or solutions that had converged, gave no better overlaps; with 40
/// on the finest a blade loses 6 % of its volume on its way to a creature, not 5.
constexpr int kFineSteps = 80, kCoarseSteps = 40;
constexpr double kFineSpacing = 0.055;

/// The values that fields added to a base must have to meet the correspondences.
Sites sitesOn(const Displacements& base, const std::vector<Correspondence>& points) {
  const size_t objects = base.of.size();
  Sites sites;
  sites.value.resize(objects);
  for (const Correspondence& c : points) {
    const Vec3d& s = c.middle;
    sites.position.push_back(s);
    sites.weight.push_back(c.weight);
    for (size_t k = 0; k < objects; ++k) sites.value[k].push_back(c.at[k] - s - base.at(k, s));
  }
  return sites;
}

}  // namespace

Displacements fittedMap(const MatchObjects& objects, const Matching& matching,
                        std::vector<Correspondence> points, const MapFit& fit) {
  const Lattice lattice = objects.lattice(fit.spacing);
  points.insert(points.end(), objects.guides.marks.begin(), objects.guides.marks.end());
  const Displacements base = resampled(matching.base, lattice);
  Displacements start = resampled(matching.map, lattice);
  for (size_t k = 0; k < objects.count(); ++k)
    tbb::parallel_for(size_t(0), lattice.count(), [&](size_t i) { start.of[k][i] -= base.of[k][i]; });
  Displacements map = fitFields(lattice, sitesOn(matching.base, points), fit.stiffness, start,
                                fit.spacing < kFineSpacing ? kFineSteps : kCoarseSteps);
  // A base that is finer than the fields, as after limbs were followed, keeps its own lattice.
  const bool finer = matching.base.lattice.spacing < lattice.spacing;
  if (finer) map = resampled(map, matching.base.lattice);
  const Displacements& under = finer ? matching.base : base;
  for (size_t k = 0; k < objects.count(); ++k)
    tbb::parallel_for(size_t(0), map.lattice.count(), [&](size_t i) { map.of[k][i] += under.of[k][i]; });
  removeFolds(map);
  return map;
}

}  // namespace slicemorph
