#include "engine/rebuild/match_depths.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

using openvdb::Vec3s;

MatchDepths::MatchDepths(const std::vector<CarriedImage>& images, const ImageNodes& nodes)
    : images_(images), nodes_(nodes) {
  const bool all = std::all_of(images.begin(), images.end(), [](const CarriedImage& c) { return c.field; });
  if (!all || images.size() < 2) return;
  for (const CarriedImage& c : images) {
    samplers_.emplace_back(*c.field);
    reach_ += float(c.weight * c.size * kReach * c.field->voxelSize());
  }
  findCells();
}

void MatchDepths::measure(std::vector<Position>& positions) const {
  for (size_t c = 0; c < images_.size(); ++c) positions[c].distance = samplers_[c](positions[c].at);
}

/// A point of a segment is at most half the segment's length away from the nearer end, and distances change
/// by at most 1 per unit, which bounds how near the surface can be.
bool MatchDepths::near(const std::vector<Position>& first, const std::vector<Position>& last) const {
  const bool inside = first[0].distance < 0;
  for (size_t c = 0; c < images_.size(); ++c) {
    const float a = first[c].distance, b = last[c].distance;
    if ((a < 0) != inside || (b < 0) != inside) return true;
    const float nearest = std::min(std::abs(a), std::abs(b)) - 0.5f * (last[c].at - first[c].at).length();
    if (float(images_[c].size) * nearest < reach_) return true;
  }
  return false;
}

MatchDepths::Match MatchDepths::match(std::vector<Position>& positions) const {
  Match result;
  float& blended = result.distance;
  for (size_t c = 0; c < images_.size(); ++c)
    blended += float(images_[c].weight * images_[c].size) * positions[c].distance;
  const float fade = std::min(std::max(2 - 2 * std::abs(blended) / reach_, 0.f), 1.f);
  for (size_t c = 0; c < images_.size(); ++c) {
    const float distance = positions[c].distance, voxel = float(images_[c].field->voxelSize());
    const bool otherSide = (distance < 0) != (blended < 0);
    const float wrong = otherSide ? std::min(std::abs(distance) / voxel, 1.f) : 0.f;
    const float share = std::max(fade, wrong);
    if (!(share > 0)) continue;
    const float shift = share * (blended / float(images_[c].size) - distance);
    result.shift += float(images_[c].weight * images_[c].size) * std::abs(shift);
    positions[c].at = moved(c, positions[c], distance + shift);
  }
  return result;
}

/// The position moved towards or away from the surface until its distance is `level`. Moves below 1.5 voxels
/// follow the gradient; longer ones start from the nearest surface point, because the gradient may change on
/// the way. Where the wall is thinner than `level`, the result is at most half a voxel from the surface, on
/// the side of `level`.
Vec3s MatchDepths::moved(size_t c, const Position& position, float level) const {
  const CarriedImage& image = images_[c];
  const DistanceField::Sampler& sampler = samplers_[c];
  const float voxel = float(image.field->voxelSize()), shift = level - position.distance;
  if (std::abs(shift) < 0.05f * voxel) return position.at;
  if (std::abs(shift) < 1.5f * voxel) return position.at + sampler.gradient(position.at) * shift;
  const Vec3s surface(image.field->closest(image.anchor + Vec3d(position.at)) - image.anchor);
  const Vec3s outwards = sampler.gradient(surface), there = surface + outwards * level;
  return (sampler(there) < 0) == (level < 0)
             ? there
             : surface + outwards * std::copysign(std::min(0.5f * voxel, std::abs(level)), level);
}

/// As near(first, last): a point of a cell is at most half the longest diagonal away from a corner.
void MatchDepths::findCells() {
  const NodeMap& map = nodes_.map;
  const openvdb::Coord o = map.origin, n = map.size;
  const size_t count = size_t(n[0]) * n[1] * n[2], images = images_.size();
  std::vector<float> distance(count * images);
  tbb::parallel_for(size_t(0), count, [&](size_t i) {
    for (size_t c = 0; c < images; ++c)
      distance[i * images + c] = samplers_[c].coarse(map.at[i * map.objects + images_[c].shape]);
  });
  near_.assign(count, 0);
  tbb::parallel_for(0, n[2] - 1, [&](int k) {
    for (int j = 0; j + 1 < n[1]; ++j)
      for (int i = 0; i + 1 < n[0]; ++i) {
        size_t corner[8];
        for (int c = 0; c < 8; ++c)
          corner[c] = map.index(o[0] + i + (c & 1), o[1] + j + (c >> 1 & 1), o[2] + k + (c >> 2));
        const bool inside = distance[corner[0] * images] < 0;
        bool near = false;
        for (size_t c = 0; c < images && !near; ++c) {
          float nearest = std::numeric_limits<float>::max(), across = 0;
          for (int d = 0; d < 8; ++d) {
            const float at = distance[corner[d] * images + c];
            nearest = std::min(nearest, (at < 0) == inside ? std::abs(at) : 0.f);
          }
          for (int d = 0; d < 4; ++d) {
            const size_t shape = images_[c].shape;
            const Vec3s diagonal =
                map.at[corner[d] * map.objects + shape] - map.at[corner[7 - d] * map.objects + shape];
            across = std::max(across, diagonal.length());
          }
          near = float(images_[c].size) * (nearest - 0.5f * across) < reach_;
        }
        near_[corner[0]] = near;
      }
  });
}

}  // namespace slicemorph
