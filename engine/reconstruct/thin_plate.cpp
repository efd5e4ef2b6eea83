#include "engine/reconstruct/thin_plate.h"

#include "engine/numerics/conjugate_gradients.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

namespace {

using Range = tbb::blocked_range<size_t>;
constexpr size_t kGrain = 8192;  // nodes or data per task
constexpr size_t kWord = 64;     // nodes per word of a set of nodes
constexpr int kReach = 2;        // nodes along each axis to which a condition on a node reaches
// coefficients of the 25-point biharmonic stencil
constexpr float kCentre = 42, kFace = -12, kEdge = 2, kBeyond = 1;

using Bits = std::vector<std::uint64_t>;

int bitsIn(std::uint64_t word) { return __builtin_popcountll(word); }

/// A set of nodes of a lattice, one bit a node, that knows how many of its nodes come before another: an array of
/// numbers by node would be as large as the lattice's values.
class NodeSet {
 public:
  NodeSet(size_t nodes, const std::vector<std::uint32_t>& members) : bits_((nodes + kWord - 1) / kWord) {
    for (const std::uint32_t n : members) bits_[n / kWord] |= std::uint64_t(1) << n % kWord;
    before_.reserve(bits_.size());
    std::uint32_t count = 0;
    for (const std::uint64_t word : bits_) before_.push_back(count), count += std::uint32_t(bitsIn(word));
  }

  const Bits& bits() const { return bits_; }
  bool holds(size_t n) const { return bits_[n / kWord] >> n % kWord & 1; }
  /// Number of members below `n`.
  std::uint32_t before(size_t n) const {
    const std::uint64_t below = (std::uint64_t(1) << n % kWord) - 1;
    return before_[n / kWord] + std::uint32_t(bitsIn(bits_[n / kWord] & below));
  }

 private:
  Bits bits_;
  std::vector<std::uint32_t> before_;  // by word
};

/// Joins a set with itself shifted by up to kReach times `step` nodes, up and down.
Bits spread(const Bits& bits, size_t step) {
  Bits out = bits;
  for (int times = 1; times <= kReach; ++times) {
    const size_t words = times * step / kWord, rest = times * step % kWord;
    for (size_t w = words; w < bits.size(); ++w) {
      const size_t low = w - words;
      out[w] |= bits[low] << rest;
      out[low] |= bits[w] >> rest;
      if (rest == 0 || low + 1 == bits.size() || w + 1 == bits.size()) continue;
      out[w + 1] |= bits[low] >> (kWord - rest);
      out[low] |= bits[w + 1] << (kWord - rest);
    }
  }
  return out;
}

/// Takes the values of the nodes around the active ones out of an array, where zeros replace them, and puts them back.
class ValuesAround {
 public:
  ValuesAround(const Lattice& lattice, const NodeSet& active, std::vector<float>& values)
      : around_(spread(spread(spread(active.bits(), 1), lattice.size[0]),
                       size_t(lattice.size[0]) * lattice.size[1])),
        values_(values) {
    for (size_t w = 0; w < around_.size(); ++w) around_[w] &= ~active.bits()[w];
    forEach([&](float& value) { taken_.push_back(value), value = 0; });
  }
  void putBack() {
    const float* next = taken_.data();
    forEach([&](float& value) { value = *next++; });
  }

 private:
  template <typename Action>
  void forEach(const Action& action) {
    for (size_t w = 0; w < around_.size(); ++w)
      for (std::uint64_t rest = around_[w]; rest; rest &= rest - 1)
        action(values_[w * kWord + size_t(__builtin_ctzll(rest))]);
  }

  Bits around_;
  std::vector<float>& values_;
  std::vector<float> taken_;
};

class PlateSystem {
 public:
  /// `values`: of the whole lattice; it is the work space of apply().
  PlateSystem(const Lattice& lattice, const std::vector<std::uint32_t>& active, const NodeSet& isActive,
              const std::vector<PlateDatum>& data, std::vector<float>& values)
      : active_(active),
        data_(data),
        values_(values),
        corners_(cornerOffsets(lattice)),
        y_(lattice.size[0]),
        z_(std::ptrdiff_t(lattice.size[0]) * lattice.size[1]) {
    listIncidence(isActive);
  }

