#include "io/image/straighten.h"

#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

/// Pixels, and share of a gap: smaller offsets are taken as rounding of the stored positions, so that slices
/// are copied and not resampled. Far below what is visible.
constexpr double kStraight = 2e-3;
/// Share of the usual gap by which gaps may differ from it and still count as even; positions are
/// stored in decimals.
constexpr double kEven = 0.01;
/// Voxels along an axis: far more than any scanner makes; damaged positions are farther apart.
constexpr double kMostAlong = 1 << 20;

std::string written(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.4g", value);
  return digits;
}

/// Positions of slices relative to the first.
struct SlicePositions {
  Vec3d normal;                       ///< unit
  std::vector<double> along;          ///< along the normal, millimetres
  std::vector<openvdb::Vec2d> shift;  ///< in the plane, pixels
};

SlicePositions slicePositionsOf(const SliceStackInput& stack) {
  SlicePositions p;
  const Vec3d &x = stack.step[0], &y = stack.step[1];
  p.normal = x.cross(y).unit();
  const double xx = x.dot(x), xy = x.dot(y), yy = y.dot(y), det = xx * yy - xy * xy;
  for (const Vec3d& at : stack.position) {
    const Vec3d d = at - stack.position[0];
    p.along.push_back(d.dot(p.normal));
    const double a = d.dot(x), b = d.dot(y);
    p.shift.emplace_back((yy * a - xy * b) / det, (xx * b - xy * a) / det);
  }
  return p;
}

/// The median gap.
double usualGap(const std::vector<double>& along) {
  std::vector<double> gaps;
  for (size_t i = 1; i < along.size(); ++i) gaps.push_back(along[i] - along[i - 1]);
  std::nth_element(gaps.begin(), gaps.begin() + std::ptrdiff_t(gaps.size() / 2), gaps.end());
  return gaps[gaps.size() / 2];
}

/// Adds notes on missing slices and uneven gaps; returns whether all gaps are equal.
bool checkGaps(const SliceStackInput& stack, const SlicePositions& positions, double gap, Notes& notes) {
  size_t missing = 0, uneven = 0;
  std::string where;
  for (size_t i = 1; i < positions.along.size(); ++i) {
    const double ratio = (positions.along[i] - positions.along[i - 1]) / gap;
    if (std::abs(ratio - 1) <= kEven) continue;
    const double whole = std::rint(ratio);
    if (whole >= 2 && std::abs(ratio - whole) <= 5 * kEven) {
      missing += size_t(whole) - 1;
      if (where.empty())
        where = stack.names[i - 1] + " and " + stack.names[i] + ", " + written(ratio * gap) + " mm apart";
    } else {
      ++uneven;
    }
  }
  if (missing > 0)
    notes.emplace_back("image.slices-missing", Severity::kWarning, "",
                       std::to_string(missing) + (missing == 1 ? " slice is" : " slices are") +
                           " missing (first between " + where + "): interpolated from the neighbours");
  if (uneven > 0) {
    const auto [low, high] = [&] {
      double least = INFINITY, most = 0;
      for (size_t i = 1; i < positions.along.size(); ++i) {
        least = std::min(least, positions.along[i] - positions.along[i - 1]);
        most = std::max(most, positions.along[i] - positions.along[i - 1]);
      }
      return std::pair(least, most);
    }();
    notes.emplace_back("image.slices-uneven", Severity::kNote, "",
                       "its slices are unevenly spaced (" + written(low) + " to " + written(high) +
                           " mm): resampled every " + written(gap) + " mm from where they truly lie");
  }
  return missing + uneven == 0;
}

template <typename T>
T smallestOf(const std::vector<ImageValues>& slices) {
  T least = std::get<std::vector<T>>(slices[0])[0];
  for (const ImageValues& s : slices)
    for (T v : std::get<std::vector<T>>(s)) least = std::min(least, v);
  return least;
}

/// A slice shifted in its plane, with bilinear interpolation.
class MovedSlice {
 public:
  MovedSlice(const int size[2], openvdb::Vec2d shift) : width_(size[0]), height_(size[1]), shift_(shift) {}

  template <typename T>
  double at(const std::vector<T>& values, int i, int j, T outside) const {
    const double x = i - shift_[0], y = j - shift_[1];
    const int x0 = int(std::floor(x + kStraight)), y0 = int(std::floor(y + kStraight));
    const double fx = std::max(0.0, x - x0), fy = std::max(0.0, y - y0);
    const auto value = [&](int a, int b) {
      return a >= 0 && b >= 0 && a < width_ && b < height_
                 ? double(values[size_t(b) * size_t(width_) + size_t(a)])
                 : double(outside);
    };
    if (fx < kStraight && fy < kStraight) return value(x0, y0);
    const double low = fx < kStraight ? value(x0, y0) : (1 - fx) * value(x0, y0) + fx * value(x0 + 1, y0);
    if (fy < kStraight) return low;
    const double high =
        fx < kStraight ? value(x0, y0 + 1) : (1 - fx) * value(x0, y0 + 1) + fx * value(x0 + 1, y0 + 1);
    return (1 - fy) * low + fy * high;
  }

 private:
  int width_, height_;
  openvdb::Vec2d shift_;
};

