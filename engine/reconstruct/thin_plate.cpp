#include "engine/reconstruct/thin_plate.h"

#include "engine/numerics/conjugate_gradients.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>

namespace slicemorph {

namespace {

using Range = tbb::blocked_range<size_t>;
constexpr size_t kGrain = 8192;  // nodes or data per task
// coefficients of the 25-point biharmonic stencil
constexpr float kCentre = 42, kFace = -12, kEdge = 2, kBeyond = 1;

class PlateSystem {
 public:
  PlateSystem(const Lattice& lattice, const std::vector<std::uint32_t>& active,
              const std::vector<PlateDatum>& data)
      : active_(active),
        corners_(cornerOffsets(lattice)),
        y_(lattice.size[0]),
        z_(std::ptrdiff_t(lattice.size[0]) * lattice.size[1]) {
    listIncidence(lattice.count(), data);
  }

  size_t size() const { return active_.size(); }
  size_t node(size_t i) const { return active_[i]; }
  float diagonal(size_t i) const { return diagonal_[i]; }
  Grain grain() const { return {kGrain}; }

  /// Left side of the system for a function with these values at all nodes, at the active nodes.
  void apply(const std::vector<float>& values, std::vector<float>& out) { product(values, 0, out); }
  /// Right side minus left side.
  std::vector<float> residual(const std::vector<float>& values) {
    std::vector<float> out(active_.size());
    product(values, 1, out);
    for (float& v : out) v = -v;
    return out;
  }

 private:
  void product(const std::vector<float>& values, float target, std::vector<float>& out) {
    tbb::parallel_for(Range(0, data_.size(), kGrain), [&](const Range& range) {
      for (size_t r = range.begin(); r < range.end(); ++r) {
        const PlateDatum& d = data_[r];
        float sum = -target * d.target;
        for (int c = 0; c < 8; ++c) sum += d.point.weight(c) * values[d.point.cell + corners_[c]];
        rows_[r] = d.weight * sum;
      }
    });
    tbb::parallel_for(Range(0, active_.size(), kGrain), [&](const Range& range) {
      for (size_t n = range.begin(); n < range.end(); ++n) {
        float sum = bending(&values[active_[n]]);
        for (std::uint32_t k = first_[n]; k < first_[n + 1]; ++k) {
          const std::uint32_t entry = entries_[k];
          sum += data_[entry >> 3].point.weight(entry & 7) * rows_[entry >> 3];
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
    constexpr std::uint32_t kHeld = ~std::uint32_t(0);  // slot of a node that is not solved for
    std::vector<std::uint32_t> slot(nodes, kHeld);
    for (size_t n = 0; n < active_.size(); ++n) slot[active_[n]] = std::uint32_t(n);
    std::copy_if(data.begin(), data.end(), std::back_inserter(data_), [&](const PlateDatum& d) {
      return std::any_of(corners_.begin(), corners_.end(),
                         [&](std::uint32_t c) { return slot[d.point.cell + c] != kHeld; });
    });
    rows_.resize(data_.size());
    first_.assign(active_.size() + 1, 0);
    const auto visit = [&](const auto& action) {
      for (size_t r = 0; r < data_.size(); ++r)
        for (std::uint32_t c = 0; c < 8; ++c) {
          const std::uint32_t n = slot[data_[r].point.cell + corners_[c]];
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
      const float weight = data_[r].point.weight(int(c));
      diagonal_[n] += data_[r].weight * weight * weight;
    });
  }

  const std::vector<std::uint32_t>& active_;
  std::vector<PlateDatum> data_;  // those that involve an active node
  std::array<std::uint32_t, 8> corners_;
  std::ptrdiff_t y_, z_;  // offsets to the next node along these axes
  std::vector<float> rows_, diagonal_;
  std::vector<std::uint32_t> first_, entries_;  // datum * 8 + corner, grouped by node
};

}  // namespace

int solvePlate(const Lattice& lattice, const std::vector<std::uint32_t>& active,
               const std::vector<PlateDatum>& data, const PlateSettings& settings,
               std::vector<float>& values) {
  PlateSystem system(lattice, active, data);
  const double enough = settings.tolerance * settings.tolerance;
  return conjugateGradients(system, {settings.iterations, enough}, system.residual(values), values);
}

}  // namespace slicemorph
