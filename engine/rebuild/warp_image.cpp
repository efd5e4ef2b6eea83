#include "engine/rebuild/warp_image.h"

#include "engine/rebuild/common_values.h"
#include "engine/rebuild/match_depths.h"
#include "engine/volume/image_sampler.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

/// An image, independent of its number type.
class AnyImage {
 public:
  virtual ~AnyImage() = default;
  /// Adds `weight` times the values at `count` positions (voxel coordinates) that are `step` apart to `sum`.
  virtual void addLine(const Vec3s& first, const Vec3s& step, int count, double weight,
                       double* sum) const = 0;
  virtual double at(const Vec3s& position) const = 0;
};

template <typename T>
class TypedImage : public AnyImage {
 public:
  TypedImage(const ImageLattice& lattice, const std::vector<T>& values) : sampler_(lattice, values) {}
  void addLine(const Vec3s& first, const Vec3s& step, int count, double weight, double* sum) const override {
    sampler_.addLine(first, step, count, weight, sum);
  }
  double at(const Vec3s& position) const override { return double(sampler_(position)); }

 private:
  ImageSampler<T> sampler_;
};

std::unique_ptr<AnyImage> anyImage(const Image& image) {
  return std::visit(
      [&](const auto& values) -> std::unique_ptr<AnyImage> {
        using T = typename std::decay_t<decltype(values)>::value_type;
        return std::make_unique<TypedImage<T>>(image.lattice, values);
      },
      image.values);
}

/// Mean slope of the image across its isosurface, per world unit, from the edges between voxels
/// that cross it.
double slopeAt(const Image& image, double iso) {
  return std::visit(
      [&](const auto& values) {
        const ImageLattice& l = image.lattice;
        const Vec3d spacing = l.spacing();
        const size_t next[3] = {1, size_t(l.size[0]), size_t(l.size[0]) * l.size[1]};
        // One in 2 x 3 x 5 voxels is enough for a mean. Summed slice by slice, so that the result is the same
        // for any number of threads.
        constexpr int kSlices = 5;
        std::vector<std::pair<double, size_t>> slices(size_t(l.size[2] - 1 + kSlices - 1) / kSlices);
        tbb::parallel_for(size_t(0), slices.size(), [&](size_t slice) {
          auto& [sum, count] = slices[slice];
          for (int j = 0; j + 1 < l.size[1]; j += 3)
            for (int i = 0; i + 1 < l.size[0]; i += 2) {
              const size_t at = l.index(i, j, int(slice) * kSlices);
              for (int d = 0; d < 3; ++d) {
                const double a = double(values[at]), b = double(values[at + next[d]]);
                if ((a > iso) != (b > iso)) sum += std::abs(a - b) / spacing[d], ++count;
              }
            }
        });
        double sum = 0;
        size_t count = 0;
        for (const auto& [part, edges] : slices) sum += part, count += edges;
        return count ? sum / double(count) : 0;
      },
      image.values);
}

/// Keeps the image's isosurface at the surface of the in-between: values on the wrong side of the blended isovalue are
/// mirrored at it, by no more than the mean slope times the depth, up to a voxel. Values on their own side stay, and
/// where the images were sampled at their own places so does everything: what is there is the images'.
class KeptSurface {
 public:
  KeptSurface(const std::vector<CarriedImage>& images, const ImageLattice& on) {
    for (const CarriedImage& c : images) {
      if (!c.iso) return;
      iso_ += c.weight * *c.iso;
      slope_ += c.weight * slopeAt(*c.image, *c.iso) / c.size;
    }
    const Vec3d spacing = on.spacing();
    voxel_ = std::min({spacing[0], spacing[1], spacing[2]});
    known_ = true;
  }
  double at(double value, const MatchDepths::Match& match) const {
    const double outwards = match.distance < 0 ? -1 : 1, wrong = outwards * (value - iso_);
    if (!known_ || wrong <= 0) return value;
    const double share = std::min(double(match.shift) / (kFullShift * voxel_), 1.0);
    const double depth = std::min(outwards * double(match.distance), voxel_);
    return value - share * outwards * (wrong + std::min(wrong, slope_ * depth));
  }

 private:
  /// Voxels by which depths must have been shifted for the surface to be kept where it is. Rounding of the objects'
  /// distances is below that.
  static constexpr double kFullShift = 0.5;
  bool known_ = false;
  double iso_ = 0, slope_ = 0, voxel_ = 0;
};

}  // namespace

Image warpImages(const std::vector<CarriedImage>& images, const ImageNodes& nodes, const ImageLattice& on) {
  std::vector<std::unique_ptr<AnyImage>> values;
  std::vector<PositionToVoxel> toVoxel;
  std::vector<PositionRow> rows;
  std::vector<const Image*> all;
  for (const CarriedImage& c : images) {
    values.push_back(anyImage(*c.image));
    toVoxel.emplace_back(c.image->lattice, c.anchor);
    rows.emplace_back(nodes, c.shape);
    all.push_back(c.image);
  }
  Image result{on, commonValues(all, on.count())};
  const MatchDepths matchDepths(images, nodes);
  const KeptSurface kept(images, on);
  tbb::parallel_for(tbb::blocked_range<int>(0, on.size[2]), [&](const tbb::blocked_range<int>& slices) {
    std::vector<double> sum(size_t(on.size[0]));
    std::vector<PositionRow> row = rows;
    std::vector<PositionRow::Stretch> stretch(images.size());
    std::vector<MatchDepths::Position> first(images.size()), last = first, position = first;
    for (int k = slices.begin(); k < slices.end(); ++k)
      for (int j = 0; j < on.size[1]; ++j) {
        std::fill(sum.begin(), sum.end(), 0.0);
        for (PositionRow& r : row) r.begin(0, on.size[0] - 1, j, k);
        bool measured = false;  // `last` holds the end of the previous run, where this one starts
        for (int i = 0, count; i < on.size[0]; i += count) {
          for (size_t c = 0; c < images.size(); ++c) stretch[c] = row[c].from(i);
          count = std::min(stretch[0].length, on.size[0] - i);
          bool near = matchDepths.near({i / nodes.step[0], j / nodes.step[1], k / nodes.step[2]});
          if (near) {
            for (size_t c = 0; c < images.size(); ++c) {
              first[c].at = stretch[c].at;
              last[c].at = stretch[c].at + stretch[c].step * float(stretch[c].length);
            }
            if (measured)
              for (size_t c = 0; c < images.size(); ++c) first[c].distance = last[c].distance;
            else
              matchDepths.measure(first);
            matchDepths.measure(last);
          }
          measured = near;
          near = near && matchDepths.near(first, last);
          for (size_t c = 0; c < images.size() && !near; ++c)
            values[c]->addLine(toVoxel[c](stretch[c].at), toVoxel[c].vector(stretch[c].step), count,
                               images[c].weight, &sum[size_t(i)]);
          for (int n = 0; n < count && near; ++n) {
            for (size_t c = 0; c < images.size(); ++c)
              position[c].at = stretch[c].at + stretch[c].step * float(n);
            matchDepths.measure(position);
            const MatchDepths::Match match = matchDepths.match(position);
            double& value = sum[size_t(i + n)];
            for (size_t c = 0; c < images.size(); ++c)
              value += images[c].weight * values[c]->at(toVoxel[c](position[c].at));
            value = kept.at(value, match);
          }
        }
        storeRow(sum, on.index(0, j, k), result.values);
      }
  });
  return result;
}

}  // namespace slicemorph
