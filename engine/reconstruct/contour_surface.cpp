#include "engine/reconstruct/contour_surface.h"

#include "engine/errors.h"
#include "engine/rebuild/redistance.h"
#include "engine/reconstruct/meet_contours.h"
#include "engine/reconstruct/plane_profile.h"
#include "engine/reconstruct/plane_set.h"
#include "engine/reconstruct/thin_plate.h"
#include "engine/volume/manifold.h"
#include "engine/volume/voxelise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

using openvdb::Coord;

constexpr double kMostNodes = 1.2e8;      // of the finest lattice; about a gigabyte with its images
constexpr double kDefaultNodes = 4e7;     // a default voxel size makes no more
constexpr size_t kWholeBoxNodes = 60000;  // a lattice below that is solved whole

// How strongly the contours, and the planes' distances around them, hold against the bending of one node.
// Measured on tori and slanted tubes: stronger plane weights make tori rounder (0.08 % of the tube's radius at 3, 0.33 %
// at 0.3) and slanted tubes more wavy (5.2 % and 3.9 %).
constexpr double kContourWeight = 30;
constexpr double kPlaneWeight = 1;
constexpr double kCapWeight = 0.3;
constexpr int kWholeSteps = 400, kBandSteps = 40;  // of the solver; the first guess of a band is already close
constexpr double kBandNodes = 5;      // half width of the band of nodes that is solved on fine levels
constexpr double kProfileGaps = 2;    // how far from a contour its plane's profile bends, in gaps
constexpr double kLeastSlope = 0.3;   // of a surface that runs along a plane
constexpr int kMeetingSweeps = 10;

NodeBox finestBox(const PlaneSet& planes, double h, int levels) {
  const double coarse = h * (1 << levels), margin = planes.gap + 3.5 * coarse;
  NodeBox box;
  box.step = h;
  for (int a = 0; a < 3; ++a) {
    box.origin[a] = coarse * std::floor((planes.box.min()[a] - margin) / coarse);
    box.size[a] = (int(std::ceil((planes.box.max()[a] + margin - box.origin[a]) / coarse)) << levels) + 1;
  }
  return box;
}

NodeBox coarser(const NodeBox& box, int level) {
  NodeBox out = box;
  out.step = box.step * (1 << level);
  for (int a = 0; a < 3; ++a) out.size[a] = ((box.size[a] - 1) >> level) + 1;
  return out;
}

/// The planes' distances weighted by how near the planes are, closed beyond the last ones.
double firstGuess(const PlaneSet& planes, const Vec3d& p) {
  int nearest = 0;
  double least = 1e300;
  for (int i = 0; i < int(planes.sections.size()); ++i) {
    const double height = std::abs(planes.sections[i].frame.height(p));
    if (height < least) least = height, nearest = i;
  }
  least = std::max(least, 1e-3 * planes.step);
  double sum = 0, weights = 0;
  for (int i = 0; i < int(planes.sections.size()); ++i) {
    const PlaneContours& frame = planes.sections[i].frame;
    const double height = std::max(std::abs(frame.height(p)), least);
    if (height > 5 * least) continue;
    const double weight = std::pow(least / height, 3);
    const double far = 4 * planes.gap + height;
    sum += weight * std::clamp(planes.images[i].at(frame.toPlane(p)), -far, far);
    weights += weight;
  }
  double value = sum / weights;
  const PlaneContours& frame = planes.sections[nearest].frame;
  const double height = frame.height(p);
  const int side = height < 0 ? -1 : 1;
  const Vec3d foot = p - height * frame.normal;
  if (planes.endsAt(nearest, foot, side))
    value = std::max(value, std::abs(height) - planes.capHeight(nearest, foot, side));
  return value;
}

/// Makes the surface, level by level.
class Reconstruction {
 public:
  Reconstruction(const PlaneSet& planes, double h, Progress* progress) : planes_(planes), progress_(progress) {
    while (h * (2 << top_) <= planes.gap) ++top_;
    finest_ = finestBox(planes, h, top_);
    slopes_.resize(planes.sections.size());
    for (size_t i = 0; i < slopes_.size(); ++i) slopes_[i].assign(planes.sections[i].edges.size(), 1.0f);
  }

