#include "engine/match/agreement.h"

#include "engine/match/map_overlap.h"
#include "engine/match/refine.h"
#include "engine/match/start_matching.h"

#include <utility>

namespace slicemorph {

Agreement quickAgreement(const Fields& fields, const Frames& frames, const MorphOptions& options) {
  MatchObjects objects = measureObjects(fields, {}, frames.charts, options.features);
  objects.overlapSpacing = MatchObjects::kQuickLook;
  objects.guides.lines.clear();
  const TracedObjects traced = traceObjects(sliceAtEqualPositions(objects, options.slices));
  MatchingStart start = startMatching(objects, traced, options.samples);
  const Matching matching = triedQuickly(objects, std::move(start.matching));
  return {start.overlapBefore, matching.overlap, mapStrain(objects, matching.map)};
}

}  // namespace slicemorph
