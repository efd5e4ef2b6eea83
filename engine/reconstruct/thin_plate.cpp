#include "engine/reconstruct/thin_plate.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace slicemorph {

namespace {

using Range = tbb::blocked_range<size_t>;
constexpr size_t kGrain = 8192;
constexpr float kCentre = 42, kFace = -12, kEdge = 2, kBeyond = 1;  // of the biharmonic operator

class PlateSystem {
 public:
  PlateSystem(const NodeBox& box, const std::vector<std::uint32_t>& active,
              const std::vector<PlateDatum>& data)
      : active_(active),
        corners_(cornerOffsets(box)),
        y_(box.size[0]),
        z_(std::ptrdiff_t(box.size[0]) * box.size[1]) {
    listIncidence(box.count(), data);
  }

  const std::vector<float>& diagonal() const { return diagonal_; }

  /// The system's left side of a function that is `values` at every node; at the active nodes.
  void apply(const std::vector<float>& values, std::vector<float>& out) { product(values, 0, out); }
  /// Right side less left side.
  void residual(const std::vector<float>& values, std::vector<float>& out) {
    product(values, 1, out);
    for (float& v : out) v = -v;
  }

 private:
  void product(const std::vector<float>& values, float target, std::vector<float>& out) {
    tbb::parallel_for(Range(0, data_.size(), kGrain), [&](const Range& range) {
      for (size_t r = range.begin(); r < range.end(); ++r) {
        const PlateDatum& d = data_[r];
        float sum = -target * d.target;
        for (int c = 0; c < 8; ++c) sum += d.place.weight(c) * values[d.place.cell + corners_[c]];
        rows_[r] = d.weight * sum;
      }
    });
    tbb::parallel_for(Range(0, active_.size(), kGrain), [&](const Range& range) {
      for (size_t n = range.begin(); n < range.end(); ++n) {
        float sum = bending(&values[active_[n]]);
        for (std::uint32_t k = first_[n]; k < first_[n + 1]; ++k) {
          const std::uint32_t entry = entries_[k];
          sum += data_[entry >> 3].place.weight(entry & 7) * rows_[entry >> 3];
        }
        out[n] = sum;
      }
    });
  }
  float bending(const float* v) const {
    const std::ptrdiff_t y = y_, z = z_;
    const float face = v[-1] + v[1] + v[-y] + v[y] + v[-z] + v[z];
    const float edge = (v[-y - 1] + v[-y + 1] + v[y - 1] + v[y + 1]) +
                       (v[-z - 1] + v[-z + 1] + v[z - 1] + v[z + 1]) +
                       (v[-z - y] + v[-z + y] + v[z - y] + v[z + y]);
    const float beyond = v[-2] + v[2] + v[-2 * y] + v[2 * y] + v[-2 * z] + v[2 * z];
    return kCentre * *v + kFace * face + kEdge * edge + kBeyond * beyond;
  }
  void listIncidence(size_t nodes, const std::vector<PlateDatum>& data) {
    constexpr std::uint32_t kHeld = ~std::uint32_t(0);
    std::vector<std::uint32_t> slot(nodes, kHeld);
    for (size_t n = 0; n < active_.size(); ++n) slot[active_[n]] = std::uint32_t(n);
    std::copy_if(data.begin(), data.end(), std::back_inserter(data_), [&](const PlateDatum& d) {
      return std::any_of(corners_.begin(), corners_.end(),
                         [&](std::uint32_t c) { return slot[d.place.cell + c] != kHeld; });
    });
    rows_.resize(data_.size());
    first_.assign(active_.size() + 1, 0);
    const auto visit = [&](const auto& action) {
      for (size_t r = 0; r < data_.size(); ++r)
        for (std::uint32_t c = 0; c < 8; ++c) {
          const std::uint32_t n = slot[data_[r].place.cell + corners_[c]];
          if (n != kHeld) action(n, r, c);
        }
    };
    visit([&](std::uint32_t n, size_t, std::uint32_t) { ++first_[n + 1]; });
    for (size_t n = 0; n < active_.size(); ++n) first_[n + 1] += first_[n];
    entries_.resize(first_.back());
    diagonal_.assign(active_.size(), kCentre);
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    visit([&](std::uint32_t n, size_t r, std::uint32_t c) {
      entries_[next[n]++] = std::uint32_t(r << 3 | c);
      const float weight = data_[r].place.weight(int(c));
      diagonal_[n] += data_[r].weight * weight * weight;
    });
  }

