#include "engine/match/along_spine.h"

#include "engine/numerics/smoothstep.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

// The figures below are heuristics chosen by hand. tests/engine/match/along_spine_test.cpp guards what
// they are for, and Limbs.AHeadMeetsAHeadOnANeckOfAnotherLength, whose in-between was 4.6 voxels off
// with equal positions.

/// Middle slices; the objects are sampled kFine times as densely, so that shifts are found to
/// a quarter slice.
constexpr int kSlices = 48, kFine = 4;
/// Pixels across the larger side of a slice.
constexpr int kPixels = 40;
/// In fine steps: the largest half shift between two objects' slices, a third of the length, and its largest
/// change from slice to slice.
constexpr int kFarthest = kSlices * kFine / 3, kFastest = 3;
/// Price of a change of the half shift by one slice (squared), and of a half shift of the whole length.
constexpr double kStretchPrice = 0.1, kShiftPrice = 0.1;
/// Gain in the slices' mean overlap up to which no shift is taken, and from which it is taken wholly.
constexpr double kNoGain = 0.04, kClearGain = 0.1;
/// The same for the overlap itself: slices that overlap less do not correspond, however much is gained.
constexpr double kUnlike = 0.35, kAlike = 0.45;
/// Standard deviation of the Gaussian that smooths the shifts, in slices.
constexpr double kSmooth = 1.2;

/// Per fine slice, the share of each pixel that is inside.
using Coverage = std::vector<std::vector<float>>;

Coverage coverageOf(const DistanceField& field, const Chart& chart, const SlicePlanes& planes) {
  Coverage slices = sampleSlices(field, chart, planes);
  for (auto& image : slices)
    for (float& d : image) d = std::min(std::max(0.5f - d / float(planes.pixel), 0.f), 1.f);
  return slices;
}

/// An object's thickness: the area that one slice in ten exceeds; and its centroid across the
/// spine, chart units.
struct Thickness {
  double area = 0;
  Vec2d middle{0, 0};
};

Thickness thicknessOf(const DistanceField& field, const Chart& chart, const SlicePlanes& planes) {
  const Coverage slices = coverageOf(field, chart, planes);
  std::vector<double> areas;
  Thickness t;
  double total = 0;
  for (const auto& image : slices) {
    areas.push_back(0);
    for (size_t i = 0; i < image.size(); ++i) {
      areas.back() += image[i];
      t.middle +=
          image[i] * (planes.origin + planes.pixel * Vec2d(double(i % planes.nx), double(i / planes.nx)));
    }
    total += areas.back();
  }
  std::sort(areas.begin(), areas.end());
  t.area = std::max(areas[areas.size() * 9 / 10], 1.0) * planes.pixel * planes.pixel;
  if (total > 0) t.middle /= total;
  return t;
}

/// Intersection over union of two slices; null is an empty slice. 1 if both are empty.
double overlapOf(const std::vector<float>* a, const std::vector<float>* b, size_t pixels) {
  double both = 0, either = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const float x = a ? (*a)[i] : 0, y = b ? (*b)[i] : 0;
    both += std::min(x, y), either += std::max(x, y);
  }
  return either > 0 ? both / either : 1;
}

/// Half the shift between corresponding slices of two objects: a's slice lies that much before the middle
/// slice, b's that much after it.
struct HalfShifts {
  std::vector<double> shift;     ///< per middle slice, in slices
  double before = 0, after = 0;  ///< mean overlap without the shifts and with them
};

HalfShifts halfShifts(const Coverage& a, const Coverage& b, size_t pixels) {
  constexpr int kStates = 2 * kFarthest + 1;
  const auto slice = [](const Coverage& c, int i) {
    return i >= 0 && i < int(c.size()) ? &c[size_t(i)] : nullptr;
  };
  std::vector<std::vector<double>> score(kSlices, std::vector<double>(kStates));
  tbb::parallel_for(0, kSlices, [&](int i) {
    const int middle = kFine * i + kFine / 2;
    for (int s = 0; s < kStates; ++s) {
      const int shift = s - kFarthest;
      score[size_t(i)][size_t(s)] = overlapOf(slice(a, middle - shift), slice(b, middle + shift), pixels);
    }
  });
  std::vector<std::vector<double>> value = score;
  std::vector<std::vector<int>> from(kSlices, std::vector<int>(kStates, 0));
  for (int i = 0; i < kSlices; ++i)
    for (int s = 0; s < kStates; ++s) {
      value[size_t(i)][size_t(s)] -= kShiftPrice * std::abs(s - kFarthest) / double(kFine * kSlices);
      if (i == 0) continue;
      double most = -1e300;
      for (int d = -kFastest; d <= kFastest; ++d) {
        const int p = s + d;
        if (p < 0 || p >= kStates) continue;
        const double change = d / double(kFine),
                     v = value[size_t(i) - 1][size_t(p)] - kStretchPrice * change * change;
        if (v > most) most = v, from[size_t(i)][size_t(s)] = p;
      }
      value[size_t(i)][size_t(s)] += most;
    }
  std::vector<double> raw(kSlices);
  int s = int(std::max_element(value.back().begin(), value.back().end()) - value.back().begin());
  HalfShifts result;
  for (int i = kSlices - 1; i >= 0; --i) {
    raw[size_t(i)] = (s - kFarthest) / double(kFine);
    result.before += score[size_t(i)][kFarthest] / kSlices;
    result.after += score[size_t(i)][size_t(s)] / kSlices;
    s = from[size_t(i)][size_t(s)];
  }
  for (int i = 0; i < kSlices; ++i) {
    double sum = 0, weight = 0;
    for (int j = 0; j < kSlices; ++j) {
      const double w = std::exp(-0.5 * (i - j) * (i - j) / (kSmooth * kSmooth));
      sum += w * raw[size_t(j)], weight += w;
    }
    result.shift.push_back(sum / weight);
  }
  return result;
}