template <typename T>
std::vector<T> resampled(const SliceStackInput& stack, const Straightening& plan,
                         const ImageLattice& lattice) {
  const T outside = smallestOf<T>(stack.values);
  std::vector<T> result(lattice.count());
  const auto& along = plan.along;
  const openvdb::Vec2d first(plan.first[0], plan.first[1]);
  tbb::parallel_for(0, lattice.size[2], [&](int k) {
    const double z = k * plan.gap;
    size_t above = size_t(std::lower_bound(along.begin(), along.end(), z) - along.begin());
    above = std::min(std::max<size_t>(above, 1), along.size() - 1);
    double f = std::min(std::max((z - along[above - 1]) / (along[above] - along[above - 1]), 0.0), 1.0);
    if (f < kStraight) f = 0;
    if (f > 1 - kStraight) f = 1;
    const auto& low = std::get<std::vector<T>>(stack.values[above - 1]);
    const auto& high = std::get<std::vector<T>>(stack.values[above]);
    const MovedSlice movedLow(stack.size, plan.shift[above - 1] - first);
    const MovedSlice movedHigh(stack.size, plan.shift[above] - first);
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0]; ++i) {
        double v = 0;
        if (f < 1) v += (1 - f) * movedLow.at(low, i, j, outside);
        if (f > 0) v += f * movedHigh.at(high, i, j, outside);
        result[lattice.index(i, j, k)] = std::is_integral_v<T> ? T(std::lrint(v)) : T(v);
      }
  });
  return result;
}

/// All slices one after the other; frees each as it is copied.
template <typename T>
std::vector<T> joined(SliceStackInput& stack) {
  const size_t each = std::get<std::vector<T>>(stack.values[0]).size();
  std::vector<T> result(each * stack.values.size());
  tbb::parallel_for(size_t(0), stack.values.size(), [&](size_t k) {
    auto& slice = std::get<std::vector<T>>(stack.values[k]);
    std::copy(slice.begin(), slice.end(), result.begin() + std::ptrdiff_t(k * each));
    std::vector<T>().swap(slice);
  });
  return result;
}

/// Throws InputError where slices lie farther apart along an axis, in their plane or across it, than voxels are counted.
void checkAlong(const SliceStackInput& stack, double voxels) {
  if (voxels <= kMostAlong) return;
  throw InputError(stack.names[0],
                   "lies so far from " + stack.names.back() + " that a volume of both has " +
                       written(voxels) +
                       " voxels along an axis: their positions are damaged, or these are several stacks");
}

/// Bytes of the slices and of a lattice of the same type of values.
double bytesWith(const SliceStackInput& stack, const ImageLattice& lattice) {
  const double slices = double(stack.size[0]) * stack.size[1] * double(stack.values.size());
  const double each = std::visit([](const auto& v) { return double(sizeof(v[0])); }, stack.values[0]);
  return (slices + double(lattice.size[0]) * lattice.size[1] * lattice.size[2]) * each;
}

}  // namespace

Straightening layOut(const SliceStackInput& stack, ImageFile& file) {
  Straightening plan;
  const SlicePositions positions = slicePositionsOf(stack);
  plan.along = positions.along, plan.shift = positions.shift;
  const size_t count = stack.position.size();
  ImageLattice& lattice = file.image.lattice;
  lattice.size = openvdb::Coord(stack.size[0], stack.size[1], int(count));
  lattice.origin = stack.position[0];
  lattice.step[0] = stack.step[0], lattice.step[1] = stack.step[1];
  if (count == 1) {
    lattice.step[2] = positions.normal * stack.step[0].length();
    return plan;
  }
  plan.gap = usualGap(positions.along);
  const bool even = checkGaps(stack, positions, plan.gap, file.notes);
  openvdb::Vec2d low(0.0), high(0.0);
  for (const auto& s : positions.shift)
    for (int d = 0; d < 2; ++d) low[d] = std::min(low[d], s[d]), high[d] = std::max(high[d], s[d]);
  const bool straight = high[0] - low[0] < kStraight && high[1] - low[1] < kStraight;
  if (even) plan.gap = positions.along.back() / double(count - 1);
  lattice.step[2] = positions.normal * plan.gap;
  plan.copied = even && straight;
  if (plan.copied) return plan;
  if (!straight) {
    for (int d = 0; d < 2; ++d) {
      checkAlong(stack, stack.size[d] + (high[d] - low[d]));
      plan.first[d] = int(std::floor(low[d] + kStraight));
      lattice.size[d] += int(std::ceil(high[d] - kStraight)) - plan.first[d];
    }
    lattice.origin += double(plan.first[0]) * stack.step[0] + double(plan.first[1]) * stack.step[1];
    const openvdb::Vec2d lean = positions.shift.back();
    const double tilt =
        std::atan2((lean[0] * stack.step[0] + lean[1] * stack.step[1]).length(), positions.along.back());
    file.notes.emplace_back(
        "image.tilt-straightened", Severity::kNote, "",
        "its slices lean by " + written(tilt * 180 / M_PI) + " degrees (gantry tilt): straightened");
  }
  const double planes = positions.along.back() / plan.gap;
  checkAlong(stack, planes);
  lattice.size[2] = even ? int(count) : int(std::lround(std::floor(planes + kEven))) + 1;
  return plan;
}

void straighten(SliceStackInput stack, const SizeCheck& check, ImageFile& file) {
  const Straightening plan = layOut(stack, file);
  if (stack.position.size() == 1) {
    file.image.values = std::move(stack.values[0]);
    return;
  }
  if (!plan.copied) check(file.image.lattice.size, bytesWith(stack, file.image.lattice));
  std::visit(
      [&](const auto& v) {
        using T = typename std::decay_t<decltype(v)>::value_type;
        file.image.values = plan.copied ? joined<T>(stack) : resampled<T>(stack, plan, file.image.lattice);
      },
      stack.values[0]);
}

}  // namespace slicemorph
