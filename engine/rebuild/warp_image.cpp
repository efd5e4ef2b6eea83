#include "engine/rebuild/warp_image.h"

#include "engine/errors.h"
#include "engine/volume/image_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace slicemorph {
namespace {

using openvdb::Vec3f;

/// Where the voxels of an in-between lie in the voxels of every image.
class Places {
 public:
  Places(const ImageNodes& nodes, const std::vector<std::pair<size_t, Vec3d>>& shapes,
         const std::vector<const ImageLattice*>& lattices)
      : nodes_(nodes), images_(lattices.size()) {
    const NodeMap& map = nodes.map;
    const size_t count = size_t(map.size[0]) * map.size[1] * map.size[2];
    at_.resize(count * images_);
    for (size_t k = 0; k < images_; ++k) {
      const WorldToVoxel voxel(*lattices[k]);
      const Vec3d anchor = shapes[k].second;
      tbb::parallel_for(size_t(0), count, [&, k](size_t n) {
        at_[n * images_ + k] = Vec3f(voxel(anchor + Vec3d(map.at[n * map.objects + shapes[k].first])));
      });
    }
  }

  /// The places of image k along the stretch of a row that begins at voxel (i, j, k) and ends before the next
  /// node: the first one and the way from each to the next.
  struct Stretch {
    Vec3f at, step;
    int length;
  };
  Stretch stretch(size_t image, const openvdb::Coord& v) const {
    const openvdb::Vec3i& s = nodes_.step;
    const openvdb::Coord node(v[0] / s[0], v[1] / s[1], v[2] / s[2]);
    const float fy = float(v[1] - node[1] * s[1]) / float(s[1]),
                fz = float(v[2] - node[2] * s[2]) / float(s[2]);
    const auto column = [&](int i) {
      const Vec3f low = at(image, i, node[1], node[2]) * (1 - fy) + at(image, i, node[1] + 1, node[2]) * fy;
      const Vec3f high =
          at(image, i, node[1], node[2] + 1) * (1 - fy) + at(image, i, node[1] + 1, node[2] + 1) * fy;
      return low * (1 - fz) + high * fz;
    };
    const Vec3f first = column(node[0]), step = (column(node[0] + 1) - first) / float(s[0]);
    const int offset = v[0] - node[0] * s[0];
    return {first + step * float(offset), step, s[0] - offset};
  }

  /// Box of an image's voxels around all that a box of the in-between's voxels lies on.
  openvdb::CoordBBox boxOf(size_t image, const openvdb::CoordBBox& box) const {
    const openvdb::Vec3i& s = nodes_.step;
    Vec3f low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (int k = box.min()[2] / s[2]; k <= box.max()[2] / s[2] + 1; ++k)
      for (int j = box.min()[1] / s[1]; j <= box.max()[1] / s[1] + 1; ++j)
        for (int i = box.min()[0] / s[0]; i <= box.max()[0] / s[0] + 1; ++i) {
          const Vec3f& p = at(image, i, j, k);
          low = openvdb::math::minComponent(low, p), high = openvdb::math::maxComponent(high, p);
        }
    return {openvdb::Coord::floor(low), openvdb::Coord::ceil(high)};
  }

 private:
  const Vec3f& at(size_t image, int i, int j, int k) const {
    return at_[nodes_.map.index(i, j, k) * images_ + image];
  }

  const ImageNodes& nodes_;
  size_t images_;
  std::vector<Vec3f> at_;  ///< per node and image, voxels
};

/// Trilinear values of an image; beyond its outermost voxel centres by half a voxel that of the nearest,
/// further out `outside`.
template <typename T>
class Sampler {
 public:
  Sampler(const ImageLattice& lattice, const std::vector<T>& values)
      : values_(values.data()), n_(lattice.size), y_(size_t(n_[0])), z_(size_t(n_[0]) * n_[1]) {
    outside_ = values.empty() ? 0 : float(*std::min_element(values.begin(), values.end()));
  }

  double at(const Vec3f& p) const {
    const int i = int(p[0]), j = int(p[1]), k = int(p[2]);
    if (p[0] >= 0 && p[1] >= 0 && p[2] >= 0 && i + 1 < n_[0] && j + 1 < n_[1] && k + 1 < n_[2]) {
      const T* v = values_ + size_t(k) * z_ + size_t(j) * y_ + size_t(i);
      const double x = p[0] - float(i), y = p[1] - float(j), z = p[2] - float(k);
      const double a = v[0] + x * (double(v[1]) - v[0]), b = v[y_] + x * (double(v[y_ + 1]) - v[y_]);
      const T* w = v + z_;
      const double c = w[0] + x * (double(w[1]) - w[0]), d = w[y_] + x * (double(w[y_ + 1]) - w[y_]);
      const double low = a + y * (b - a), high = c + y * (d - c);
      return low + z * (high - low);
    }
    return atFace(p);
  }

