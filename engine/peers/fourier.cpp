#include "engine/peers/fourier.h"

#include <tbb/parallel_for.h>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <cmath>
#include <complex>

namespace slicemorph {
namespace {

/// Whether there are no prime factors but 2, 3 and 5, for which the transform is fast.
bool isSmooth(int n) {
  for (const int factor : {2, 3, 5})
    while (n % factor == 0) n /= factor;
  return n == 1;
}

/// The cosine series of one line and its mirror image. Scaled so that the second time gives the line back.
class LineTransform {
 public:
  explicit LineTransform(int nodes) : mirrored_(2 * size_t(nodes - 1)) {
    fft_.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  }
  void operator()(float* line, size_t stride) {
    const size_t last = mirrored_.size() / 2;
    for (size_t i = 0; i <= last; ++i) mirrored_[i] = double(line[i * stride]);
    for (size_t i = 1; i < last; ++i) mirrored_[last + i] = mirrored_[last - i];
    fft_.fwd(series_, mirrored_);
    const double scale = 1 / std::sqrt(double(mirrored_.size()));
    for (size_t i = 0; i <= last; ++i) line[i * stride] = float(scale * series_[i].real());
  }

 private:
  Eigen::FFT<double> fft_;
  std::vector<double> mirrored_;
  std::vector<std::complex<double>> series_;
};

/// All lines along an axis; each on its own, so that results are the same for any number of threads.
void transformLines(const Lattice& lattice, int axis, std::vector<float>& values) {
  const int across = axis == 0 ? 1 : 0, along = axis == 2 ? 1 : 2;
  openvdb::Coord step(0);
  step[axis] = 1;
  const size_t stride = lattice.index(step);
  tbb::parallel_for(tbb::blocked_range<int>(0, lattice.size[along]), [&](const auto& range) {
    LineTransform transform(lattice.size[axis]);
    openvdb::Coord start(0);
    for (start[along] = range.begin(); start[along] != range.end(); ++start[along])
      for (start[across] = 0; start[across] < lattice.size[across]; ++start[across])
        transform(&values[lattice.index(start)], stride);
  });
}

class CosineTransform : public LatticeTransform {
 public:
  explicit CosineTransform(double cutoff) : cutoff_(cutoff) {}

  int nodes(int atLeast) const override {
    int intervals = std::max(atLeast - 1, 1);
    while (!isSmooth(intervals)) ++intervals;
    return intervals + 1;
  }
  void forward(const Lattice& lattice, std::vector<float>& values) const override {
    for (int axis = 0; axis < 3; ++axis) transformLines(lattice, axis, values);
  }
  void inverse(const Lattice& lattice, std::vector<float>& values) const override {
    forward(lattice, values);
  }
  double fineness(const Lattice& lattice, const openvdb::Coord& part) const override {
    const Vec3d intervals = (lattice.size - openvdb::Coord(1)).asVec3d();
    const double longest = std::max({intervals[0], intervals[1], intervals[2]});
    const double halfWaves = longest * (part.asVec3d() / intervals).length();
    return std::min(halfWaves / cutoff_, 1.0);
  }

 private:
  double cutoff_;
};

}  // namespace

std::unique_ptr<LatticeTransform> cosineTransform(double cutoff) {
  return std::make_unique<CosineTransform>(cutoff);
}

}  // namespace slicemorph