  size_t size() const { return active_.size(); }
  size_t node(size_t i) const { return i; }
  float diagonal(size_t i) const { return diagonal_[i]; }
  Grain grain() const { return {kGrain}; }

  /// Left side of the system for a function with these values at the active nodes. Those around must be 0 in the work
  /// space.
  void apply(const std::vector<float>& function, std::vector<float>& out) {
    place(function);
    product(0, out);
  }
  /// Right side minus left side, for the values in the work space.
  std::vector<float> residual() {
    std::vector<float> out(active_.size());
    product(1, out);
    for (float& v : out) v = -v;
    return out;
  }
  /// The work space's values at the active nodes.
  std::vector<float> function() const {
    std::vector<float> out(active_.size());
    grain().forEach(out.size(), [&](size_t n) { out[n] = values_[active_[n]]; });
    return out;
  }
  /// Sets them.
  void place(const std::vector<float>& function) {
    grain().forEach(function.size(), [&](size_t n) { values_[active_[n]] = function[n]; });
  }

 private:
  void product(float target, std::vector<float>& out) {
    tbb::parallel_for(Range(0, used_.size(), kGrain), [&](const Range& range) {
      for (size_t u = range.begin(); u < range.end(); ++u) {
        const PlateDatum& d = data_[used_[u]];
        float sum = -target * d.target;
        for (int c = 0; c < 8; ++c) sum += d.point.weight(c) * values_[d.point.cell + corners_[c]];
        rows_[used_[u]] = d.weight * sum;
      }
    });
    tbb::parallel_for(Range(0, active_.size(), kGrain), [&](const Range& range) {
      for (size_t n = range.begin(); n < range.end(); ++n) {
        float sum = bending(&values_[active_[n]]);
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
  void listIncidence(const NodeSet& isActive) {
    const auto visit = [&](std::uint32_t r, const auto& action) {
      for (std::uint32_t c = 0; c < 8; ++c) {
        const std::uint32_t node = data_[r].point.cell + corners_[c];
        if (isActive.holds(node)) action(isActive.before(node), c);
      }
    };
    first_.assign(active_.size() + 1, 0);
    for (std::uint32_t r = 0; r < data_.size(); ++r) {
      bool used = false;
      visit(r, [&](std::uint32_t n, std::uint32_t) { ++first_[n + 1], used = true; });
      if (used) used_.push_back(r);
    }
    rows_.resize(data_.size());
    for (size_t n = 0; n < active_.size(); ++n) first_[n + 1] += first_[n];
    entries_.resize(first_.back());
    diagonal_.assign(active_.size(), kCentre);
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (const std::uint32_t r : used_)
      visit(r, [&](std::uint32_t n, std::uint32_t c) {
        entries_[next[n]++] = r << 3 | c;
        const float weight = data_[r].point.weight(int(c));
        diagonal_[n] += data_[r].weight * weight * weight;
      });
  }

  const std::vector<std::uint32_t>& active_;
  const std::vector<PlateDatum>& data_;
  std::vector<float>& values_;
  std::array<std::uint32_t, 8> corners_;
  std::ptrdiff_t y_, z_;             // offsets to the next node along these axes
  std::vector<std::uint32_t> used_;  // the data that involve an active node
  std::vector<float> rows_, diagonal_;
  std::vector<std::uint32_t> first_, entries_;  // datum * 8 + corner, grouped by node
};

}  // namespace

int solvePlate(const Lattice& lattice, const std::vector<std::uint32_t>& active,
               const std::vector<PlateDatum>& data, const PlateSettings& settings,
               std::vector<float>& values) {
  const NodeSet isActive(lattice.count(), active);
  PlateSystem system(lattice, active, isActive, data, values);
  const double enough = settings.tolerance * settings.tolerance;
  // The solver's directions are zero but at the active nodes. They are laid out for the products in `values` itself, for
  // an array of their own would be a second one as large as the lattice.
  std::vector<float> residual = system.residual(), solution = system.function();
  ValuesAround around(lattice, isActive, values);
  const int steps = conjugateGradients(system, {settings.iterations, enough}, std::move(residual), solution);
  around.putBack();
  system.place(solution);
  return steps;
}

}  // namespace slicemorph