 private:
  double atFace(const Vec3f& p) const {
    int at[3];
    double f[3];
    for (int d = 0; d < 3; ++d) {
      if (!(p[d] >= -0.5f && p[d] <= float(n_[d]) - 0.5f)) return outside_;
      const float q = std::min(std::max(p[d], 0.f), float(n_[d] - 1));
      at[d] = std::max(0, std::min(int(q), n_[d] - 2));
      f[d] = q - float(at[d]);
    }
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      const double w = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]);
      if (w > 0)
        sum += w * double(values_[size_t(at[2] + (c >> 2)) * z_ + size_t(at[1] + (c >> 1 & 1)) * y_ +
                                  size_t(at[0] + (c & 1))]);
    }
    return sum;
  }

  const T* values_;
  openvdb::Coord n_;
  size_t y_, z_;
  double outside_;
};

/// The number type that holds the values of all images.
ImageValues commonValues(const std::vector<const Image*>& images, size_t count) {
  bool same = true, whole = true, wide = false, negative = false, large = false;
  for (const Image* image : images) {
    const size_t type = image->values.index();
    same &= type == images[0]->values.index();
    whole &= type <= 3, wide |= type == 3 || type == 5, negative |= type == 1 || type == 3,
        large |= type == 2 || type == 3;
  }
  if (same) {
    return std::visit([&](const auto& v) -> ImageValues { return std::decay_t<decltype(v)>(count); },
                      images[0]->values);
  }
  if (!whole) return wide ? ImageValues(std::vector<double>(count)) : ImageValues(std::vector<float>(count));
  if (wide || (negative && large)) return std::vector<std::int32_t>(count);
  return negative ? ImageValues(std::vector<std::int16_t>(count))
                  : ImageValues(std::vector<std::uint16_t>(count));
}

template <typename T>
T stored(double value) {
  if constexpr (!std::is_integral_v<T>) return T(value);
  const double low = double(std::numeric_limits<T>::min()), high = double(std::numeric_limits<T>::max());
  return T(std::floor(std::min(std::max(value, low), high) + 0.5));
}

void storeRow(const std::vector<double>& row, size_t first, ImageValues& values) {
  std::visit(
      [&](auto& out) {
        using T = typename std::decay_t<decltype(out)>::value_type;
        std::transform(row.begin(), row.end(), out.begin() + std::ptrdiff_t(first), stored<T>);
      },
      values);
}

ImageValues labelValues(std::int64_t most, size_t count) {
  if (most <= 255) return std::vector<std::uint8_t>(count);
  if (most <= 65535) return std::vector<std::uint16_t>(count);
  return std::vector<std::int32_t>(count);
}

bool sameLattice(const ImageLattice& a, const ImageLattice& b) {
  if (a.size != b.size) return false;
  const double voxel = std::min({a.spacing()[0], a.spacing()[1], a.spacing()[2]});
  for (int c = 0; c < 8; ++c) {
    const Vec3d v((c & 1) * (a.size[0] - 1), (c >> 1 & 1) * (a.size[1] - 1), (c >> 2) * (a.size[2] - 1));
    if ((a.toWorld(v) - b.toWorld(v)).length() > 1e-4 * voxel) return false;
  }
  return true;
}

