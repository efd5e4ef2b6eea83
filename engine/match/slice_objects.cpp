#include "engine/match/slice_objects.h"

#include "engine/match/along_spine.h"

#include <tbb/parallel_for.h>

#include <cstdio>
#include <utility>

namespace slicemorph {

namespace {

/// Least width of a slice's pixels, in voxels. With whole voxels in-betweens of swapped objects differ by .3 voxel, with halves
/// by less than .1 (Morph.SwappedInputsGiveTheSameSurfaces).
constexpr double kPixel = 0.5;

/// `position`: per object and slice, z0 in chart units.
SlicedObjects cutAt(const MatchObjects& objects, SlicePlanes planes,
                    std::vector<std::vector<double>> position) {
  SlicedObjects slices{std::move(planes), std::move(position), {}, {}};
  for (size_t k = 0; k < objects.count(); ++k) {
    SlicePlanes own = slices.planes;
    own.z0 = slices.position[k];
    slices.images.push_back(sampleSlices(*objects.shape.fields[k], objects.charts[k], own));
  }
  return slices;
}

}  // namespace

SlicedObjects sliceObjects(const MatchObjects& objects, int count) {
  SlicePlanes planes = placeSlices(objects.boxes, count, kPixel * objects.smallestVoxel());
  AlongSpine along = matchAlongSpine(objects.shape.fields, objects.charts, planes);
  SlicedObjects slices = cutAt(objects, std::move(planes), std::move(along.position));
  char text[128];
  std::snprintf(text, sizeof text, "slices at equal positions overlap %.3f, matched along the spine %.3f",
                along.before, along.after);
  slices.notes.push_back({"match.along-spine", Severity::kDetail, "", text});
  return slices;
}

SlicedObjects sliceAtEqualPositions(const MatchObjects& objects, int count) {
  SlicePlanes planes = placeSlices(objects.boxes, count, kPixel * objects.smallestVoxel());
  std::vector<std::vector<double>> position(objects.count(), planes.z0);
  return cutAt(objects, std::move(planes), std::move(position));
}

TracedObjects traceObjects(SlicedObjects slices) {
  TracedObjects traced{std::move(slices.planes), std::move(slices.position), {}, std::move(slices.notes)};
  for (const std::vector<SliceImage>& images : slices.images) {
    ContourStack stack(images.size());
    tbb::parallel_for(size_t(0), images.size(),
                      [&](size_t i) { stack[i] = traceContours(images[i], traced.planes); });
    traced.stacks.push_back(std::move(stack));
  }
  return traced;
}

}  // namespace slicemorph
