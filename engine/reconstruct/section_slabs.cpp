#include "engine/reconstruct/section_slabs.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace slicemorph {
namespace {

/// Consecutive slices must have an angle below 75 degrees, whose cosine this is.
constexpr double kLeastCosine = 0.26;
/// Value of `beyond` for positions between slices.
constexpr double kInside = -std::numeric_limits<double>::infinity();

Vec3d middleOf(const SectionPlane& plane) {
  return plane.toWorld(0.5 * (plane.width - 1), 0.5 * (plane.height - 1));
}

Vec3d pixelOf(const SectionPlane& plane, const Vec3d& p) {
  const Vec3d d = (p - plane.origin) / plane.pixelSize;
  return {d.dot(plane.xAxis), d.dot(plane.yAxis), 0};
}

/// Squared distance from the image's centre, world units.
double offCentre(const SectionPlane& plane, const Vec3d& pixel) {
  const Vec3d d(pixel[0] - 0.5 * (plane.width - 1), pixel[1] - 0.5 * (plane.height - 1), 0);
  return d.lengthSqr() * plane.pixelSize * plane.pixelSize;
}

bool holds(const SectionPlane& plane, const Vec3d& pixel) {
  return pixel[0] > -1 && pixel[1] > -1 && pixel[0] < plane.width && pixel[1] < plane.height;
}

}  // namespace

SectionSlabs::SectionSlabs(const std::vector<SectionPlane>& planes, double reach) : planes_(planes) {
  if (planes.size() < 2)
    throw InputError(std::to_string(planes.size()) + " slice; a volume needs two or more");
  for (size_t k = 0; k + 1 < planes.size(); ++k) {
    const SectionPlane &a = planes[k], &b = planes[k + 1];
    const Vec3d offset = middleOf(b) - middleOf(a);
    const Vec3d turned = a.normal.dot(b.normal) < 0 ? -b.normal : b.normal;
    Slab slab;
    slab.along = (a.normal + turned).unit();
    if (slab.along.dot(offset) < 0) slab.along = -slab.along;
    slab.slope[0] = slab.along.dot(a.normal);
    slab.slope[1] = slab.along.dot(b.normal);
    if (a.normal.dot(turned) < kLeastCosine)
      throw InputError(
          "slices " + std::to_string(a.index + 1) + " and " + std::to_string(b.index + 1) +
          " stand across each other: there is nothing between them; slices are to follow each other");
    const double half = 0.5 * std::abs(offset.dot(slab.along));
    if (k == 0) slab.before = half + reach, slab.halfGap[0] = half;
    if (k + 2 == planes.size()) slab.after = half + reach, slab.halfGap[1] = half;
    slabs_.push_back(slab);
  }
  for (size_t k = 0; k < planes.size(); ++k) {
    const Vec3d before = slabs_[std::min(k, slabs_.size() - 1)].along;
    for (int corner = 0; corner < 4; ++corner) {
      const Vec3d p =
          planes[k].toWorld(corner & 1 ? planes[k].width : -1, corner & 2 ? planes[k].height : -1);
      box_.expand(p);
      if (k == 0) box_.expand(p - before * slabs_[0].before);
      if (k + 1 == planes.size()) box_.expand(p + before * slabs_.back().after);
    }
  }
}

void SectionSlabs::near(const Vec3d& centre, double radius, std::vector<size_t>& slabs) const {
  slabs.clear();
  for (size_t k = 0; k < slabs_.size(); ++k) {
    const Slab& slab = slabs_[k];
    // Distances to the two planes along the slab's direction; oblique planes extend the sphere's reach.
    const double first = planes_[k].distance(centre) / slab.slope[0];
    const double second = planes_[k + 1].distance(centre) / slab.slope[1];
    if (first >= -slab.before - radius / std::abs(slab.slope[0]) &&
        second <= slab.after + radius / std::abs(slab.slope[1]))
      slabs.push_back(k);
  }
}

bool SectionSlabs::find(const Vec3d& p, const std::vector<size_t>& slabs, BetweenSections& position) const {
  bool found = false;
  double nearest = 0;
  for (size_t k : slabs) {
    BetweenSections here;
    if (!locate(k, p, here)) continue;
    const double off = offCentre(planes_[k], here.first) + offCentre(planes_[k + 1], here.second);
    if (found && off >= nearest) continue;
    position = here, nearest = off, found = true;
  }
  return found;
}

bool SectionSlabs::locate(size_t k, const Vec3d& p, BetweenSections& position) const {
  const Slab& slab = slabs_[k];
  // How far the point is behind the first plane and in front of the second, along the slab's direction.
  const double behind = planes_[k].distance(p) / slab.slope[0];
  const double before = -planes_[k + 1].distance(p) / slab.slope[1];
  const double gap = behind + before;
  if (behind < -slab.before || before < -slab.after || !(gap > 1e-9 * planes_[k].pixelSize)) return false;
  position.slab = k;
  position.share = behind / gap;
  position.first = pixelOf(planes_[k], p - behind * slab.along);
  position.second = pixelOf(planes_[k + 1], p + before * slab.along);
  if (!holds(planes_[k], position.first) && !holds(planes_[k + 1], position.second)) return false;
  position.beyond = std::max(behind < 0 ? -behind - slab.halfGap[0] : kInside,
                             before < 0 ? -before - slab.halfGap[1] : kInside);
  return true;
}

}  // namespace slicemorph