/// Places of one lattice's voxels in another's, straight.
class Straight {
 public:
  Straight(const ImageLattice& from, const ImageLattice& to) {
    const WorldToVoxel voxel(to);
    origin_ = voxel(from.origin);
    for (int d = 0; d < 3; ++d) {
      step_[d] = voxel.inverse * from.step[d];
      // Voxels that coincide do so exactly.
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

/// How fast values change across the surface, per world unit: over the edges between voxels that it crosses.
double slopeAt(const Image& image, double iso) {
  return std::visit(
      [&](const auto& values) {
        const ImageLattice& l = image.lattice;
        const Vec3d spacing = l.spacing();
        const size_t next[3] = {1, size_t(l.size[0]), size_t(l.size[0]) * l.size[1]};
        double sum = 0;
        size_t count = 0;
        // Every 30th voxel is enough for a mean.
        for (int k = 0; k + 1 < l.size[2]; k += 5)
          for (int j = 0; j + 1 < l.size[1]; j += 3)
            for (int i = 0; i + 1 < l.size[0]; i += 2) {
              const size_t at = l.index(i, j, k);
              for (int d = 0; d < 3; ++d) {
                const double a = double(values[at]), b = double(values[at + next[d]]);
                if ((a > iso) != (b > iso)) sum += std::abs(a - b) / spacing[d], ++count;
              }
            }
        return count ? sum / double(count) : 0;
      },
      image.values);
}

/// Keeps an in-between's surface where its shape has it: values inside stay above the blended iso value and
/// those outside below, by the usual slope within a voxel of the surface.
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
  double at(double value, double distance) const {
    if (!known_) return value;
    const double least = iso_ - slope_ * std::min(std::max(distance, -voxel_), voxel_);
    return distance < 0 ? std::max(value, least) : std::min(value, least);
  }

 private:
  bool known_ = false;
  double iso_ = 0, slope_ = 0, voxel_ = 0;
};

/// Depths of images near the surfaces of the in-between and of their objects.
class Depths {
 public:
  Depths(const std::vector<CarriedImage>& images, const ImageNodes& nodes) : images_(images), nodes_(nodes) {
    bool all = images.size() > 1;
    for (const CarriedImage& c : images) all = all && c.field;
    if (!all) return;
    for (const CarriedImage& c : images) {
      voxels_.emplace_back(c.image->lattice);
      reach_ += c.weight * c.size * kReach * c.field->voxelSize();
      for (int d = 0; d < 3; ++d)
        offset_.push_back((voxels_.back().inverse * (c.anchor - voxels_.back().origin))[d]);
    }
    findCells();
  }

  bool near(const openvdb::Coord& node) const {
    return !near_.empty() && near_[nodes_.map.index(node[0], node[1], node[2])];
  }

  /// What one task works with.
  struct Scratch {
    std::vector<DistanceField::Sampler> samplers;
    std::vector<float> distance;
    std::vector<Vec3f> place, first,
        step;                  ///< world, relative to the fields' anchors; first and step: of a stretch
    std::vector<Vec3f> voxel;  ///< result: where each image is to be looked up, in its own voxels
  };
  Scratch scratch() const {
    Scratch s;
    for (const CarriedImage& c : images_) s.samplers.emplace_back(*c.field);
    s.distance.resize(images_.size());
    for (auto* list : {&s.place, &s.first, &s.step, &s.voxel}) list->resize(images_.size());
    return s;
  }

  /// Begins the stretch of a row that goes from voxel v to the next node.
  void begin(const openvdb::Coord& v, Scratch& s) const {
    const int across = nodes_.step[0], offset = v[0] % across;
    for (size_t c = 0; c < images_.size(); ++c) {
      const openvdb::Coord node(v[0] - offset, v[1], v[2]);
      const Vec3f low = placeOf(images_[c].shape, node),
                  high = placeOf(images_[c].shape, node.offsetBy(across, 0, 0));
      s.step[c] = (high - low) / float(across);
      s.first[c] = low + s.step[c] * float(offset);
    }
  }

  /// Where each image is to be looked up for the n-th voxel of the stretch. Returns the in-between's
  /// distance.
  float find(int n, Scratch& s) const {
    float blended = 0;
    bool away = true;
    for (size_t c = 0; c < images_.size(); ++c) {
      s.place[c] = s.first[c] + s.step[c] * float(n);
      s.distance[c] = s.samplers[c].coarse(s.place[c]);
      blended += float(images_[c].weight * images_[c].size) * s.distance[c];
    }
    for (size_t c = 0; c < images_.size() && away; ++c)
      away = (s.distance[c] < 0) == (blended < 0) &&
             std::abs(s.distance[c]) > float(images_[c].field->voxelSize());
    if (!(away && std::abs(blended) > float(reach_))) blended = match(s);
    for (size_t c = 0; c < images_.size(); ++c) {
      const Vec3d p = voxels_[c].inverse * Vec3d(s.place[c]);
      s.voxel[c] = Vec3f(float(p[0] + offset_[3 * c]), float(p[1] + offset_[3 * c + 1]),
                         float(p[2] + offset_[3 * c + 2]));
    }
    return blended;
  }

 private:
  /// Voxels around the surface in which depths are matched.
  static constexpr double kReach = 3;

  /// Moves the places to like depths.
  float match(Scratch& s) const {
    float blended = 0;
    for (size_t c = 0; c < images_.size(); ++c) {
      s.distance[c] = s.samplers[c](s.place[c]);
      blended += float(images_[c].weight * images_[c].size) * s.distance[c];
    }
    const float away = std::abs(blended) / float(reach_);
    const float fade = std::min(std::max(2 - 2 * away, 0.f), 1.f);
    for (size_t c = 0; c < images_.size(); ++c) {
      const CarriedImage& image = images_[c];
      const float target = blended / float(image.size);
      const bool otherSide = (s.distance[c] < 0) != (blended < 0);
      const float wrong =
          otherSide ? std::min(std::abs(s.distance[c]) / float(image.field->voxelSize()), 1.f) : 0.f;
      const float share = std::max(fade, wrong);
      const float level = s.distance[c] + share * (target - s.distance[c]);
      if (share > 0) s.place[c] = moved(c, s.place[c], s.distance[c], level, s.samplers[c]);
    }
    return blended;
  }

  /// A place moved along the way to the surface to where its distance is `level`; a little way by the
  /// gradient there, a long one by way of the nearest surface point. Where the wall is thinner than that,
  /// just inside.
  Vec3f moved(size_t c, const Vec3f& place, float distance, float level,
              const DistanceField::Sampler& sampler) const {
    const CarriedImage& image = images_[c];
    const float voxel = float(image.field->voxelSize()), way = level - distance;
    if (std::abs(way) < 0.05f * voxel) return place;
    if (std::abs(way) < 1.5f * voxel)
      return place + Vec3f(image.field->gradient(image.anchor + Vec3d(place))) * way;
    const Vec3d surface = image.field->closest(image.anchor + Vec3d(place));
    const Vec3f at(surface - image.anchor), outwards(image.field->gradient(surface));
    const Vec3f there = at + outwards * level;
    return (sampler(there) < 0) == (level < 0)
               ? there
               : at + outwards * std::copysign(std::min(0.5f * voxel, std::abs(level)), level);
  }

  Vec3f placeOf(size_t shape, const openvdb::Coord& v) const {
    const NodeMap& map = nodes_.map;
    int node[3];
    float f[3];
    for (int d = 0; d < 3; ++d) {
      node[d] = v[d] / nodes_.step[d];
      f[d] = float(v[d] - node[d] * nodes_.step[d]) / float(nodes_.step[d]);
    }
    Vec3f sum(0.f);
    for (int c = 0; c < 8; ++c) {
      const float w = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]);
      sum +=
          w * map.at[map.index(node[0] + (c & 1), node[1] + (c >> 1 & 1), node[2] + (c >> 2)) * map.objects +
                     shape];
    }
    return sum;
  }

