#include "engine/volume/resample_image.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/image_sampler.h"
#include "engine/volume/same_image.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {
namespace {

/// Affine map from one lattice's voxels to another's voxel coordinates.
class Straight {
 public:
  Straight(const ImageLattice& from, const ImageLattice& to) {
    const WorldToVoxel voxel(to);
    origin_ = voxel(from.origin);
    for (int d = 0; d < 3; ++d) {
      step_[d] = voxel.inverse * from.step[d];
      // Rounded, so that voxels that coincide do so exactly.
      for (int e = 0; e < 3; ++e) {
        step_[d][e] = snapped(step_[d][e], 1e-7);
        origin_[e] = snapped(origin_[e], 1e-4);
      }
    }
  }
  Vec3d at(int i, int j, int k) const { return origin_ + i * step_[0] + j * step_[1] + k * step_[2]; }

 private:
  static double snapped(double v, double slack) {
    return std::abs(v - std::rint(v)) < slack ? std::rint(v) : v;
  }
  Vec3d origin_, step_[3];
};

/// The value of the voxel nearest to voxel coordinates; 0 outside.
template <typename T>
T nearestValue(const ImageLattice& lattice, const std::vector<T>& values, const Vec3d& at) {
  const openvdb::Coord v = openvdb::Coord::floor(at + Vec3d(0.5)), n = lattice.size;
  const bool inside = v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && v[0] < n[0] && v[1] < n[1] && v[2] < n[2];
  return inside ? values[lattice.index(v[0], v[1], v[2])] : T(0);
}

}  // namespace

Image resampledTo(const Image& image, const ImageLattice& on) {
  if (sameLattice(image.lattice, on)) return {on, image.values};
  const Straight straight(on, image.lattice);
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const ImageSampler<T> sampler(image.lattice, values);
        std::vector<T> out(on.count());
        tbb::parallel_for(0, on.size[2], [&](int k) {
          for (int j = 0; j < on.size[1]; ++j)
            for (int i = 0; i < on.size[0]; ++i)
              out[on.index(i, j, k)] = storedValue<T>(double(sampler(openvdb::Vec3s(straight.at(i, j, k)))));
        });
        return Image{on, std::move(out)};
      },
      image.values);
}

Image nearestTo(const Image& labels, const ImageLattice& on) {
  if (sameLattice(labels.lattice, on)) return {on, labels.values};
  const Straight straight(on, labels.lattice);
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        std::vector<T> out(on.count());
        tbb::parallel_for(0, on.size[2], [&](int k) {
          for (int j = 0; j < on.size[1]; ++j)
            for (int i = 0; i < on.size[0]; ++i)
              out[on.index(i, j, k)] = nearestValue(labels.lattice, values, straight.at(i, j, k));
        });
        return Image{on, std::move(out)};
      },
      labels.values);
}

ResampledRows::ResampledRows(const Image& image, const ImageLattice& on) {
  std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        if (sameLattice(image.lattice, on)) {
          read_ = [from = values.data(), on](int j, int k, double* row) {
            const T* first = from + on.index(0, j, k);
            std::transform(first, first + on.size[0], row, [](T v) { return double(v); });
          };
          return;
        }
        const Straight straight(on, image.lattice);
        const ImageSampler<T> sampler(image.lattice, values);
        read_ = [straight, sampler, count = on.size[0]](int j, int k, double* row) {
          for (int i = 0; i < count; ++i) row[i] = double(sampler(openvdb::Vec3s(straight.at(i, j, k))));
        };
      },
      image.values);
}

std::vector<SliceRange> sliceRanges(const ImageLattice& lattice) {
  constexpr size_t kVoxels = 1 << 20;
  const size_t slice = size_t(lattice.size[0]) * size_t(lattice.size[1]);
  const int step = int(std::max<size_t>(kVoxels / std::max<size_t>(slice, 1), 1));
  std::vector<SliceRange> ranges;
  for (int k = 0; k < lattice.size[2]; k += step) ranges.push_back({k, std::min(k + step, lattice.size[2])});
  return ranges;
}

Image sampledAt(const Image& image, const ImageLattice& on,
                const std::function<std::vector<Vec3d>(const SliceRange&)>& positions, bool nearest) {
  const WorldToVoxel voxel(image.lattice);
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const ImageSampler<T> sampler(image.lattice, values);
        std::vector<T> out(on.count());
        for (const SliceRange& range : sliceRanges(on)) {
          const std::vector<Vec3d> at = positions(range);
          T* const slice = &out[on.index(0, 0, range.from)];
          tbb::parallel_for(size_t(0), at.size(), [&](size_t i) {
            const Vec3d v = voxel(at[i]);
            slice[i] = nearest ? nearestValue(image.lattice, values, v)
                               : storedValue<T>(double(sampler(openvdb::Vec3s(v))));
          });
        }
        return Image{on, std::move(out)};
      },
      image.values);
}

}  // namespace slicemorph