  void run() {
    for (int level = top_; level >= 0; --level) {
      check(double(top_ - level) / (top_ + 1));
      const NodeBox box = coarser(finest_, level);
      std::vector<float> values = level == top_ ? guess(box) : refined(box);
      box_ = box, values_ = std::move(values);
      if (level < top_) measureSlopes();
      const std::vector<std::uint32_t> active = activeNodes();
      const std::vector<PlateDatum> data = dataOf(level);
      PlateSettings settings;
      settings.iterations = box.count() <= kWholeBoxNodes ? kWholeSteps : kBandSteps;
      solvePlate(box, active, data, settings, values_);
    }
    meetContours();
  }

  const NodeBox& box() const { return box_; }
  std::vector<float>& values() { return values_; }

 private:
  void check(double share) const {
    if (!progress_) return;
    if (progress_->cancelled()) throw Cancelled();
    progress_->report("reconstruct", share);
  }

  std::vector<float> guess(const NodeBox& box) const {
    std::vector<float> values(box.count());
    tbb::parallel_for(0, box.size[2], [&](int k) {
      for (int j = 0; j < box.size[1]; ++j)
        for (int i = 0; i < box.size[0]; ++i)
          values[box.index(i, j, k)] = float(firstGuess(planes_, box.place({i, j, k})));
    });
    return values;
  }

  /// The coarser level's values on the nodes of half the step, trilinear.
  std::vector<float> refined(const NodeBox& box) const {
    std::vector<float> values(box.count());
    tbb::parallel_for(0, box.size[2], [&](int k) {
      for (int j = 0; j < box.size[1]; ++j)
        for (int i = 0; i < box.size[0]; ++i) {
          float sum = 0;
          for (int c = 0; c < 8; ++c)
            sum += values_[box_.index((i + (c & 1)) / 2, (j + (c >> 1 & 1)) / 2, (k + (c >> 2)) / 2)];
          values[box.index(i, j, k)] = sum / 8;
        }
    });
    return values;
  }

  /// How much of the surface's steepness lies in the plane, at each edge: where the surface meets the plane at an
  /// angle, the distance in the plane is larger than the distance to the surface.
  void measureSlopes() {
    tbb::parallel_for(size_t(0), slopes_.size(), [&](size_t i) {
      const PlaneSection& s = planes_.sections[i];
      for (size_t e = 0; e < s.edges.size(); ++e) {
        const Vec3d middle = s.frame.toWorld(0.5 * (s.edges[e].a + s.edges[e].b));
        const Vec3d g = gradientAt(box_, values_, cellPlace(box_, middle));
        const double whole = g.length(), across = g.dot(s.frame.normal);
        if (whole > 1e-6)
          slopes_[i][e] = float(std::clamp(std::sqrt(std::max(0.0, 1 - across * across / (whole * whole))), kLeastSlope, 1.0));
      }
    });
  }

  /// Nodes near the surface so far or near a contour.
  std::vector<std::uint32_t> activeNodes() const {
    const double band = kBandNodes * box_.step;
    std::vector<char> on(box_.count(), box_.count() <= kWholeBoxNodes);
    if (box_.count() > kWholeBoxNodes) {
      tbb::parallel_for(0, box_.size[2], [&](int k) {
        for (size_t n = box_.index(0, 0, k), end = box_.index(0, 0, k + 1); n < end; ++n)
          on[n] = std::abs(values_[n]) < band;
      });
      for (size_t i = 0; i < planes_.sections.size(); ++i)
        for (const PlaneSection::Edge& e : planes_.sections[i].edges) markAround(planes_.world(int(i), e.a), on);
    }
    std::vector<std::uint32_t> active;
    for (int k = 2; k < box_.size[2] - 2; ++k)
      for (int j = 2; j < box_.size[1] - 2; ++j)
        for (int i = 2; i < box_.size[0] - 2; ++i)
          if (on[box_.index(i, j, k)]) active.push_back(std::uint32_t(box_.index(i, j, k)));
    return active;
  }
  void markAround(const Vec3d& p, std::vector<char>& on) const {
    constexpr int kReach = 3;
    const Coord c = box_.coordOf(cellPlace(box_, p).cell);
    for (int k = c[2] - kReach + 1; k <= c[2] + kReach; ++k)
      for (int j = c[1] - kReach + 1; j <= c[1] + kReach; ++j)
        for (int i = c[0] - kReach + 1; i <= c[0] + kReach; ++i)
          if (i >= 0 && j >= 0 && k >= 0 && i < box_.size[0] && j < box_.size[1] && k < box_.size[2])
            on[box_.index(i, j, k)] = 1;
  }