  /// Cells that a surface may pass, by the distances at their corners.
  void findCells() {
    const NodeMap& map = nodes_.map;
    const size_t count = size_t(map.size[0]) * map.size[1] * map.size[2];
    std::vector<char> nodeNear(count);
    tbb::parallel_for(size_t(0), count, [&](size_t n) {
      float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
      for (const CarriedImage& c : images_) {
        const float d = float(c.size) * c.field->coarse(c.anchor + Vec3d(map.at[n * map.objects + c.shape]));
        low = std::min(low, d), high = std::max(high, d);
      }
      nodeNear[n] = low < float(reach_) && high > -float(reach_);
    });
    near_.assign(count, 0);
    const openvdb::Coord o = map.origin;
    for (int k = 0; k + 1 < map.size[2]; ++k)
      for (int j = 0; j + 1 < map.size[1]; ++j)
        for (int i = 0; i + 1 < map.size[0]; ++i) {
          char any = 0;
          for (int c = 0; c < 8; ++c)
            any |= nodeNear[map.index(o[0] + i + (c & 1), o[1] + j + (c >> 1 & 1), o[2] + k + (c >> 2))];
          near_[map.index(o[0] + i, o[1] + j, o[2] + k)] = any;
        }
  }

  const std::vector<CarriedImage>& images_;
  const ImageNodes& nodes_;
  std::vector<WorldToVoxel> voxels_;
  std::vector<double> offset_;  ///< three per image: of its anchor, voxels
  double reach_ = 0;            ///< world units of the in-between
  std::vector<char> near_;      ///< per cell, by its first node
};

}  // namespace