  const std::vector<std::uint32_t>& active_;
  std::vector<PlateDatum> data_;  // those that an active node has to do with
  std::array<std::uint32_t, 8> corners_;
  std::ptrdiff_t y_, z_;  // to the next node along these axes
  std::vector<float> rows_, diagonal_;
  std::vector<std::uint32_t> first_, entries_;  // datum * 8 + corner, by node
};

/// Sum over i of f(i), the same for any number of threads.
template <typename F>
double sumOver(size_t count, const F& f) {
  return tbb::parallel_deterministic_reduce(
      Range(0, count, kGrain), 0.0,
      [&](const Range& range, double sum) {
        for (size_t i = range.begin(); i < range.end(); ++i) sum += f(i);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

template <typename F>
void forEach(size_t count, const F& f) {
  tbb::parallel_for(Range(0, count, kGrain), [&](const Range& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) f(i);
  });
}

}  // namespace

CellPlace cellPlace(const NodeBox& box, const Vec3d& world) {
  const Vec3d q = (world - box.origin) / box.step;
  int base[3];
  double share[3];
  for (int a = 0; a < 3; ++a) {
    const double clamped = std::clamp(q[a], 0.0, double(box.size[a] - 1));
    base[a] = std::min(int(clamped), box.size[a] - 2);
    share[a] = clamped - base[a];
  }
  return {std::uint32_t(box.index(base[0], base[1], base[2])), float(share[0]), float(share[1]),
          float(share[2])};
}

std::array<std::uint32_t, 8> cornerOffsets(const NodeBox& box) {
  std::array<std::uint32_t, 8> offsets;
  for (int c = 0; c < 8; ++c) offsets[c] = std::uint32_t(box.index(c & 1, c >> 1 & 1, c >> 2));
  return offsets;
}

double valueAt(const NodeBox& box, const std::vector<float>& values, const CellPlace& place) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(box);
  double sum = 0;
  for (int c = 0; c < 8; ++c) sum += double(place.weight(c)) * values[place.cell + corners[c]];
  return sum;
}

Vec3d gradientAt(const NodeBox& box, const std::vector<float>& values, const CellPlace& place) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(box);
  Vec3d sum(0.0);
  for (int c = 0; c < 8; ++c) {
    const double f = values[place.cell + corners[c]];
    const double u = c & 1 ? place.u : 1 - place.u, v = c & 2 ? place.v : 1 - place.v,
                 w = c & 4 ? place.w : 1 - place.w;
    sum += f * Vec3d((c & 1 ? 1 : -1) * v * w, (c & 2 ? 1 : -1) * u * w, (c & 4 ? 1 : -1) * u * v);
  }
  return sum / box.step;
}

int solvePlate(const NodeBox& box, const std::vector<std::uint32_t>& active,
               const std::vector<PlateDatum>& data, const PlateSettings& settings,
               std::vector<float>& values) {
  PlateSystem system(box, active, data);
  const std::vector<float>& diagonal = system.diagonal();
  const size_t n = active.size();
  std::vector<float> r(n), product(n), direction(values.size(), 0.0f);
  system.residual(values, r);
  const auto steepness = [&] {
    return sumOver(n, [&](size_t i) { return double(r[i]) * r[i] / diagonal[i]; });
  };
  double rz = steepness();
  const double enough = rz * settings.tolerance * settings.tolerance;
  forEach(n, [&](size_t i) { direction[active[i]] = r[i] / diagonal[i]; });
  int step = 0;
  for (; step < settings.iterations && rz > enough; ++step) {
    system.apply(direction, product);
    const double bend = sumOver(n, [&](size_t i) { return double(direction[active[i]]) * product[i]; });
    if (!(bend > 0)) break;
    const float alpha = float(rz / bend);
    forEach(n, [&](size_t i) {
      values[active[i]] += alpha * direction[active[i]];
      r[i] -= alpha * product[i];
    });
    const double before = rz;
    rz = steepness();
    const float beta = float(rz / before);
    forEach(n, [&](size_t i) { direction[active[i]] = r[i] / diagonal[i] + beta * direction[active[i]]; });
  }
  return step;
}

}  // namespace slicemorph
