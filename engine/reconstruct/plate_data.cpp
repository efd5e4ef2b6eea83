#include "engine/reconstruct/plate_data.h"

#include "engine/reconstruct/plane_profile.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

using openvdb::Coord;

constexpr size_t kWholeLatticeNodes = 60000;  // 39 a side: lattices up to this size are solved as a whole

// How strongly the contours, and the planes' distances around them, are enforced against the bending of one
// node. Measured on tori and slanted tubes: stronger plane weights make tori rounder (error of 0.08 % of the
// tube's radius at 3, 0.33 % at 0.3) but slanted tubes more wavy (5.2 % and 3.9 %).
constexpr double kContourWeight = 30;
constexpr double kPlaneWeight = 1;
constexpr double kCapWeight = 0.3;   ///< of the conditions beyond the ends
constexpr double kLeastVerdict = 1;  ///< nodes: closer to the contours, their own data decide
constexpr double kProfileGaps = 2;   ///< how far from a contour its plane's profile is solved, in gaps

/// The distance to the surface is at most the distance to any contour.
double bounded(const PlaneSet& planes, int plane, const Vec3d& p, double distance) {
  for (int j = 0; j < int(planes.sections.size()); ++j) {
    if (j == plane || planes.images[j].distance.empty()) continue;
    const PlaneContours& frame = planes.sections[j].frame;
    const double height = std::abs(frame.height(p));
    if (height < distance)
      distance = std::min(distance, std::hypot(height, planes.images[j].at(frame.toPlane(p))));
  }
  return distance;
}

/// The conditions that one plane imposes on one lattice.
class PlaneData {
 public:
  PlaneData(const PlaneSet& planes, int plane, const Lattice& lattice)
      : planes_(planes), plane_(plane), lattice_(lattice) {}

  void addContours() {
    for (const PlaneSection::Edge& e : planes_.sections[plane_].edges) {
      const double length = (e.b - e.a).length();
      const float weight = float(0.5 * kContourWeight * length / lattice_.spacing);
      add(planes_.world(plane_, e.a), 0, weight);
      add(planes_.world(plane_, 0.5 * (e.a + e.b)), 0, weight);
    }
  }

  void addPixels(const std::vector<float>& slopes, int stride) {
    const PlaneImage& image = planes_.images[plane_];
    const PlaneContours& frame = planes_.sections[plane_].frame;
    if (image.distance.empty()) return;
    const double reach = isSolvedWhole(lattice_) ? 1e30 : kBandNodes * lattice_.spacing;
    const double bent = std::max(kProfileGaps * planes_.gap, 6 * image.pixel);
    const std::vector<float> profile = planeProfile(image, slopes, bent);
    for (int j = 0; j < image.height; j += stride)
      for (int i = 0; i < image.width; i += stride) {
        const size_t n = size_t(j) * image.width + i;
        const double d = image.distance[n];
        if (std::abs(d) > reach) continue;
        const Vec3d p = frame.toWorld(image.position(i, j));
        const double target = std::copysign(bounded(planes_, plane_, p, std::abs(profile[n])), d);
        const double fade = lattice_.spacing / (lattice_.spacing + std::abs(d));
        add(p, target, kPlaneWeight * fade * fade);
        if (d < planes_.gap) addCaps(p, d);
      }
  }

  std::vector<PlateDatum> takeData() { return std::move(data_); }

 private:
  /// Adds "outside" conditions on two virtual planes beyond an end.
  void addCaps(const Vec3d& p, double d) {
    for (int side : {-1, 1}) {
      if (!planes_.endsAt(plane_, p, side)) continue;
      const double height = planes_.capHeight(plane_, p, side);
      for (int k : {1, 2})
        add(p + side * k * height * planes_.sections[plane_].frame.normal,
            std::max(d, 0.0) + (k - 0.5) * height, kCapWeight);
    }
  }

  void add(const Vec3d& p, double target, double weight) {
    data_.push_back({cellPoint(lattice_, p), float(target), float(weight)});
  }

  const PlaneSet& planes_;
  int plane_;
  const Lattice& lattice_;
  std::vector<PlateDatum> data_;
};

/// The plane's pixels that cover its intersection with the box of all contours, including those without
/// contours nearby.
openvdb::CoordBBox pixelsInBox(const PlaneSet& planes, const PlaneContours& frame, double pixel) {
  openvdb::CoordBBox range;
  for (int c = 0; c < 8; ++c) {
    Vec3d corner;
    for (int a = 0; a < 3; ++a) corner[a] = (c >> a & 1 ? planes.box.max() : planes.box.min())[a];
    const Vec2d q = frame.toPlane(corner) / pixel;
    range.expand(Coord::floor(Vec3d(q[0], q[1], 0)));
  }
  return range;
}
}  // namespace

bool isSolvedWhole(const Lattice& lattice) { return lattice.count() <= kWholeLatticeNodes; }

std::vector<PlateDatum> plateData(const PlaneSet& planes, const PlaneSlopes& slopes, const Lattice& lattice,
                                  int stride) {
  std::vector<std::vector<PlateDatum>> parts(planes.sections.size());
  tbb::parallel_for(size_t(0), parts.size(), [&](size_t i) {
    PlaneData plane(planes, int(i), lattice);
    plane.addContours();
    plane.addPixels(slopes[i], stride);
    parts[i] = plane.takeData();
  });
  size_t count = 0;
  for (const auto& part : parts) count += part.size();
  std::vector<PlateDatum> data;
  data.reserve(count);
  for (std::vector<PlateDatum>& part : parts) {
    data.insert(data.end(), part.begin(), part.end());
    std::vector<PlateDatum>().swap(part);
  }
  return data;
}

BrokenPixels brokenPixels(const PlaneSet& planes, const Lattice& lattice, const std::vector<float>& values,
                          const NodeMarks& on, int stride) {
  std::vector<std::vector<std::pair<Vec3d, double>>> parts(planes.sections.size());
  const openvdb::BBoxd near(planes.box.min() - Vec3d(lattice.spacing),
                            planes.box.max() + Vec3d(lattice.spacing));
  tbb::parallel_for(size_t(0), parts.size(), [&](size_t plane) {
    const PlaneImage& image = planes.images[plane];
    const double pixel = stride * planes.step;
    const openvdb::CoordBBox range = pixelsInBox(planes, planes.sections[plane].frame, pixel);
    for (int j = range.min()[1]; j <= range.max()[1]; ++j)
      for (int i = range.min()[0]; i <= range.max()[0]; ++i) {
        const Vec2d q = pixel * Vec2d(i, j);
        const Vec3d p = planes.world(int(plane), q);
        const CellPoint point = cellPoint(lattice, p);
        if (!on[point.cell] || !near.isInside(p)) continue;
        const double value = valueAt(lattice, values, point), d = image.at(q);
        if ((value < 0) == (d < 0) || std::abs(d) <= kLeastVerdict * lattice.spacing) continue;
        const double target =
            bounded(planes, int(plane), p, std::min(std::abs(d), kBandNodes * lattice.spacing));
        parts[plane].emplace_back(p, std::copysign(target, d));
      }
  });
  BrokenPixels broken;
  for (const auto& part : parts)
    for (const auto& [p, target] : part) {
      broken.at.push_back(p);
      broken.data.push_back({cellPoint(lattice, p), float(target), float(kPlaneWeight)});
    }
  return broken;
}

}  // namespace slicemorph
