#pragma once

#include "engine/peers/outline_stack.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// Which average of matched contour points an in-between has.
enum class ContourAverageKind {
  kMean,    ///< their weighted mean
  kMedian,  ///< the one of least weighted distance to all (for two objects the heavier one's: it jumps)
  kMode     ///< the weighted mean of those around the one that has most weight near it
};

struct ContourAverageOptions {
  ContourAverageKind kind = ContourAverageKind::kMean;
  int slices = 96;     ///< per object, 2 or more
  int samples = 128;   ///< points per contour, 8 or more
  double width = 0.1;  ///< of kMode: how near is near, in mean radii of the matched contours
};

/// Averages of any number of shapes by their contours [CP89]: all are cut into equally many slices across one axis of
/// the world, contours of a slice are matched through their convex hulls, and matched points are averaged. A contour
/// point belongs to the edge of the hull that closes its bay, at its share of the bay's length; points of two hulls
/// belong together that lie in the same direction from the hulls' centroids.
class ContourAverage {
 public:
  /// `axis`: across the slices, world; zero: that world axis along which the objects' common box is longest.
  /// `voxelSize`: world units. Throws InputError for options out of range and where slices have too many pixels.
  ContourAverage(const std::vector<Object>& objects, double voxelSize, const Vec3d& axis,
                 const ContourAverageOptions& options = {});
  /// A level set named "surface". Throws InputError unless there is one weight per object.
  FloatGrid::Ptr frame(const Weights& weights) const;

 private:
  struct Loop {
    std::vector<std::vector<Vec2d>> of;  ///< per object: matched points
    double radius = 0;                   ///< mean over the objects that have it
  };
  Chart chart_;
  std::vector<std::array<double, 2>> ends_;  ///< per object: along the axis
  std::vector<std::vector<Loop>> slices_;
  ContourAverageOptions options_;
  double voxelSize_ = 0;
  std::string method_;  ///< as --method has it
};

/// The weighted average of points; weights as for ContourAverage::frame(). `width`: of kMode, in the points' unit.
Vec2d averageOf(ContourAverageKind kind, const std::vector<Vec2d>& points, const Weights& weights,
                double width);

/// `count` points of a closed contour, anticlockwise: those that belong to points of its convex hull in equally many
/// directions from the hull's centroid.
std::vector<Vec2d> hullSamples(const std::vector<Vec2d>& contour, int count);

}  // namespace slicemorph
