#include "engine/sections/place_sections.h"

#include "engine/sections/object_boxes.h"
#include "engine/volume/moments.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::CoordBBox;

constexpr int kMarginPixels = 3;  // on every side; the header promises it

/// A grid's object: boxes in its index space, and the affine map from there to the world.
struct Body {
  Mat3d jacobian;  ///< world direction = jacobian * index direction
  Vec3d offset;
  std::vector<CoordBBox> boxes;

  Vec3d toWorld(const Vec3d& index) const { return jacobian * index + offset; }
  Vec3d centre(const CoordBBox& box) const {
    return toWorld((box.min().asVec3d() + box.max().asVec3d()) / 2);
  }
};

Body bodyOf(const openvdb::GridBase& grid) {
  if (!grid.transform().isLinear())
    throw InputError("grid '" + grid.getName() + "' has a frustum transform; only linear ones can be sliced");
  Body body;
  body.offset = grid.indexToWorld(Vec3d(0.0));
  for (int a = 0; a < 3; ++a) {
    Vec3d unit(0.0);
    unit[a] = 1;
    body.jacobian.setCol(a, grid.indexToWorld(unit) - body.offset);
  }
  body.boxes = objectBoxes(grid);
  return body;
}

std::vector<Body> bodiesOf(const openvdb::GridCPtrVec& grids) {
  std::vector<Body> bodies;
  std::string names;
  bool any = false;
  for (const auto& grid : grids) {
    bodies.push_back(bodyOf(*grid));
    any = any || !bodies.back().boxes.empty();
    names += (names.empty() ? "'" : ", '") + grid->getName() + "'";
  }
  if (!any)
    throw GeometryError((grids.size() == 1 ? "grid " : "grids ") + names +
                        (grids.size() == 1 ? " is" : " are") + " empty: there is nothing to slice");
  return bodies;
}

void checkCount(int count) {
  if (count < 1 || count > 100000)
    throw InputError("slices " + std::to_string(count) + ": must be 1 to 100000");
}

double pixelOf(const openvdb::GridCPtrVec& grids, double wanted) {
  if (!(wanted >= 0) || !std::isfinite(wanted))
    throw InputError("pixel size " + std::to_string(wanted) + ": must be above 0");
  if (wanted > 0) return wanted;
  double smallest = std::numeric_limits<double>::max();
  for (const auto& grid : grids) {
    const Vec3d voxel = grid->voxelSize();
    smallest = std::min({smallest, voxel.x(), voxel.y(), voxel.z()});
  }
  return smallest;
}

struct Extents {
  Vec3d lo{std::numeric_limits<double>::max()}, hi{-std::numeric_limits<double>::max()};

  void add(const Vec3d& point, const Vec3d& reach) {
    lo = openvdb::math::minComponent(lo, point - reach);
    hi = openvdb::math::maxComponent(hi, point + reach);
  }
  void add(const Extents& other) {
    lo = openvdb::math::minComponent(lo, other.lo);
    hi = openvdb::math::maxComponent(hi, other.hi);
  }
  Vec3d middle() const { return (lo + hi) / 2; }
  Vec3d size() const { return hi - lo; }
};

/// Sets a plane's pixel size and number of pixels, for an area of `across` by `down` world units plus the
/// margin. Throws InputError for too many pixels.
void setSize(SectionPlane& plane, double across, double down, double pixel) {
  const double width = std::ceil(across / pixel) + 2 * kMarginPixels;
  const double height = std::ceil(down / pixel) + 2 * kMarginPixels;
  if (!(width * height <= double(1 << 28)))
    throw InputError("pixel size " + std::to_string(pixel) +
                     ": a slice would have more than 2^28 pixels; choose a larger one");
  plane.pixelSize = pixel;
  plane.width = int(width);
  plane.height = int(height);
}

/// Covariance of all bodies in world space, weighted by volume.
Mat3d covarianceOf(const std::vector<Body>& bodies) {
  double total = 0;
  Vec3d first(0.0);
  Mat3d second = Mat3d::zero();
  for (const Body& body : bodies) {
    const double voxel = std::abs(body.jacobian.det());
    for (const CoordBBox& box : body.boxes) {
      const Vec3d dim = box.dim().asVec3d(), centre = body.centre(box);
      const double weight = voxel * dim.x() * dim.y() * dim.z();
      total += weight;
      first += weight * centre;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          double own = 0;
          for (int a = 0; a < 3; ++a) own += body.jacobian(r, a) * body.jacobian(c, a) * dim[a] * dim[a] / 12;
          second(r, c) += weight * (centre[r] * centre[c] + own);
        }
    }
  }
  const Vec3d mean = first / total;
  Mat3d covariance = second * (1 / total);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) covariance(r, c) -= mean[r] * mean[c];
  return covariance;
}