ImageNodes imageNodes(const ImageLattice& on, const Carrying& carrying, double spacing) {
  ImageNodes nodes;
  ImageLattice coarse = on;
  openvdb::Coord last;
  for (int d = 0; d < 3; ++d) {
    nodes.step[d] = std::max(1, int(std::lround(spacing / on.spacing()[d])));
    coarse.step[d] = double(nodes.step[d]) * on.step[d];
    last[d] = (on.size[d] - 1) / nodes.step[d] + 1;
  }
  nodes.map = carryingNodes({openvdb::Coord(0), last}, carrying, *transformOf(coarse), 1);
  return nodes;
}

Image warpImages(const std::vector<CarriedImage>& images, const ImageNodes& nodes, const ImageLattice& on) {
  std::vector<std::pair<size_t, Vec3d>> shapes;
  std::vector<const ImageLattice*> lattices;
  std::vector<const Image*> all;
  for (const CarriedImage& c : images) {
    shapes.emplace_back(c.shape, c.anchor);
    lattices.push_back(&c.image->lattice);
    all.push_back(c.image);
  }
  const Places places(nodes, shapes, lattices);
  Image result{on, commonValues(all, on.count())};
  const Depths depths(images, nodes);
  const KeptSurface kept(images, on);
  // A value of one type after another: the row is summed in the widest.
  std::vector<std::function<void(std::vector<double>&, int, int)>> addRow;
  std::vector<std::function<double(const Vec3f&)>> sample;
  for (size_t c = 0; c < images.size(); ++c)
    std::visit(
        [&](const auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          const Sampler<T> sampler(*lattices[c], values);
          sample.push_back([sampler](const Vec3f& p) { return sampler.at(p); });
          addRow.push_back([&places, &on, &depths, &nodes, sampler, c, weight = images[c].weight](
                               std::vector<double>& row, int j, int k) {
            for (int i = 0; i < on.size[0];) {
              const Places::Stretch s = places.stretch(c, {i, j, k});
              const int end = std::min(i + s.length, on.size[0]);
              if (depths.near({i / nodes.step[0], j / nodes.step[1], k / nodes.step[2]})) {
                i = end;
                continue;
              }
              for (int n = 0; i < end; ++i, ++n)
                row[size_t(i)] += weight * sampler.at(s.at + s.step * float(n));
            }
          });
        },
        images[c].image->values);
  tbb::parallel_for(0, on.size[2], [&](int k) {
    std::vector<double> row(size_t(on.size[0]));
    std::optional<Depths::Scratch> scratch;
    for (int j = 0; j < on.size[1]; ++j) {
      std::fill(row.begin(), row.end(), 0.0);
      for (const auto& add : addRow) add(row, j, k);
      for (int i = 0, end; i < on.size[0]; i = end) {
        end = std::min(i + nodes.step[0] - i % nodes.step[0], on.size[0]);
        if (!depths.near({i / nodes.step[0], j / nodes.step[1], k / nodes.step[2]})) continue;
        if (!scratch) scratch = depths.scratch();
        depths.begin({i, j, k}, *scratch);
        for (int v = i; v < end; ++v) {
          const float distance = depths.find(v - i, *scratch);
          for (size_t c = 0; c < images.size(); ++c)
            row[size_t(v)] += images[c].weight * sample[c](scratch->voxel[c]);
          row[size_t(v)] = kept.at(row[size_t(v)], distance);
        }
      }
      storeRow(row, on.index(0, j, k), result.values);
    }
  });
  return result;
}

Image resampledTo(const Image& image, const ImageLattice& on) {
  if (sameLattice(image.lattice, on)) return {on, image.values};
  const Straight straight(on, image.lattice);
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const Sampler<T> sampler(image.lattice, values);
        std::vector<T> out(on.count());
        tbb::parallel_for(0, on.size[2], [&](int k) {
          for (int j = 0; j < on.size[1]; ++j)
            for (int i = 0; i < on.size[0]; ++i)
              out[on.index(i, j, k)] = stored<T>(sampler.at(Vec3f(straight.at(i, j, k))));
        });
        return Image{on, std::move(out)};
      },
      image.values);
}