  std::vector<PlateDatum> dataOf(int level) const {
    std::vector<std::vector<PlateDatum>> parts(planes_.sections.size());
    tbb::parallel_for(size_t(0), parts.size(), [&](size_t i) {
      addContours(int(i), parts[i]);
      addPixels(int(i), 1 << level, parts[i]);
    });
    std::vector<PlateDatum> data;
    for (const auto& part : parts) data.insert(data.end(), part.begin(), part.end());
    return data;
  }
  void addContours(int plane, std::vector<PlateDatum>& data) const {
    for (const PlaneSection::Edge& e : planes_.sections[plane].edges) {
      const double length = (e.b - e.a).length();
      const float weight = float(0.5 * kContourWeight * length / box_.step);
      data.push_back({cellPlace(box_, planes_.world(plane, e.a)), 0, weight});
      data.push_back({cellPlace(box_, planes_.world(plane, 0.5 * (e.a + e.b))), 0, weight});
    }
  }
  void addPixels(int plane, int stride, std::vector<PlateDatum>& data) const {
    const PlaneImage& image = planes_.images[plane];
    const PlaneContours& frame = planes_.sections[plane].frame;
    if (image.distance.empty()) return;
    const bool whole = box_.count() <= kWholeBoxNodes;
    const double reach = whole ? 1e30 : kBandNodes * box_.step;
    const double bent = std::max(kProfileGaps * planes_.gap, 6 * image.pixel);
    const std::vector<float> profile = planeProfile(image, slopes_[plane], bent);
    for (int j = 0; j < image.height; j += stride)
      for (int i = 0; i < image.width; i += stride) {
        const size_t n = size_t(j) * image.width + i;
        const double d = image.distance[n];
        if (std::abs(d) > reach) continue;
        const Vec3d p = frame.toWorld(image.place(i, j));
        const double target = std::copysign(bounded(plane, p, std::abs(profile[n])), d);
        const double fade = box_.step / (box_.step + std::abs(d));
        data.push_back({cellPlace(box_, p), float(target), float(kPlaneWeight * fade * fade)});
        if (d < planes_.gap) addCaps(plane, p, d, data);
      }
  }
  /// The distance to the surface is at most that to any contour.
  double bounded(int plane, const Vec3d& p, double distance) const {
    for (int j = 0; j < int(planes_.sections.size()); ++j) {
      if (j == plane || planes_.images[j].distance.empty()) continue;
      const PlaneContours& frame = planes_.sections[j].frame;
      const double height = std::abs(frame.height(p));
      if (height < distance) distance = std::min(distance, std::hypot(height, planes_.images[j].at(frame.toPlane(p))));
    }
    return distance;
  }
  /// Outside on two virtual planes beyond an end.
  void addCaps(int plane, const Vec3d& p, double d, std::vector<PlateDatum>& data) const {
    for (int side : {-1, 1}) {
      if (!planes_.endsAt(plane, p, side)) continue;
      const double height = planes_.capHeight(plane, p, side);
      for (int k : {1, 2}) {
        const double target = std::max(d, 0.0) + (k - 0.5) * height;
        const Vec3d q = p + side * k * height * planes_.sections[plane].frame.normal;
        data.push_back({cellPlace(box_, q), float(target), float(kCapWeight)});
      }
    }
  }