/// Of the two directions of an axis, the one whose largest component is positive.
Vec3d directed(const Vec3d& axis) {
  return axis[int(openvdb::math::MaxIndex(openvdb::math::Abs(axis)))] < 0 ? -axis : axis;
}

/// The world axis most nearly perpendicular to `normal`, made orthogonal to it.
Vec3d acrossOf(const Vec3d& normal) {
  const Vec3d size = openvdb::math::Abs(normal);
  Vec3d axis(0.0);
  axis[size[0] <= size[1] && size[0] <= size[2] ? 0 : (size[1] <= size[2] ? 1 : 2)] = 1;
  return (axis - normal * axis.dot(normal)).unit();
}

/// In-plane axes and normal, as columns.
Mat3d planeAxes(const Vec3d& normal, const Vec3d& across) {
  Mat3d frame;
  frame.setCol(0, across);
  frame.setCol(1, normal.cross(across));
  frame.setCol(2, normal);
  return frame;
}

Mat3d axesAlong(const std::vector<Body>& bodies, const Vec3d& wanted) {
  if (!std::isfinite(wanted.lengthSqr())) throw InputError("slicing axis: must be three finite numbers");
  if (wanted.lengthSqr() > 0) return planeAxes(wanted.unit(), acrossOf(wanted.unit()));
  const Mat3d axes = principalAxes(covarianceOf(bodies)).axes;
  return planeAxes(directed(axes.col(0)), directed(axes.col(1)));
}

/// The bodies' extents along the columns of `frame`, world units.
Extents extentsAlong(const std::vector<Body>& bodies, const Mat3d& frame) {
  Extents extents;
  for (const Body& body : bodies) {
    // Each extent is a linear function of the index position, so a box reaches the sum of |coefficients| *
    // half size to either side.
    const Mat3d linear = frame.transpose() * body.jacobian;
    for (const CoordBBox& box : body.boxes) {
      const Vec3d half = box.dim().asVec3d() / 2;
      Vec3d reach;
      for (int a = 0; a < 3; ++a) reach[a] = openvdb::math::Abs(linear.row(a)).dot(half);
      extents.add(frame.transpose() * body.centre(box), reach);
    }
  }
  return extents;
}

/// The bodies' extents in chart space: those of their boxes' corner voxels, plus half a voxel.
Extents extentsInChart(const std::vector<Body>& bodies, const Chart& chart) {
  Extents all;
  for (const Body& body : bodies) {
    double reach = 0;
    for (int a = 0; a < 3; ++a) reach += body.jacobian.col(a).length() / 2;
    const Vec3d margin = reach / chart.scale;
    all.add(tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, body.boxes.size(), 256), Extents(),
        [&](const tbb::blocked_range<size_t>& range, Extents extents) {
          for (size_t n = range.begin(); n < range.end(); ++n) {
            const openvdb::Coord &lo = body.boxes[n].min(), &hi = body.boxes[n].max();
            for (int corner = 0; corner < 8; ++corner) {
              bool same = false;  // as an earlier corner: the box is one voxel thick
              Vec3d index;
              for (int a = 0; a < 3; ++a) {
                const bool far = corner >> a & 1;
                index[a] = far ? hi[a] : lo[a];
                same = same || (far && lo[a] == hi[a]);
              }
              if (!same) extents.add(chart.toChart(body.toWorld(index)), margin);
            }
          }
          return extents;
        },
        [](Extents a, const Extents& b) {
          a.add(b);
          return a;
        }));
  }
  return all;
}

/// Adds the points where the edges of a box cross a plane, in the plane's axes.
void addCut(const Body& body, const CoordBBox& box, const Vec3d& origin, const Mat3d& frame,
            Extents& extents) {
  const Vec3d centre = frame.transpose() * (body.centre(box) - origin);
  const Mat3d linear = frame.transpose() * body.jacobian;
  const Vec3d half = box.dim().asVec3d() / 2;
  if (std::abs(centre.z()) > openvdb::math::Abs(linear.row(2)).dot(half)) return;
  Vec3d corner[8];
  for (int c = 0; c < 8; ++c)
    corner[c] = centre + linear * Vec3d(c & 1 ? half[0] : -half[0], c & 2 ? half[1] : -half[1],
                                        c & 4 ? half[2] : -half[2]);
  for (int c = 0; c < 8; ++c)
    for (int bit = 1; bit < 8; bit *= 2) {
      const Vec3d &a = corner[c], &b = corner[c | bit];
      if ((c & bit) || (a.z() < 0) == (b.z() < 0)) continue;
      extents.add(a + (b - a) * (a.z() / (a.z() - b.z())), Vec3d(0.0));
    }
}

