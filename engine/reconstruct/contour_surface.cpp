#include "engine/reconstruct/contour_surface.h"

#include "engine/rebuild/redistance.h"
#include "engine/reconstruct/meet_contours.h"
#include "engine/reconstruct/plane_profile.h"
#include "engine/reconstruct/plane_set.h"
#include "engine/reconstruct/thin_plate.h"
#include "engine/volume/manifold.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace slicemorph {

namespace {

using openvdb::Coord;

constexpr double kMostNodes = 1.2e8;      // of the finest lattice; about a gigabyte with its images
constexpr double kDefaultNodes = 4e7;     // a default voxel size makes no more
constexpr size_t kWholeBoxNodes = 60000;  // a lattice below that is solved whole

// How strongly the contours, and the planes' distances around them, hold against the bending of one node.
// Measured on tori and slanted tubes: stronger plane weights make tori rounder (0.08 % of the tube's radius
// at 3, 0.33 % at 0.3) and slanted tubes more wavy (5.2 % and 3.9 %).
constexpr double kContourWeight = 30;
constexpr double kPlaneWeight = 1;
constexpr double kCapWeight = 0.3;
constexpr int kWholeSteps = 400,
              kBandSteps = 40;  // of the solver; the first guess of a band is already close
constexpr double kHeardPlanes =
    5;  // planes so many times farther than the nearest have no say in the first guess
constexpr double kLeastHeight = 1e-3;  // voxels: on a plane
constexpr double kBandNodes = 5;       // half width of the band of nodes that is solved on fine levels
constexpr double kLeastVerdict = 1;    // nodes: nearer to the contours, their data hold
constexpr int kContourReach = 3;       // nodes around a contour that are solved wherever the surface is
constexpr double kProfileGaps = 2;     // how far from a contour its plane's profile bends, in gaps
constexpr double kLeastSlope = 0.3;    // of a surface that runs along a plane
constexpr int kMeetingSweeps = 10;
constexpr int kVerdictRounds = 3;  // of solving again around pixels where the surface contradicts their plane

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

/// Of the places in a row, `half` to both sides of `middle`, the planes that any of them asks for its first
/// guess.
std::vector<int> planesAlong(const PlaneSet& planes, const Vec3d& middle, const Vec3d& half) {
  std::vector<double> closest(planes.sections.size());
  double least = 1e300;
  for (size_t i = 0; i < closest.size(); ++i) {
    const PlaneContours& frame = planes.sections[i].frame;
    const double height = std::abs(frame.height(middle)), change = std::abs(half.dot(frame.normal));
    closest[i] = height - change;
    least = std::min(least, height + change);
  }
  least = std::max(least, kLeastHeight * planes.step);
  std::vector<int> out;
  for (int i = 0; i < int(closest.size()); ++i)
    if (closest[i] <= kHeardPlanes * least) out.push_back(i);
  return out;
}

/// The distances of the planes, of which `among` has all near ones, weighted by how near they are; closed
/// beyond the last ones.
double firstGuess(const PlaneSet& planes, const std::vector<int>& among, const Vec3d& p) {
  int nearest = 0;
  double least = 1e300;
  for (int i : among) {
    const double height = std::abs(planes.sections[i].frame.height(p));
    if (height < least) least = height, nearest = i;
  }
  least = std::max(least, kLeastHeight * planes.step);
  double sum = 0, weights = 0;
  for (int i : among) {
    const PlaneContours& frame = planes.sections[i].frame;
    const double height = std::max(std::abs(frame.height(p)), least);
    if (height > kHeardPlanes * least) continue;
    const double share = least / height, weight = share * share * share, far = 4 * planes.gap + height;
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
  Reconstruction(const PlaneSet& planes, double h, Progress* progress)
      : planes_(planes), progress_(progress) {
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
      std::vector<PlateDatum> data = dataOf(level);
      PlateSettings settings;
      settings.iterations = box.count() <= kWholeBoxNodes ? kWholeSteps : kBandSteps;
      solvePlate(box, active, data, settings, values_);
      keepVerdicts(level, settings, data);
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
      constexpr int kTogether = 16;
      for (int j = 0; j < box.size[1]; ++j)
        for (int first = 0; first < box.size[0]; first += kTogether) {
          const int end = std::min(first + kTogether, box.size[0]);
          const Vec3d from = box.place({first, j, k}), to = box.place({end - 1, j, k});
          const std::vector<int> among = planesAlong(planes_, 0.5 * (from + to), 0.5 * (to - from));
          for (int i = first; i < end; ++i)
            values[box.index(i, j, k)] = float(firstGuess(planes_, among, box.place({i, j, k})));
        }
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

  /// How much of the surface's steepness lies in the plane, at each edge: where the surface meets the plane
  /// at an angle, the distance in the plane is larger than the distance to the surface.
  void measureSlopes() {
    tbb::parallel_for(size_t(0), slopes_.size(), [&](size_t i) {
      const PlaneSection& s = planes_.sections[i];
      for (size_t e = 0; e < s.edges.size(); ++e) {
        const Vec3d middle = s.frame.toWorld(0.5 * (s.edges[e].a + s.edges[e].b));
        const Vec3d g = gradientAt(box_, values_, cellPlace(box_, middle));
        const double whole = g.length(), across = g.dot(s.frame.normal);
        if (whole > 1e-6)
          slopes_[i][e] = float(
              std::clamp(std::sqrt(std::max(0.0, 1 - across * across / (whole * whole))), kLeastSlope, 1.0));
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
        for (const PlaneSection::Edge& e : planes_.sections[i].edges)
          markAround(planes_.world(int(i), e.a), kContourReach, on);
    }
    return marked(on);
  }
  /// Those of the marked nodes that may be solved for.
  std::vector<std::uint32_t> marked(const std::vector<char>& on) const {
    std::vector<std::vector<std::uint32_t>> slabs(box_.size[2]);
    tbb::parallel_for(2, box_.size[2] - 2, [&](int k) {
      for (int j = 2; j < box_.size[1] - 2; ++j)
        for (size_t n = box_.index(2, j, k), end = n + box_.size[0] - 4; n < end; ++n)
          if (on[n]) slabs[k].push_back(std::uint32_t(n));
    });
    std::vector<std::uint32_t> active;
    for (const auto& slab : slabs) active.insert(active.end(), slab.begin(), slab.end());
    return active;
  }
  void markAround(const Vec3d& p, int reach, std::vector<char>& on) const {
    const Coord c = box_.coordOf(cellPlace(box_, p).cell);
    for (int k = c[2] - reach + 1; k <= c[2] + reach; ++k)
      for (int j = c[1] - reach + 1; j <= c[1] + reach; ++j)
        for (int i = c[0] - reach + 1; i <= c[0] + reach; ++i)
          if (i >= 0 && j >= 0 && k >= 0 && i < box_.size[0] && j < box_.size[1] && k < box_.size[2])
            on[box_.index(i, j, k)] = 1;
  }

  /// Far from the contours a plane still says what is inside and what outside, where no datum holds the
  /// surface: it is solved again around the pixels that it contradicts, until there are none.
  void keepVerdicts(int level, const PlateSettings& settings, std::vector<PlateDatum>& data) {
    std::vector<char> on(box_.count(), 1);
    for (int round = 0; round < kVerdictRounds; ++round) {
      const std::vector<Vec3d> broken = addBrokenPixels(1 << level, on, data);
      if (broken.empty()) return;
      std::fill(on.begin(), on.end(), 0);
      for (const Vec3d& p : broken) markAround(p, int(kBandNodes), on);
      solvePlate(box_, marked(on), data, settings, values_);
    }
  }
  /// The pixels of a plane that cover what it cuts out of the box of all contours, also where it has none
  /// itself.
  openvdb::CoordBBox pixelsInBox(const PlaneContours& frame, double pixel) const {
    openvdb::CoordBBox range;
    for (int c = 0; c < 8; ++c) {
      Vec3d corner;
      for (int a = 0; a < 3; ++a) corner[a] = (c >> a & 1 ? planes_.box.max() : planes_.box.min())[a];
      const Vec2d q = frame.toPlane(corner) / pixel;
      range.expand(Coord::floor(Vec3d(q[0], q[1], 0)));
    }
    return range;
  }
  /// Adds the verdict of every pixel next to nodes `on` that is off its contours and has the wrong
  /// sign.
  std::vector<Vec3d> addBrokenPixels(int stride, const std::vector<char>& on,
                                     std::vector<PlateDatum>& data) const {
    std::vector<std::vector<std::pair<Vec3d, double>>> parts(planes_.sections.size());
    const openvdb::BBoxd near(planes_.box.min() - Vec3d(box_.step), planes_.box.max() + Vec3d(box_.step));
    tbb::parallel_for(size_t(0), parts.size(), [&](size_t plane) {
      const PlaneImage& image = planes_.images[plane];
      const double pixel = stride * planes_.step;
      const openvdb::CoordBBox range = pixelsInBox(planes_.sections[plane].frame, pixel);
      for (int j = range.min()[1]; j <= range.max()[1]; ++j)
        for (int i = range.min()[0]; i <= range.max()[0]; ++i) {
          const Vec2d q = pixel * Vec2d(i, j);
          const Vec3d p = planes_.world(int(plane), q);
          const CellPlace place = cellPlace(box_, p);
          if (!on[place.cell] || !near.isInside(p)) continue;
          const double value = valueAt(box_, values_, place), d = image.at(q);
          if ((value < 0) == (d < 0) || std::abs(d) <= kLeastVerdict * box_.step) continue;
          const double target = bounded(int(plane), p, std::min(std::abs(d), kBandNodes * box_.step));
          parts[plane].emplace_back(p, std::copysign(target, d));
        }
    });
    std::vector<Vec3d> broken;
    for (const auto& part : parts)
      for (const auto& [p, target] : part) {
        broken.push_back(p);
        data.push_back({cellPlace(box_, p), float(target), float(kPlaneWeight)});
      }
    return broken;
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
      if (height < distance)
        distance = std::min(distance, std::hypot(height, planes_.images[j].at(frame.toPlane(p))));
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
        for (const Vec2d& p : {e.a, 0.5 * (e.a + e.b)})
          places.push_back(cellPlace(box_, planes_.world(int(i), p)));
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

/// Nodes of one row of a lattice that lie on the same side of the surface.
struct Run {
  size_t begin = 0, end = 0;
  bool inside = false;
};

/// Runs of nodes on the same side, joined with those of the rows next to them.
class Sides {
 public:
  Sides(const NodeBox& box, const std::vector<float>& values)
      : box_(box), first_(size_t(box.size[1]) * box.size[2] + 1) {
    std::vector<std::vector<Run>> slabs(box.size[2]);
    tbb::parallel_for(0, box.size[2], [&](int k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const size_t begin = box.index(0, j, k), end = begin + box.size[0], before = slabs[k].size();
        for (size_t n = begin; n < end; ++n) {
          const bool inside = values[n] < 0;
          if (n == begin || inside != slabs[k].back().inside) slabs[k].push_back({n, n, inside});
          slabs[k].back().end = n + 1;
        }
        first_[size_t(k) * box.size[1] + j + 1] = slabs[k].size() - before;
      }
    });
    for (size_t row = 1; row < first_.size(); ++row) first_[row] += first_[row - 1];
    for (const std::vector<Run>& slab : slabs) runs_.insert(runs_.end(), slab.begin(), slab.end());
    root_.resize(runs_.size());
    std::iota(root_.begin(), root_.end(), 0u);
    for (size_t row = 0; row + 1 < first_.size(); ++row) {
      if (row % box.size[1]) joinRows(row, row - 1);
      if (row >= size_t(box.size[1])) joinRows(row, row - box.size[1]);
    }
  }

  const std::vector<Run>& runs() const { return runs_; }
  std::uint32_t sideOf(size_t node) {
    const size_t row = node / box_.size[0];
    const auto after =
        std::upper_bound(runs_.begin() + long(first_[row]), runs_.begin() + long(first_[row + 1]), node,
                         [](size_t n, const Run& run) { return n < run.begin; });
    return find(std::uint32_t(after - runs_.begin() - 1));
  }
  std::uint32_t find(std::uint32_t run) {
    while (root_[run] != run) run = root_[run] = root_[root_[run]];
    return run;
  }

 private:
  void joinRows(size_t a, size_t b) {
    const size_t shift = (a - b) * box_.size[0];
    for (size_t i = first_[a], j = first_[b]; i < first_[a + 1] && j < first_[b + 1];) {
      if (runs_[i].inside == runs_[j].inside) root_[find(std::uint32_t(i))] = find(std::uint32_t(j));
      if (runs_[i].end < runs_[j].end + shift)
        ++i;
      else
        ++j;
    }
  }

  const NodeBox& box_;
  std::vector<Run> runs_;
  std::vector<size_t> first_;  // run of each row
  std::vector<std::uint32_t> root_;
};

/// Turns the sign of pieces (of the inside, and of the outside) that no contour touches; returns how many.
int dropStrays(const PlaneSet& planes, const NodeBox& box, std::vector<float>& values) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(box);
  Sides sides(box, values);
  std::vector<char> touched(sides.runs().size(), 0);
  touched[sides.sideOf(0)] = 1;
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges) {
      const std::uint32_t cell = cellPlace(box, planes.world(int(i), 0.5 * (e.a + e.b))).cell;
      for (std::uint32_t c : corners) touched[sides.sideOf(cell + c)] = 1;
    }
  int strays = 0;
  for (std::uint32_t r = 0; r < touched.size(); ++r) {
    const std::uint32_t side = sides.find(r);
    if (touched[side]) continue;
    strays += side == r;
    for (size_t n = sides.runs()[r].begin; n < sides.runs()[r].end; ++n) values[n] = -values[n];
  }
  return strays;
}

/// Next to a change of sign the surface is near, whatever the values: where a detail that the coarser levels
/// did not see meets values that they left, these may be large.
void limitAtSurface(const NodeBox& box, std::vector<float>& values) {
  const float most = float(2 * box.step);
  const std::ptrdiff_t step[3] = {1, box.size[0], std::ptrdiff_t(box.size[0]) * box.size[1]};
  std::vector<std::vector<size_t>> large(box.size[2]);
  tbb::parallel_for(1, box.size[2] - 1, [&](int k) {
    for (int j = 1; j < box.size[1] - 1; ++j)
      for (size_t n = box.index(1, j, k), end = n + box.size[0] - 2; n < end; ++n) {
        const float* v = &values[n];
        if (std::abs(*v) <= most) continue;
        for (std::ptrdiff_t s : step)
          if ((v[s] < 0) != (*v < 0) || (v[-s] < 0) != (*v < 0)) {
            large[k].push_back(n);
            break;
          }
      }
  });
  for (const std::vector<size_t>& slab : large)
    for (size_t n : slab) values[n] = std::copysign(most, values[n]);
}

/// The level set of the lattice's values.
FloatGrid::Ptr levelSetOf(const NodeBox& box, const std::vector<float>& values) {
  const Coord shift = Coord::round(box.origin / box.step), high = shift + box.size - Coord(1);
  const Coord low(shift[0] >> 3, shift[1] >> 3, shift[2] >> 3),
      count = Coord(high[0] >> 3, high[1] >> 3, high[2] >> 3) - low + Coord(1);
  const float near = float(6 * box.step);
  const auto overNodes = [&](const Coord& origin, const auto& action) {
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        for (int z = 0; z < 8; ++z) {
          const Coord c = origin - shift + Coord(x, y, z);
          if (c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && c[0] < box.size[0] && c[1] < box.size[1] &&
              c[2] < box.size[2])
            action(size_t((x * 8 + y) * 8 + z), values[box.index(c[0], c[1], c[2])]);
        }
  };
  std::vector<char> wanted(size_t(count[0]) * count[1] * count[2], 0);
  const auto originOf = [&](size_t b) {
    const Coord c =
        low + Coord(int(b % count[0]), int(b / count[0] % count[1]), int(b / count[0] / count[1]));
    return Coord(c[0] * 8, c[1] * 8, c[2] * 8);
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

/// Removes the closed shells that enclose less than a voxel, bubbles and drops of a single node that
/// distances made anew leave next to the surface, where the rest comes as near to every contour.
class Specks {
 public:
  Specks(const Mesh& mesh, double voxelSize) : mesh_(mesh), voxel_(voxelSize), shell_(mesh.points.size()) {
    std::iota(shell_.begin(), shell_.end(), 0u);
    for (const openvdb::Vec3I& t : mesh.triangles)
      for (int k = 1; k < 3; ++k) shell_[shellOf(t[k])] = shellOf(t[0]);
    std::map<std::uint32_t, double> volumes;
    for (const openvdb::Vec3I& t : mesh.triangles) {
      const std::uint32_t shell = shellOf(t[0]);
      const Vec3d o(mesh.points[shell]), a = Vec3d(mesh.points[t[0]]) - o;
      const Vec3d b = Vec3d(mesh.points[t[1]]) - o, c = Vec3d(mesh.points[t[2]]) - o;
      volumes[shell] += a.dot(b.cross(c)) / 6;
    }
    for (const auto& [shell, volume] : volumes)
      if (std::abs(volume) < std::pow(voxelSize, 3)) specks_[shell];
    for (std::uint32_t p = 0; p < mesh.points.size(); ++p)
      if (const auto speck = specks_.find(shellOf(p)); speck != specks_.end())
        speck->second.expand(Vec3d(mesh.points[p]));
  }

  Mesh without(const ContourSet& set) {
    if (specks_.empty()) return mesh_;
    for (const PlaneContours& plane : set.planes)
      for (const auto& loop : plane.loops)
        for (const Vec2d& p : loop) keepFor(plane.toWorld(p));
    Mesh out;
    std::vector<std::uint32_t> index(mesh_.points.size());
    for (std::uint32_t p = 0; p < mesh_.points.size(); ++p) {
      if (specks_.count(shellOf(p))) continue;
      index[p] = std::uint32_t(out.points.size());
      out.points.push_back(mesh_.points[p]);
    }
    for (const openvdb::Vec3I& t : mesh_.triangles)
      if (!specks_.count(shellOf(t[0]))) out.triangles.emplace_back(index[t[0]], index[t[1]], index[t[2]]);
    return out;
  }

 private:
  std::uint32_t shellOf(std::uint32_t p) {
    while (shell_[p] != p) p = shell_[p] = shell_[shell_[p]];
    return p;
  }
  /// A contour's point keeps the specks around it where nothing else is within a voxel.
  void keepFor(const Vec3d& p) {
    std::vector<std::uint32_t> around;
    for (const auto& [shell, box] : specks_)
      if (openvdb::BBoxd(box.min() - Vec3d(voxel_), box.max() + Vec3d(voxel_)).isInside(p))
        around.push_back(shell);
    if (around.empty()) return;
    for (std::uint32_t q = 0; q < mesh_.points.size(); ++q)
      if ((Vec3d(mesh_.points[q]) - p).lengthSqr() < voxel_ * voxel_ && !specks_.count(shellOf(q))) return;
    for (std::uint32_t shell : around) specks_.erase(shell);
  }

  const Mesh& mesh_;
  double voxel_;
  std::vector<std::uint32_t> shell_;  // by point: another of the same shell, in the end the first
  std::map<std::uint32_t, openvdb::BBoxd> specks_;  // boxes by shell
};

}  // namespace

double contourVoxelSize(const ContourSet& set) {
  Notes notes;
  return defaultVoxelSize(cleanPlanes(set, notes));
}

ContourSurface contourSurface(const ContourSet& set, const ContourSurfaceOptions& options,
                              Progress* progress) {
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
    out.notes.push_back(set.name + ": " + std::to_string(strays) +
                        " pieces that no contour touches left out");
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
  const Mesh whole = makeManifold(surfaceOf(*surface.grid)).mesh;
  Mesh mesh = Specks(whole, surface.voxelSize).without(set);
  meetContours(set, surface.voxelSize, mesh);
  return mesh;
}

}  // namespace slicemorph
