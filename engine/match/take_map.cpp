#include "engine/match/take_map.h"

#include "engine/match/fold_guard.h"
#include "engine/match/map_overlap.h"
#include "engine/numerics/smoothstep.h"

#include <cstdio>
#include <utility>

namespace slicemorph {

TakenMap takeAsFarAsBetter(const MatchObjects& objects, Matching matching, const Displacements& map,
                           const GainWanted& wanted, const std::string& name) {
  const double overlap = mapOverlap(objects, map);
  const double share = smoothstep(overlap - matching.overlap, wanted.none, wanted.all);
  char text[96];
  std::snprintf(text, sizeof text, ": overlap %.3f, taken to %.0f %%", overlap, 100 * share);
  matching.notes.push_back({"match.map-tried", Severity::kDetail, "", name + text});
  if (share == 0) return {std::move(matching), 0, overlap};
  if (share == 1) {
    matching.map = map;
    matching.overlap = overlap;
    return {std::move(matching), 1, overlap};
  }
  Displacements blended = resampled(matching.map, map.lattice);
  for (size_t k = 0; k < objects.count(); ++k)
    for (size_t i = 0; i < map.lattice.count(); ++i)
      blended.of[k][i] += float(share) * (map.of[k][i] - blended.of[k][i]);
  removeFolds(blended);
  matching.map = std::move(blended);
  matching.overlap = mapOverlap(objects, matching.map);
  return {std::move(matching), share, overlap};
}

}  // namespace slicemorph