std::string missed(const std::vector<Body>& bodies, size_t number, const PlaneInSpace& plane) {
  const Extents box = extentsAlong(bodies, Mat3d::identity());
  std::ostringstream text;
  const auto put = [&](const Vec3d& v) { text << v[0] << "," << v[1] << "," << v[2]; };
  text << "plane " << number << " (";
  put(plane.origin), text << "/", put(plane.normal);
  text << ") does not cut the volume, which lies from ";
  put(box.lo), text << " to ", put(box.hi);
  return text.str();
}

SectionPlane numbered(size_t n, size_t count) {
  SectionPlane plane;
  plane.index = int(n);
  plane.count = int(count);
  plane.u = (2.0 * double(n) + 1) / double(count) - 1;
  return plane;
}

void setAxes(SectionPlane& plane, const Mat3d& frame) {
  plane.xAxis = frame.col(0);
  plane.yAxis = frame.col(1);
  plane.normal = frame.col(2);
}

/// Moves the first pixel so that `centre` is at the image's centre.
void centreOn(SectionPlane& plane, const Vec3d& centre) {
  plane.origin = centre - plane.pixelSize * (0.5 * (plane.width - 1) * plane.xAxis +
                                             0.5 * (plane.height - 1) * plane.yAxis);
}

}  // namespace

std::vector<SectionPlane> sectionPlanes(const openvdb::GridCPtrVec& grids, const SectionOptions& options) {
  checkCount(options.count);
  const double pixel = pixelOf(grids, options.pixelSize);
  const std::vector<Body> bodies = bodiesOf(grids);
  const Mat3d frame = axesAlong(bodies, options.axis);
  const Extents extents = extentsAlong(bodies, frame);
  std::vector<SectionPlane> planes;
  for (int n = 0; n < options.count; ++n) {
    SectionPlane plane = numbered(size_t(n), size_t(options.count));
    setAxes(plane, frame);
    setSize(plane, extents.size().x(), extents.size().y(), pixel);
    centreOn(plane, frame * (extents.middle() + Vec3d(0, 0, plane.u * extents.size().z() / 2)));
    planes.push_back(plane);
  }
  return planes;
}

std::vector<SectionPlane> sectionPlanesAlong(const Chart& spine, const openvdb::GridCPtrVec& grids, int count,
                                             double pixelSize) {
  checkCount(count);
  const double pixel = pixelOf(grids, pixelSize);
  const Extents extents = extentsInChart(bodiesOf(grids), spine);
  const Vec3d middle = extents.middle(), size = extents.size();
  std::vector<SectionPlane> planes;
  for (int n = 0; n < count; ++n) {
    SectionPlane plane = numbered(size_t(n), size_t(count));
    const double z0 = middle[0] + plane.u * size[0] / 2;
    const Mat3d axes = spine.axes * spine.bend.at(z0).frame;
    setAxes(plane, planeAxes(axes.col(0), axes.col(1)));
    setSize(plane, size[1] * spine.scale[1], size[2] * spine.scale[2], pixel);
    centreOn(plane, spine.toWorld({z0, middle[1], middle[2]}));
    planes.push_back(plane);
  }
  return planes;
}

std::vector<SectionPlane> sectionPlanesAt(const std::vector<PlaneInSpace>& given,
                                          const openvdb::GridCPtrVec& grids, double pixelSize) {
  const double pixel = pixelOf(grids, pixelSize);
  const std::vector<Body> bodies = bodiesOf(grids);
  std::vector<SectionPlane> planes;
  for (size_t n = 0; n < given.size(); ++n) {
    const Mat3d frame = planeAxes(given[n].normal.unit(), acrossOf(given[n].normal.unit()));
    Extents cut;
    for (const Body& body : bodies)
      for (const CoordBBox& box : body.boxes) addCut(body, box, given[n].origin, frame, cut);
    if (cut.lo.x() > cut.hi.x()) throw InputError(missed(bodies, n + 1, given[n]));
    SectionPlane plane = numbered(n, given.size());
    setAxes(plane, frame);
    setSize(plane, cut.size().x() + pixel, cut.size().y() + pixel, pixel);
    // A whole number of pixels from the given origin.
    const double right = std::floor(cut.lo.x() / pixel) - kMarginPixels;
    const double down = std::floor(cut.lo.y() / pixel) - kMarginPixels;
    plane.origin = given[n].origin + pixel * (right * plane.xAxis + down * plane.yAxis);
    planes.push_back(plane);
  }
  return planes;
}

}  // namespace slicemorph
