#include "engine/match/match_objects.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

/// Margin around the objects' box, fraction of `size`, for what maps move beyond it. Chosen by hand.
constexpr double kMargin = 0.3;

MatchSurface sampledSurface(const Fields& fields, const std::vector<Chart>& charts) {
  MatchSurface surface{fields, std::vector<ChartSamples>(fields.size())};
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) {
    if (fields[k]) surface.samples[k] = chartSamples(*fields[k], charts[k]);
  });
  return surface;
}

}  // namespace

openvdb::BBoxd MatchObjects::reach() const {
  const Vec3d margin(kMargin * size);
  return {box.min() - margin, box.max() + margin};
}

int MatchObjects::ofEach(int samples) const {
  return std::max(samples * 2 / int(std::max<size_t>(count(), 2)), 1);
}

double MatchObjects::smallestVoxel() const {
  double voxel = std::numeric_limits<double>::max();
  for (size_t k = 0; k < count(); ++k) {
    const Vec3d& scale = charts[k].scale;
    voxel = std::min(voxel, shape.fields[k]->voxelSize() / std::max({scale[0], scale[1], scale[2]}));
  }
  return voxel;
}

MatchObjects measureObjects(const Fields& fields, const std::vector<Fields>& inner,
                            const std::vector<Chart>& charts, const std::vector<Feature>& features) {
  MatchObjects objects;
  objects.charts = charts;
  objects.shape = sampledSurface(fields, charts);
  for (const Fields& surface : inner) objects.inner.push_back(sampledSurface(surface, charts));
  objects.features = features;
  objects.guides = placeFeatures(features, fields, charts);
  objects.boxes.resize(fields.size());
  for (size_t k = 0; k < fields.size(); ++k)
    for (const Vec3d& p : objects.shape.samples[k].points.position) objects.boxes[k].expand(p);
  for (const openvdb::BBoxd& own : objects.boxes) objects.box.expand(own);
  const Vec3d e = objects.box.extents();
  objects.size = std::cbrt(e[0] * e[1] * e[2]);
  return objects;
}

}  // namespace slicemorph
