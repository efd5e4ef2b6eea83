#include "engine/peers/wavelet.h"

#include <tbb/parallel_for.h>

#include <tuple>
#include <utility>

namespace slicemorph {
namespace {

/// Mean in the place of the first, half the difference in the place of the second.
std::pair<float, float> meanAndDetail(float a, float b) { return {(a + b) / 2, (a - b) / 2}; }
std::pair<float, float> bothAgain(float mean, float detail) { return {mean + detail, mean - detail}; }

/// Replaces the pairs of one level along an axis: of nodes at multiples of `step`, where the means of the level before are.
template <typename Pair>
void replacePairs(const Lattice& lattice, int axis, int step, const Pair& pair, std::vector<float>& values) {
  const int across = axis == 0 ? 1 : 0, along = axis == 2 ? 1 : 2;
  openvdb::Coord next(0);
  next[axis] = step;
  const size_t toNext = lattice.index(next);
  tbb::parallel_for(0, lattice.size[along] / step, [&](int i) {
    openvdb::Coord c(0);
    c[along] = i * step;
    for (c[across] = 0; c[across] < lattice.size[across]; c[across] += step)
      for (c[axis] = 0; c[axis] < lattice.size[axis]; c[axis] += 2 * step) {
        float *first = &values[lattice.index(c)], *second = first + toNext;
        std::tie(*first, *second) = pair(*first, *second);
      }
  });
}

class HaarTransform : public LatticeTransform {
 public:
  explicit HaarTransform(int levels) : levels_(levels) {}

  int nodes(int atLeast) const override {
    const int block = 1 << levels_;
    return (atLeast + block - 1) / block * block;
  }
  void forward(const Lattice& lattice, std::vector<float>& values) const override {
    for (int level = 0; level < levels_; ++level)
      for (int axis = 0; axis < 3; ++axis) replacePairs(lattice, axis, 1 << level, meanAndDetail, values);
  }
  void inverse(const Lattice& lattice, std::vector<float>& values) const override {
    for (int level = levels_ - 1; level >= 0; --level)
      for (int axis = 2; axis >= 0; --axis) replacePairs(lattice, axis, 1 << level, bothAgain, values);
  }
  /// Nodes at odd multiples of 2^level along any axis have details of that level.
  double fineness(const Lattice&, const openvdb::Coord& part) const override {
    const int bits = part[0] | part[1] | part[2];
    for (int level = 0; level < levels_; ++level)
      if (bits >> level & 1) return double(levels_ - level) / levels_;
    return 0;
  }

 private:
  int levels_;
};

}  // namespace

std::unique_ptr<LatticeTransform> haarTransform(int levels) {
  return std::make_unique<HaarTransform>(levels);
}

}  // namespace slicemorph