Image warpLabels(const std::vector<CarriedLabels>& labels, const ImageNodes& nodes, const ImageLattice& on) {
  std::vector<std::pair<size_t, Vec3d>> shapes;
  std::vector<const ImageLattice*> lattices;
  std::vector<std::int64_t> all;
  for (const CarriedLabels& c : labels) {
    shapes.emplace_back(c.shape, c.anchor);
    lattices.push_back(&c.labels->lattice());
    for (const LabelField::Label& l : c.labels->labels()) all.push_back(l.value);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  // Each label's field in every object; null where it lacks the label.
  std::vector<std::vector<const LabelField::Label*>> fieldOf(labels.size());
  std::vector<std::vector<int>> placeOf(labels.size());  // index into `all` of the object's own labels
  for (size_t c = 0; c < labels.size(); ++c) {
    for (std::int64_t value : all) fieldOf[c].push_back(labels[c].labels->find(value));
    for (const LabelField::Label& l : labels[c].labels->labels())
      placeOf[c].push_back(int(std::lower_bound(all.begin(), all.end(), l.value) - all.begin()));
  }
  // A label that an object lacks shrinks to nothing as that object takes over.
  std::vector<float> absent(all.size(), 0);
  for (size_t l = 0; l < all.size(); ++l) {
    float deepest = 0, have = 0;
    for (size_t c = 0; c < labels.size(); ++c)
      if (fieldOf[c][l]) deepest = std::max(deepest, fieldOf[c][l]->deepest), have += float(labels[c].weight);
    absent[l] = -deepest * have;
  }
  const Places places(nodes, shapes, lattices);
  Image result{on, labelValues(all.empty() ? 0 : all.back(), on.count())};
  constexpr int kBlock = 8;
  const openvdb::Coord blocks = (on.size + openvdb::Coord(kBlock - 1)) >> 3;
  tbb::parallel_for(0, blocks[2] * blocks[1], [&](int b) {
    std::vector<int> near, candidates;
    std::vector<float> blended;
    for (int bi = 0; bi < blocks[0]; ++bi) {
      const openvdb::Coord first(bi * kBlock, b % blocks[1] * kBlock, b / blocks[1] * kBlock);
      const openvdb::Coord end = openvdb::Coord::minComponent(first + openvdb::Coord(kBlock), on.size);
      candidates.clear();
      for (size_t c = 0; c < labels.size(); ++c) {
        near.clear();
        openvdb::CoordBBox box = places.boxOf(c, {first, end - openvdb::Coord(1)});
        box.expand(1);
        labels[c].labels->labelsNear(box, near);
        for (int l : near) candidates.push_back(placeOf[c][size_t(l)]);
      }
      if (candidates.empty()) continue;  // 0 as it is
      std::sort(candidates.begin(), candidates.end());
      candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
      blended.resize(candidates.size());
      for (int k = first[2]; k < end[2]; ++k)
        for (int j = first[1]; j < end[1]; ++j)
          for (int i = first[0]; i < end[0]; ++i) {
            std::fill(blended.begin(), blended.end(), 0.f);
            float without = 0;
            for (size_t c = 0; c < labels.size(); ++c) {
              const Vec3f p = places.stretch(c, {i, j, k}).at;
              const float weight = float(labels[c].weight);
              float most = labels[c].labels->depth(labels[c].labels->all(), p);
              for (size_t l = 0; l < candidates.size(); ++l) {
                const LabelField::Label* field = fieldOf[c][size_t(candidates[l])];
                const float depth =
                    field ? labels[c].labels->depth(*field, p) : absent[size_t(candidates[l])];
                if (!field) most = std::max(most, depth);
                blended[l] += weight * depth;
              }
              without -= weight * most;
            }
            int best = -1;
            float least = without;
            for (size_t l = 0; l < candidates.size(); ++l)
              if (blended[l] > least) least = blended[l], best = candidates[l];
            if (best >= 0)
              std::visit(
                  [&](auto& values) {
                    using T = typename std::decay_t<decltype(values)>::value_type;
                    values[on.index(i, j, k)] = T(all[size_t(best)]);
                  },
                  result.values);
          }
    }
  });
  return result;
}

Image nearestTo(const Image& labels, const ImageLattice& on) {
  if (sameLattice(labels.lattice, on)) return {on, labels.values};
  const Straight straight(on, labels.lattice);
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        std::vector<T> out(on.count(), T(0));
        const openvdb::Coord n = labels.lattice.size;
        tbb::parallel_for(0, on.size[2], [&](int k) {
          for (int j = 0; j < on.size[1]; ++j)
            for (int i = 0; i < on.size[0]; ++i) {
              const openvdb::Coord v = openvdb::Coord::floor(straight.at(i, j, k) + Vec3d(0.5));
              if (v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && v[0] < n[0] && v[1] < n[1] && v[2] < n[2])
                out[on.index(i, j, k)] = values[labels.lattice.index(v[0], v[1], v[2])];
            }
        });
        return Image{on, std::move(out)};
      },
      labels.values);
}

}  // namespace slicemorph