  /// Takes away what is left of the values on the contours.
  void meetContours() {
    const std::array<std::uint32_t, 8> corners = cornerOffsets(box_);
    std::vector<CellPlace> places;
    for (size_t i = 0; i < planes_.sections.size(); ++i)
      for (const PlaneSection::Edge& e : planes_.sections[i].edges)
        for (const Vec2d& p : {e.a, 0.5 * (e.a + e.b)}) places.push_back(cellPlace(box_, planes_.world(int(i), p)));
    std::vector<float> change(box_.count(), 0), weights(box_.count(), 0);
    for (int sweep = 0; sweep < kMeetingSweeps; ++sweep) {
      std::vector<std::uint32_t> touched;
      for (const CellPlace& place : places) {
        const float rest = float(valueAt(box_, values_, place));
        for (int c = 0; c < 8; ++c) {
          const std::uint32_t n = place.cell + corners[c];
          const float weight = place.weight(c);
          if (weights[n] == 0 && weight > 0) touched.push_back(n);
          weights[n] += weight;
          change[n] += weight * rest;
        }
      }
      for (std::uint32_t n : touched) {
        values_[n] -= change[n] / weights[n];
        change[n] = weights[n] = 0;
      }
    }
  }

  const PlaneSet& planes_;
  Progress* progress_;
  int top_ = 0;
  NodeBox finest_, box_;
  std::vector<float> values_;
  std::vector<std::vector<float>> slopes_;  // by plane and edge
};

/// Turns the sign of pieces (of the inside, and of the outside) that no contour touches; returns how many.
int dropStrays(const PlaneSet& planes, const NodeBox& box, std::vector<float>& values) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(box);
  std::vector<char> seen(box.count(), 0);
  std::vector<std::uint32_t> stack;
  const std::ptrdiff_t step[6] = {1, -1, box.size[0], -box.size[0], std::ptrdiff_t(box.size[0]) * box.size[1],
                                  -std::ptrdiff_t(box.size[0]) * box.size[1]};
  const auto visit = [&](std::uint32_t n) {
    if (!seen[n]) seen[n] = 1, stack.push_back(n);
  };
  const auto spread = [&](std::vector<std::uint32_t>* members) {
    while (!stack.empty()) {
      const std::uint32_t n = stack.back();
      stack.pop_back();
      if (members) members->push_back(n);
      const Coord c = box.coordOf(n);
      for (int d = 0; d < 6; ++d) {
        const int a = d / 2, to = c[a] + (d % 2 ? -1 : 1);
        if (to < 0 || to >= box.size[a]) continue;
        if ((values[n + step[d]] < 0) == (values[n] < 0)) visit(std::uint32_t(n + step[d]));
      }
    }
  };
  visit(0);
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges) {
      const std::uint32_t cell = cellPlace(box, planes.world(int(i), 0.5 * (e.a + e.b))).cell;
      for (std::uint32_t c : corners) visit(cell + c);
    }
  spread(nullptr);
  int strays = 0;
  std::vector<std::uint32_t> members;
  for (std::uint32_t n = 0; n < seen.size(); ++n) {
    if (seen[n]) continue;
    members.clear();
    visit(n);
    spread(&members);
    for (std::uint32_t m : members) values[m] = -values[m];
    ++strays;
  }
  return strays;
}

/// Next to a change of sign the surface is near, whatever the values: where a detail that the coarser levels did not
/// see meets values that they left, these may be large.
void limitAtSurface(const NodeBox& box, std::vector<float>& values) {
  const float most = float(2 * box.step);
  const std::ptrdiff_t step[3] = {1, box.size[0], std::ptrdiff_t(box.size[0]) * box.size[1]};
  for (int k = 1; k < box.size[2] - 1; ++k)
    for (int j = 1; j < box.size[1] - 1; ++j)
      for (int i = 1; i < box.size[0] - 1; ++i) {
        float& v = values[box.index(i, j, k)];
        if (std::abs(v) <= most) continue;
        for (std::ptrdiff_t s : step)
          if (((&v)[s] < 0) != (v < 0) || ((&v)[-s] < 0) != (v < 0)) v = std::copysign(most, v);
      }
}

