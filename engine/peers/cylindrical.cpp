#include "engine/peers/cylindrical.h"

#include "engine/frame/spine_frames.h"
#include "engine/peers/require.h"
#include "engine/peers/ring_mesh.h"
#include "engine/peers/star_rays.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// How rings of rays are laid: those of the first cap, of the middle, of the last cap.
struct RayRings {
  int cap, middle, around;

  RingLayout layout() const { return {2 * cap + middle, around}; }

  /// A ray's place on the axis, -1 to 1 from cap to cap, and its direction in the frame of the axis there.
  struct Ray {
    double along;
    Vec3d direction;
  };
  Ray ray(size_t point) const {
    const RingLayout rings = layout();
    if (point == 0) return {-1, {-1, 0, 0}};
    if (point + 1 == rings.count()) return {1, {1, 0, 0}};
    const int ring = int((point - 1) / size_t(around));
    const double angle = 2 * openvdb::math::pi<double>() * double((point - 1) % size_t(around)) / around;
    const double quarter = openvdb::math::pi<double>() / 2;
    // The angle to the axis: of the caps' tips 0, of their feet and of the middle a right one.
    double polar = quarter, along = double(ring - cap + 1) / (middle + 1) * 2 - 1, side = 1;
    if (ring < cap) polar = quarter * (ring + 1) / cap, along = -1, side = -1;
    if (ring >= cap + middle) polar = quarter * (2 * cap + middle - ring) / cap, along = 1;
    return {along,
            {side * std::cos(polar), std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle)}};
  }
};

/// A place on an axis, world space. Columns of the frame: the axis' direction and the two across it.
struct AxisPlace {
  Vec3d point;
  Mat3d frame;
};

AxisPlace axisAt(const Chart& chart, double along) {
  const Bend::Point on = chart.bend.at(along / chart.scale[0]);
  return {chart.center + chart.axes * (chart.scale[0] * on.point), chart.axes * on.frame};
}

/// The objects' spines; where one has none, straight axes for all of them.
Frames axesOf(const Fields& fields, const std::vector<std::string>& names) {
  const std::optional<LaidFrames> laid = framesAlongSpines(fields, names);
  if (laid) return laid->steady;
  return frameObjects(fields, std::vector<Mat3d>(fields.size(), Mat3d::identity()), MorphOptions());
}

double farthestFromAxis(const DistanceField& field, const Chart& chart) {
  double farthest = 0;
  for (const SurfaceSample& sample : field.samples()) {
    const Vec3d z = chart.toChart(sample.position);
    farthest = std::max(farthest, std::hypot(chart.scale[1] * z[1], chart.scale[2] * z[2]));
  }
  return farthest;
}

/// `farthest`: of a surface from its axis; `longest`: half of an axis.
RayRings ringsFor(double farthest, double longest, double voxelSize) {
  const double around = std::max(std::ceil(2 * openvdb::math::pi<double>() * farthest / voxelSize), 16.0);
  const double middle = std::max(std::ceil(2 * longest / voxelSize), 8.0);
  const double rays = around * (middle + around / 2);
  requireAtMost("--method cylindrical needs a ray for each voxel of a cylinder about an object, which are ",
                rays, CylindricalMorph::kMostRays);
  return {int(around) / 4, int(middle), int(around)};
}

/// Whether what lies at a point belongs to a place on the axis, rather than to another part of a bent object.
bool belongsTo(const AxisPlace& place, const Chart& chart, const Vec3d& point) {
  const Vec3d nearest = axisAt(chart, chart.scale[0] * chart.toChart(point)[0]).point;
  // Of a part of its own the nearest place on the axis is about as near as the ray's.
  return (point - nearest).length() > 0.75 * (point - place.point).length();
}

void requireStarAboutAxis(const std::vector<char>& single, const std::string& name) {
  const size_t bad = size_t(std::count(single.begin(), single.end(), 0));
  if (bad == 0) return;
  throw InputError(
      "--method cylindrical: '" + name + "' is not star-shaped about its axis: " + std::to_string(bad) +
      " of " + std::to_string(single.size()) +
      " rays from it leave the object more than once; use another method, such as --method slices");
}

}  // namespace

CylindricalMorph::CylindricalMorph(const std::vector<Object>& objects, double voxelSize,
                                   const CylindricalOptions& options)
    : voxelSize_(voxelSize) {
  if (!(options.cap >= 0 && options.cap < 1))
    throw InputError("--method cylindrical: cap is " + std::to_string(options.cap) +
                     "; it must be at least 0 and below 1");
  Fields fields;
  std::vector<std::string> names;
  for (const Object& object : objects) {
    fields.push_back(std::make_shared<DistanceField>(object.levelSet));
    names.push_back(object.name);
  }
  const Frames frames = axesOf(fields, names);
  double farthest = 0, longest = 0;
  for (size_t k = 0; k < objects.size(); ++k) {
    const Chart& chart = frames.charts[k];
    farthest = std::max(farthest, farthestFromAxis(*fields[k], chart));
    longest = std::max(longest, frames.halfLength * chart.scale[0]);
  }
  const RayRings rings = ringsFor(farthest, longest, voxelSize);
  capRings_ = rings.cap, middleRings_ = rings.middle, around_ = rings.around;

  for (size_t k = 0; k < objects.size(); ++k) {
    Cylinder cylinder;
    cylinder.chart = frames.charts[k];
    const double half = frames.halfLength * cylinder.chart.scale[0];
    const double cap = options.cap > 0 ? options.cap * half : std::min(cylinder.chart.scale[1], half / 2);
    cylinder.middle = half - cap;
    cylinder.radius.resize(rings.layout().count());
    std::vector<char> single(cylinder.radius.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, single.size(), 256), [&](const auto& range) {
      const DistanceField::Sampler sample(*fields[k]);
      for (size_t i = range.begin(); i != range.end(); ++i) {
        const RayRings::Ray ray = rings.ray(i);
        const AxisPlace place = axisAt(cylinder.chart, ray.along * cylinder.middle);
        const RayHit hit = followRay(*fields[k], sample, place.point, place.frame * ray.direction,
                                     [&](const Vec3d& p) { return belongsTo(place, cylinder.chart, p); });
        single[i] = hit.single;
        cylinder.radius[i] = float(hit.distance);
      }
    });
    requireStarAboutAxis(single, objects[k].name);
    cylinders_.push_back(std::move(cylinder));
  }
}

FloatGrid::Ptr CylindricalMorph::frame(const Weights& weights) const {
  requireWeights(weights, cylinders_.size());
  std::vector<Chart> charts;
  double middle = 0;
  for (size_t k = 0; k < cylinders_.size(); ++k)
    charts.push_back(cylinders_[k].chart), middle += weights[k] * cylinders_[k].middle;
  const Chart chart = blendCharts(charts, weights);
  const RayRings rings{capRings_, middleRings_, around_};
  Mesh mesh;
  mesh.points.resize(rings.layout().count());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, mesh.points.size(), 4096), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const RayRings::Ray ray = rings.ray(i);
      const AxisPlace place = axisAt(chart, ray.along * middle);
      double radius = 0;
      for (size_t k = 0; k < cylinders_.size(); ++k) radius += weights[k] * double(cylinders_[k].radius[i]);
      mesh.points[i] = openvdb::Vec3s(place.point + radius * (place.frame * ray.direction));
    }
  });
  mesh.triangles = rings.layout().triangles();
  return levelSetOfMesh(mesh, voxelSize_);
}

}  // namespace slicemorph