/// Value at `x` of a rising polyline, extended with slope 1 beyond its ends.
double valueAt(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
  if (x <= xs.front()) return ys.front() + x - xs.front();
  if (x >= xs.back()) return ys.back() + x - xs.back();
  const size_t i = size_t(std::upper_bound(xs.begin(), xs.end(), x) - xs.begin()) - 1;
  return ys[i] + (ys[i + 1] - ys[i]) * (x - xs[i]) / (xs[i + 1] - xs[i]);
}

}  // namespace

AlongSpine matchAlongSpine(const Fields& fields, const std::vector<Chart>& charts,
                           const SlicePlanes& planes) {
  const size_t objects = fields.size(), count = planes.z0.size();
  const double step = planes.z0[1] - planes.z0[0], first = planes.z0[0] - 0.5 * step;
  const double slab = step * double(count) / kSlices;
  SlicePlanes fine;
  for (int i = 0; i < kSlices * kFine; ++i) fine.z0.push_back(first + (i + 0.5) * slab / kFine);
  const double shrink = std::max(planes.nx, planes.ny) / double(kPixels);
  fine.pixel = planes.pixel * shrink, fine.origin = planes.origin;
  fine.nx = int(planes.nx / shrink) + 1, fine.ny = int(planes.ny / shrink) + 1;
  // Scale all objects to the same thickness: a slice of a thin object must not be mistaken for one near the
  // end of a thick object.
  std::vector<Thickness> thickness(objects);
  double meanLog = 0;
  for (size_t k = 0; k < objects; ++k) {
    thickness[k] = thicknessOf(*fields[k], charts[k], planes);
    meanLog += std::log(thickness[k].area) / double(objects);
  }
  std::vector<Coverage> slices(objects);
  for (size_t k = 0; k < objects; ++k) {
    const double scale = std::sqrt(thickness[k].area / std::exp(meanLog));
    SlicePlanes own = fine;
    own.pixel *= scale;
    own.origin = thickness[k].middle - 0.5 * own.pixel * Vec2d(fine.nx - 1, fine.ny - 1);
    slices[k] = coverageOf(*fields[k], charts[k], own);
  }

  // Per object, the positions that correspond to the first object's.
  AlongSpine result{std::vector<std::vector<double>>(objects, planes.z0), 0, 0};
  std::vector<double> middle(count, 0);
  std::vector<std::vector<double>> partner(objects);
  double taken = 0;
  for (size_t k = 1; k < objects; ++k) {
    const HalfShifts h = halfShifts(slices[0], slices[k], size_t(fine.nx) * fine.ny);
    result.before += h.before / double(objects - 1), result.after += h.after / double(objects - 1);
    const double share =
        smoothstep(h.after - h.before, kNoGain, kClearGain) * smoothstep(h.after, kUnlike, kAlike);
    taken = std::max(taken, share);
    std::vector<double> a, b;
    for (int i = 0; i < kSlices; ++i) {
      const double z = first + (i + 0.5) * slab, d = share * slab * h.shift[size_t(i)];
      a.push_back(z - d), b.push_back(z + d);
    }
    for (size_t i = 0; i < count; ++i) partner[k].push_back(valueAt(a, b, planes.z0[i]));
  }
  if (taken == 0) return result;
  partner[0] = planes.z0;
  for (const auto& p : partner)
    for (size_t i = 0; i < count; ++i) middle[i] += p[i] / double(objects);
  for (size_t k = 0; k < objects; ++k)
    for (size_t i = 0; i < count; ++i) result.position[k][i] = valueAt(middle, partner[k], planes.z0[i]);
  return result;
}

}  // namespace slicemorph