/// The level set of the lattice's values.
FloatGrid::Ptr levelSetOf(const NodeBox& box, const std::vector<float>& values) {
  const Coord shift = Coord::round(box.origin / box.step), high = shift + box.size - Coord(1);
  const Coord low(shift[0] >> 3, shift[1] >> 3, shift[2] >> 3), count = Coord(high[0] >> 3, high[1] >> 3, high[2] >> 3) - low + Coord(1);
  const float near = float(6 * box.step);
  const auto overNodes = [&](const Coord& origin, const auto& action) {
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < 8; ++z) {
          const Coord c = origin - shift + Coord(x, y, z);
          if (c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && c[0] < box.size[0] && c[1] < box.size[1] && c[2] < box.size[2])
            action(size_t((x * 8 + y) * 8 + z), values[box.index(c[0], c[1], c[2])]);
        }
  };
  std::vector<char> wanted(size_t(count[0]) * count[1] * count[2], 0);
  const auto originOf = [&](size_t b) {
    const Coord c = low + Coord(int(b % count[0]), int(b / count[0] % count[1]), int(b / count[0] / count[1]));
    return Coord(c[0] << 3, c[1] << 3, c[2] << 3);
  };
  tbb::parallel_for(size_t(0), wanted.size(), [&](size_t b) {
    overNodes(originOf(b), [&](size_t, float v) { wanted[b] |= std::abs(v) < near; });
  });
  std::vector<Coord> origins;
  for (size_t b = 0; b < wanted.size(); ++b)
    if (wanted[b]) origins.push_back(originOf(b));
  SparseValues sparse(origins, float(box.step));
  tbb::parallel_for(size_t(0), origins.size(), [&](size_t i) {
    overNodes(origins[i], [&](size_t n, float v) { sparse.leaf(i)[n] = v; });
  });
  return redistance(sparse, *openvdb::math::Transform::createLinearTransform(box.step));
}

double defaultVoxelSize(const PlaneSet& planes) {
  const Sampling s = samplingOf(planes);
  double h = std::min({0.6 * s.edge, s.gap / 3.3, s.extent / 32});
  h = std::max(h, s.extent / 500);
  const openvdb::Vec3d size = planes.box.extents() + Vec3d(4 * planes.gap);
  return std::max(h, std::cbrt(size[0] * size[1] * size[2] / kDefaultNodes));
}

void requireSize(const ContourSet& set, const PlaneSet& planes, double h) {
  if (!(h > 0) || !std::isfinite(h))
    throw InputError("voxel size " + std::to_string(h) + " is no positive number of world units");
  const openvdb::Vec3d size = planes.box.extents() + Vec3d(4 * planes.gap);
  const double nodes = size[0] * size[1] * size[2] / (h * h * h);
  if (nodes > kMostNodes)
    throw InputError(set.name + ": voxel size " + std::to_string(h) + " would make a lattice of " +
                     std::to_string(nodes / 1e6) + " million nodes; at least " +
                     std::to_string(h * std::cbrt(nodes / kMostNodes)) + " is possible");
}

}  // namespace

double contourVoxelSize(const ContourSet& set) {
  std::vector<std::string> notes;
  return defaultVoxelSize(cleanPlanes(set, notes));
}

ContourSurface contourSurface(const ContourSet& set, const ContourSurfaceOptions& options, Progress* progress) {
  ContourSurface out;
  PlaneSet planes = cleanPlanes(set, out.notes);
  out.voxelSize = options.voxelSize != 0 ? options.voxelSize : defaultVoxelSize(planes);
  out.gap = planes.gap;
  requireSize(set, planes, out.voxelSize);
  makeImages(planes, out.voxelSize);
  Reconstruction reconstruction(planes, out.voxelSize, progress);
  reconstruction.run();
  const NodeBox& box = reconstruction.box();
  std::vector<float>& values = reconstruction.values();
  if (const int strays = dropStrays(planes, box, values))
    out.notes.push_back(set.name + ": " + std::to_string(strays) + " pieces that no contour touches left out");
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges) {
      const CellPlace place = cellPlace(box, planes.world(int(i), e.a));
      const double steepness = std::max(gradientAt(box, values, place).length(), 0.1);
      out.farthestContour = std::max(out.farthestContour, std::abs(valueAt(box, values, place)) / steepness);
    }
  limitAtSurface(box, values);
  out.grid = levelSetOf(box, values);
  return out;
}

Mesh contourMesh(const ContourSet& set, const ContourSurface& surface) {
  Mesh mesh = makeManifold(surfaceOf(*surface.grid)).mesh;
  meetContours(set, surface.voxelSize, mesh);
  return mesh;
}

}  // namespace slicemorph
