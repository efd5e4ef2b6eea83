#include "engine/match/match_densities.h"

#include "engine/match/fold_guard.h"
#include "engine/numerics/conjugate_gradients.h"

#include <openvdb/tools/Interpolation.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace slicemorph {

namespace {

using Vec = Eigen::Vector3f;
using Values = std::vector<float>;
using Vectors = std::vector<Vec>;

// Figures of a prototype that was tried on four simulated scenes and one from a library, each at several triples of
// frames: each is worth a few hundredths of the error of the frame between.

/// Most points of the finest images along their longest side, and nodes between two of which there are so many of them.
constexpr int kMostPoints = 224, kFinest = 2;
/// The coarsest level has at least so many nodes along the longest side.
constexpr int kCoarsestNodes = 9;
constexpr int kPad = 10;  ///< empty points around the densities
/// Densities are taken to this power, relative to what all but a hundredth of the voxels stay below, so that thin smoke counts.
constexpr float kCompression = 0.25f, kTiny = 1e-6f;
constexpr double kFaint = 1e-3, kHigh = 0.99;
/// Smoothing of a level's images, in its spacings.
constexpr float kPresmooth = 0.5f;
/// Weight of the second channel, which compares patterns whatever their strength; its window in nodes, and the deviation
/// below which there is none.
constexpr float kLocal = 0.3f, kWindow = 2.5f, kDeviation = 0.05f;
constexpr int kNewtonSteps = 6;  ///< of Gauss and Newton per level
constexpr int kLinearSteps = 8;  ///< of conjugate gradients per step
constexpr float kSteep = 0.2f;   ///< gradients beyond it count no more
/// Over which the equations are averaged, nodes. What is fitted closer is not how smoke moved: 1.5 and 2 leave less error half
/// way than 1 in a jet and in vortices, in a plume a hundredth more; 2 finds turns by 140 degrees less well.
constexpr float kSpread = 1.5f;
constexpr float kRoughness = 0.02f;  ///< price of differences between neighbours
constexpr float kDivergence = 0.1f;
constexpr float kMemory = 0.2f;    ///< how much of both is for the whole map, not only for a step
constexpr float kLongestStep = 1;  ///< nodes
/// Velocities are looked at on nodes twice as far apart as the finest, and followed in so many steps to either side. How
/// much time passes is tried out: from such a way of the fastest node, in nodes, by such a factor, up to such a way. The
/// result is a start where it leaves at most this share of what nothing leaves.
constexpr int kVelocityStep = 2 * kFinest, kSwimmingSteps = 8;
constexpr float kLeastWay = 0.5f, kTimeFactor = 1.25f, kMostWay = 60;
constexpr double kWorthStarting = 0.9;
constexpr double kLeastSeen = 0.5;  ///< share of both densities' total
/// Velocities bend paths whose ways they tell: where both correlate by at least so much. At so many rounds the places at
/// which they are looked up settle. What does not correlate is not on the ways found, so that the bends are averaged over
/// the smoke, the farther the less of it does: over so many nodes where nothing does (of a jet 2, 3 and 4 do much the same).
constexpr double kToldWays = 0.5;
constexpr int kBendRounds = 3;
constexpr double kBendSpread = 3;
constexpr float kNoSmoke = 1e-3f;  ///< weight in such means where there is no smoke; smoke's is about 1
/// Around the map it fades to nothing at least so slowly, in displacements.
constexpr double kFade = 2.5;

/// Lattices here are in node units: their origin and spacing are not used.
size_t strideOf(const Lattice& box, int axis) {
  return axis == 0 ? 1 : axis == 1 ? size_t(box.size[0]) : size_t(box.size[0]) * box.size[1];
}

/// Calls action(i, x, y, z) for all nodes, in slabs of one task each.
template <typename Action>
void forNodes(const Lattice& box, const Action& action) {
  tbb::parallel_for(0, box.size[2], [&](int z) {
    for (int y = 0; y < box.size[1]; ++y)
      for (int x = 0; x < box.size[0]; ++x) action(box.index(x, y, z), x, y, z);
  });
}

Vec nodeAt(int x, int y, int z) { return {float(x), float(y), float(z)}; }

/// Trilinear value at a point in node units; beyond the box that of its rim.
template <typename T>
T sample(const Lattice& box, const std::vector<T>& values, const Vec& p) {
  int low[3], high[3];
  float f[3];
  for (int a = 0; a < 3; ++a) {
    const float c = std::min(std::max(p[a], 0.f), float(box.size[a] - 1));
    low[a] = std::min(int(c), box.size[a] - 1), high[a] = std::min(low[a] + 1, box.size[a] - 1);
    f[a] = c - float(low[a]);
  }
  const auto row = [&](int y, int z) {
    return T(values[box.index(low[0], y, z)] * (1 - f[0]) + values[box.index(high[0], y, z)] * f[0]);
  };
  const auto slab = [&](int z) { return T(row(low[1], z) * (1 - f[1]) + row(high[1], z) * f[1]); };
  return T(slab(low[2]) * (1 - f[2]) + slab(high[2]) * f[2]);
}

/// Gauss's bell over the values, which go on mirrored beyond the box.
template <typename T>
std::vector<T> blurred(const Lattice& box, std::vector<T> values, float sigma) {
  const int reach = int(std::ceil(3 * sigma));
  if (reach < 1) return values;
  Values bell(size_t(reach) + 1);
  float sum = 0;
  for (int k = 0; k <= reach; ++k) {
    bell[size_t(k)] = std::exp(-0.5f * float(k * k) / (sigma * sigma));
    sum += (k ? 2 : 1) * bell[size_t(k)];
  }
  for (float& b : bell) b /= sum;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<T> old = values;
    const int n = box.size[axis];
    const std::ptrdiff_t stride = std::ptrdiff_t(strideOf(box, axis));
    forNodes(box, [&](size_t i, int x, int y, int z) {
      const int at[3] = {x, y, z}, c = at[axis];
      const T* own = &old[i];
      T result = *own * bell[0];
      for (int k = 1; k <= reach; ++k)
        for (int c2 : {c - k, c + k}) {
          while (c2 < 0 || c2 >= n) c2 = c2 < 0 ? -1 - c2 : 2 * n - 1 - c2;
          result += own[(c2 - c) * stride] * bell[size_t(k)];
        }
      values[i] = result;
    });
  }
  return values;
}

/// Central difference along an axis; at the rim the box goes on with its last values.
template <typename T>
T difference(const Lattice& box, const std::vector<T>& values, size_t i, int c, int axis) {
  const size_t stride = strideOf(box, axis);
  const T &before = values[c > 0 ? i - stride : i], &after = values[c + 1 < box.size[axis] ? i + stride : i];
  return T((after - before) * 0.5f);
}

Vectors gradients(const Lattice& box, const Values& values) {
  Vectors result(values.size());
  forNodes(box, [&](size_t i, int x, int y, int z) {
    result[i] = Vec(difference(box, values, i, x, 0), difference(box, values, i, y, 1),
                    difference(box, values, i, z, 2));
  });
  return result;
}

/// An image to be matched, with its gradient.
struct Channel {
  Values value;
  Vectors gradient;
};

/// Both channels of a level's image: the image itself, and how it differs from what is around it.
std::array<Channel, 2> channelsOf(const Lattice& box, Values image) {
  Values squares = image;
  for (float& v : squares) v *= v;
  const Values mean = blurred(box, image, kWindow), meanSquare = blurred(box, std::move(squares), kWindow);
  Values local(image.size());
  forNodes(box, [&](size_t i, int, int, int) {
    const float variance = std::max(meanSquare[i] - mean[i] * mean[i], 0.f);
    local[i] = kLocal * (image[i] - mean[i]) / std::sqrt(variance + kDeviation * kDeviation);
  });
  std::array<Channel, 2> channels;
  channels[0].value = std::move(image), channels[1].value = std::move(local);
  for (Channel& channel : channels) channel.gradient = gradients(box, channel.value);
  return channels;
}

/// A symmetric matrix and a right side, per node.
using Equation = Eigen::Array<float, 9, 1>;  // 00 11 22 01 02 12, then the vector

Eigen::Matrix3f matrixOf(const Equation& e) {
  Eigen::Matrix3f m;
  m << e[0], e[3], e[4], e[3], e[1], e[5], e[4], e[5], e[2];
  return m;
}

/// The map between two levels' images: a point of the middle that is x lies on the first object at x - way + bend, on the
/// second at x + way + bend.
struct Paths {
  int step;  ///< points of the finest images from node to node
  Lattice box;
  Vectors way, bend;
  Vectors
      more;  ///< of the bend, than bendOf() tells, where ways are so far that it says too little; empty: nothing
};

/// price of differences and divergence, applied to a field.
Vectors stiffness(const Lattice& box, const Vectors& field) {
  Values divergence(field.size());
  forNodes(box, [&](size_t i, int x, int y, int z) {
    divergence[i] = kDivergence * (difference(box, field, i, x, 0)[0] + difference(box, field, i, y, 1)[1] +
                                   difference(box, field, i, z, 2)[2]);
  });
  Vectors result(field.size());
  forNodes(box, [&](size_t i, int x, int y, int z) {
    const int at[3] = {x, y, z};
    Vec sum = Vec::Zero(), transposed;
    for (int axis = 0; axis < 3; ++axis) {
      const size_t stride = strideOf(box, axis);
      const bool first = at[axis] == 0, last = at[axis] + 1 == box.size[axis];
      if (!first) sum += field[i] - field[i - stride];
      if (!last) sum += field[i] - field[i + stride];
      // Of the transposed difference; the rim's own value stands for the one beyond it.
      const float before = first ? -divergence[i] : divergence[i - stride],
                  after = last ? -divergence[i] : divergence[i + stride];
      transposed[axis] = 0.5f * (before - after);
    }
    result[i] = kRoughness * sum + transposed;
  });
  return result;
}

double dot(const Lattice& box, const Vectors& a, const Vectors& b) {
  std::vector<double> slabs(size_t(box.size[2]), 0.0);
  forNodes(box, [&](size_t i, int, int, int z) { slabs[size_t(z)] += double(a[i].dot(b[i])); });
  double sum = 0;
  for (double slab : slabs) sum += slab;
  return sum;
}

/// The equations of one step, summed over the channels and averaged around each node.
std::vector<Equation> equationsOf(const Paths& paths, const std::array<Channel, 2>& a,
                                  const std::array<Channel, 2>& b) {
  const Lattice& box = paths.box;
  std::vector<Equation> equations(box.count());
  forNodes(box, [&](size_t i, int x, int y, int z) {
    const Vec at = nodeAt(x, y, z), p = at - paths.way[i] + paths.bend[i],
              q = at + paths.way[i] + paths.bend[i];
    Equation e = Equation::Zero();
    for (size_t c = 0; c < 2; ++c) {
      const float r = 0.5f * (sample(box, b[c].value, q) - sample(box, a[c].value, p));
      const Vec g = 0.5f * (sample(box, a[c].gradient, p) + sample(box, b[c].gradient, q));
      const float w = kSteep / (g.squaredNorm() + kSteep * kSteep);
      const float terms[9] = {g[0] * g[0], g[1] * g[1], g[2] * g[2], g[0] * g[1], g[0] * g[2],
                              g[1] * g[2], -r * g[0],   -r * g[1],   -r * g[2]};
      for (int k = 0; k < 9; ++k) e[k] += w * terms[k];
    }
    equations[i] = e;
  });
  return blurred(box, std::move(equations), kSpread);
}

/// One step of Gauss and Newton.
void improve(Paths& paths, const std::array<Channel, 2>& a, const std::array<Channel, 2>& b) {
  const Lattice& box = paths.box;
  const std::vector<Equation> equations = equationsOf(paths, a, b);
  const float diagonal = 6 * kRoughness + 0.5f * kDivergence;
  std::vector<Eigen::Matrix3f> inverse(box.count());
  Vectors residual = stiffness(box, paths.way), change(box.count(), Vec::Zero()), direction(box.count());
  forNodes(box, [&](size_t i, int, int, int) {
    inverse[i] = (matrixOf(equations[i]) + diagonal * Eigen::Matrix3f::Identity()).inverse();
    residual[i] = equations[i].tail<3>().matrix() - kMemory * residual[i];
    direction[i] = inverse[i] * residual[i];
  });
  Vectors preconditioned = direction;
  double before = dot(box, residual, preconditioned);
  const double first = before;
  for (int step = 0; step < kLinearSteps && before > 1e-4 * first; ++step) {
    Vectors product = stiffness(box, direction);
    forNodes(box, [&](size_t i, int, int, int) { product[i] += matrixOf(equations[i]) * direction[i]; });
    const float length = float(before / dot(box, direction, product));
    forNodes(box, [&](size_t i, int, int, int) {
      change[i] += length * direction[i], residual[i] -= length * product[i];
      preconditioned[i] = inverse[i] * residual[i];
    });
    const double now = dot(box, residual, preconditioned);
    forNodes(box, [&](size_t i, int, int, int) {
      direction[i] = preconditioned[i] + float(now / before) * direction[i];
    });
    before = now;
  }
  forNodes(box, [&](size_t i, int, int, int) {
    const float length = change[i].norm();
    paths.way[i] += change[i] * std::min(1.f, kLongestStep / (length + 1e-9f));
  });
}

/// Poisson's equation with walls around, for conjugateGradients.
struct WalledPoisson {
  const Lattice& box;
  size_t size() const { return box.count(); }
  size_t node(size_t i) const { return i; }
  float diagonal(size_t) const { return 1; }
  Grain grain() const { return {size_t(1) << 14}; }
  void apply(const Values& x, Values& y) const {
    forNodes(box, [&](size_t i, int cx, int cy, int cz) {
      const int at[3] = {cx, cy, cz};
      float sum = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const size_t stride = strideOf(box, axis);
        if (at[axis] > 0) sum += x[i] - x[i - stride];
        if (at[axis] + 1 < box.size[axis]) sum += x[i] - x[i + stride];
      }
      y[i] = sum;
    });
  }
};

/// How the paths of a fluid bend that flows so and is not compressed: a quarter of its acceleration, the gradient of a
/// pressure q with -laplace(q) = (div u)^2 - tr((grad u)^2).
Vectors bendOf(const Lattice& box, const Vectors& way) {
  Values residual(box.count());
  forNodes(box, [&](size_t i, int x, int y, int z) {
    Eigen::Matrix3f gradient;
    gradient.col(0) = difference(box, way, i, x, 0);
    gradient.col(1) = difference(box, way, i, y, 1);
    gradient.col(2) = difference(box, way, i, z, 2);
    residual[i] = gradient.trace() * gradient.trace() - (gradient * gradient).trace();
  });
  double mean = 0;
  for (float r : residual) mean += double(r) / double(residual.size());
  for (float& r : residual) r -= float(mean);
  Values pressure(box.count(), 0.f);
  WalledPoisson system{box};
  conjugateGradients<float>(system, GradientSettings{200, 1e-6}, std::move(residual), pressure);
  Vectors bend = gradients(box, pressure);
  for (Vec& b : bend) b *= 0.25f;
  return bend;
}

/// Values on a level whose nodes are `ratio` of the first one's spacings apart; both begin half a spacing inside the box.
template <typename T>
std::vector<T> resized(const Lattice& from, const std::vector<T>& values, const Lattice& to, float ratio) {
  std::vector<T> result(to.count());
  forNodes(to, [&](size_t i, int x, int y, int z) {
    const Vec p(ratio * (float(x) + 0.5f) - 0.5f, ratio * (float(y) + 0.5f) - 0.5f,
                ratio * (float(z) + 0.5f) - 0.5f);
    result[i] = sample(from, values, p);
  });
  return result;
}

/// The bend that goes with the paths' way.
Vectors wholeBend(const Paths& paths) {
  Vectors bend = bendOf(paths.box, paths.way);
  for (size_t i = 0; i < paths.more.size(); ++i) bend[i] += paths.more[i];
  return bend;
}

/// The densities as images on one lattice of chart space.
class Images {
 public:
  Images(const std::array<FloatGrid::ConstPtr, 2>& densities, const Chart& chart) : chart_(chart) {
    openvdb::BBoxd inside;
    double finest = 0;
    for (const auto& grid : densities) {
      const openvdb::CoordBBox voxels = grid->evalActiveVoxelBoundingBox();
      for (int c = 0; c < 8; ++c) {
        const openvdb::Coord corner((c & 1 ? voxels.max() : voxels.min())[0],
                                    (c & 2 ? voxels.max() : voxels.min())[1],
                                    (c & 4 ? voxels.max() : voxels.min())[2]);
        inside.expand(chart.toChart(grid->transform().indexToWorld(corner)));
      }
      const Vec3d voxel = grid->voxelSize();
      finest = std::max(finest, std::cbrt(voxel[0] * voxel[1] * voxel[2]) / chart.meanScale());
    }
    const Vec3d extents = inside.extents();
    const double longest = std::max({extents[0], extents[1], extents[2]});
    spacing_ = std::max(finest, longest / (kMostPoints - 2 * kPad));
    finer_ = std::max(1, int(std::lround(spacing_ / finest)));
    origin_ = inside.min() - Vec3d(kPad * spacing_);
    for (int a = 0; a < 3; ++a) box_.size[a] = int(std::ceil(extents[a] / spacing_)) + 1 + 2 * kPad;
    for (size_t k = 0; k < 2; ++k) {
      density_[k] = sampled(*densities[k]), image_[k] = compressed(density_[k]);
      for (float d : density_[k]) total_ += double(d);
    }
  }

  const Chart& chart() const { return chart_; }
  int longest() const { return std::max({box_.size[0], box_.size[1], box_.size[2]}); }
  const Values& density(size_t object) const { return density_[object]; }
  const Lattice& box() const { return box_; }
  /// Of both densities.
  double total() const { return total_; }
  Lattice boxOf(int step) const {
    Lattice box;
    for (int a = 0; a < 3; ++a) box.size[a] = std::max((box_.size[a] + step - 1) / step, 2);
    return box;
  }
  /// The image of a level whose nodes are `step` points apart.
  Values level(size_t object, int step) const {
    const float sigma = kPresmooth * std::sqrt(float(step * step - 1));
    return resized(box_, blurred(box_, image_[object], sigma), boxOf(step), float(step));
  }
  double spacingOf(int step) const { return step * spacing_; }
  /// Chart position of a level's first node.
  Vec3d originOf(int step) const { return origin_ + Vec3d(0.5 * (step - 1) * spacing_); }

 private:
  /// Means over the points' cells.
  Values sampled(const FloatGrid& grid) const {
    Values values(box_.count());
    tbb::parallel_for(0, box_.size[2], [&](int z) {
      const FloatGrid::ConstAccessor accessor = grid.getConstAccessor();
      for (int y = 0; y < box_.size[1]; ++y)
        for (int x = 0; x < box_.size[0]; ++x) {
          double sum = 0;
          for (int s = 0; s < finer_ * finer_ * finer_; ++s) {
            const Vec3d part(s % finer_, s / finer_ % finer_, s / finer_ / finer_);
            const Vec3d offset = (part + Vec3d(0.5)) / double(finer_) - Vec3d(0.5);
            const Vec3d world = chart_.toWorld(origin_ + spacing_ * (Vec3d(x, y, z) + offset));
            sum += double(openvdb::tools::BoxSampler::sample(accessor, grid.worldToIndex(world)));
          }
          values[box_.index(x, y, z)] = std::max(float(sum / (finer_ * finer_ * finer_)), 0.f);
        }
    });
    return values;
  }

  static Values compressed(const Values& density) {
    const float most = *std::max_element(density.begin(), density.end());
    Values there;
    for (float d : density)
      if (double(d) > kFaint * double(most)) there.push_back(d);
    if (there.empty()) return density;
    const auto high = there.begin() + std::ptrdiff_t(kHigh * double(there.size() - 1));
    std::nth_element(there.begin(), high, there.end());
    Values image(density.size());
    for (size_t i = 0; i < image.size(); ++i)
      image[i] = std::pow(density[i] / *high + kTiny, kCompression) - std::pow(kTiny, kCompression);
    return image;
  }

  const Chart& chart_;
  Lattice box_;
  Vec3d origin_{0, 0, 0};  ///< chart position of the first point
  double spacing_ = 1;     ///< chart units
  int finer_ = 1;          ///< samples per point and axis
  std::array<Values, 2> density_, image_;
  double total_ = 0;
};

/// sum |a - b| / sum |a + b| half way; 1 where paths lead most of the smoke out of sight.
double misfitOf(const Images& images, const Paths& paths) {
  const Lattice& box = images.box();
  std::vector<std::array<double, 2>> slabs(size_t(box.size[2]), {0, 0});
  const float ratio = 1 / float(paths.step);
  forNodes(box, [&](size_t, int x, int y, int z) {
    const Vec at = nodeAt(x, y, z);
    const Vec coarse = ((at.array() + 0.5f) * ratio - 0.5f).matrix();
    const Vec way = sample(paths.box, paths.way, coarse) / ratio,
              bend = sample(paths.box, paths.bend, coarse) / ratio;
    const float a = sample(box, images.density(0), at - way + bend),
                b = sample(box, images.density(1), at + way + bend);
    slabs[size_t(z)][0] += double(std::abs(a - b)), slabs[size_t(z)][1] += double(a + b);
  });
  double off = 0, all = 0;
  for (const auto& slab : slabs) off += slab[0], all += slab[1];
  return all > kLeastSeen * images.total() ? off / all : 1;
}

/// A map as paths of a level.
Paths pathsOf(const Displacements& map, const Images& images, int step) {
  Paths paths{step, images.boxOf(step), {}, {}, {}};
  paths.way.resize(paths.box.count()), paths.bend.resize(paths.box.count());
  const Vec3d origin = images.originOf(step);
  const double spacing = images.spacingOf(step);
  forNodes(paths.box, [&](size_t i, int x, int y, int z) {
    const Vec3d s = origin + spacing * Vec3d(x, y, z);
    const Vec3d a = map.at(0, s) / spacing, b = map.at(1, s) / spacing, way = 0.5 * (b - a),
                bend = 0.5 * (a + b);
    paths.way[i] = Vec(float(way[0]), float(way[1]), float(way[2]));
    paths.bend[i] = Vec(float(bend[0]), float(bend[1]), float(bend[2]));
  });
  return paths;
}

Paths nothingMoves(const Images& images, int step) {
  Paths paths{step, images.boxOf(step), {}, {}, {}};
  paths.way.assign(paths.box.count(), Vec::Zero()), paths.bend = paths.way;
  return paths;
}

/// Velocities on a level's nodes, in nodes per unit of time.
Vectors velocitiesOn(const openvdb::Vec3SGrid& grid, const Images& images, int step) {
  const Lattice box = images.boxOf(step);
  const Chart& chart = images.chart();
  const Vec3d origin = images.originOf(step);
  const double spacing = images.spacingOf(step);
  const bool staggered = grid.getGridClass() == openvdb::GRID_STAGGERED;
  Vectors result(box.count());
  tbb::parallel_for(0, box.size[2], [&](int z) {
    const openvdb::Vec3SGrid::ConstAccessor accessor = grid.getConstAccessor();
    for (int y = 0; y < box.size[1]; ++y)
      for (int x = 0; x < box.size[0]; ++x) {
        const Vec3d world = chart.toWorld(origin + spacing * Vec3d(x, y, z)), at = grid.worldToIndex(world);
        const openvdb::Vec3s v = staggered ? openvdb::tools::StaggeredBoxSampler::sample(accessor, at)
                                           : openvdb::tools::BoxSampler::sample(accessor, at);
        const Vec3d way = (chart.toChart(world + Vec3d(v)) - chart.toChart(world)) / spacing;
        result[box.index(x, y, z)] = Vec(float(way[0]), float(way[1]), float(way[2]));
      }
  });
  return result;
}

/// Where the middle's points come from and go to that swim with the velocities, half of the time either way; these change
/// evenly from those of the first object to those of the second.
Paths swimming(const Images& images, const std::array<Vectors, 2>& velocity, float time) {
  Paths paths{kVelocityStep, images.boxOf(kVelocityStep), {}, {}, {}};
  const Lattice& box = paths.box;
  paths.way.resize(box.count()), paths.bend.resize(box.count());
  forNodes(box, [&](size_t i, int x, int y, int z) {
    Vec end[2];
    for (int side = 0; side < 2; ++side) {
      const float sign = side == 0 ? -1.f : 1.f, step = sign * 0.5f * time / kSwimmingSteps;
      Vec p = nodeAt(x, y, z);
      for (int k = 0; k < kSwimmingSteps; ++k) {
        const float t = 0.5f + sign * 0.5f * (float(k) + 0.5f) / kSwimmingSteps;
        const auto at = [&](const Vec& q) {
          return Vec((1 - t) * sample(box, velocity[0], q) + t * sample(box, velocity[1], q));
        };
        p += step * at(p + 0.5f * step * at(p));
      }
      end[side] = p;
    }
    paths.way[i] = 0.5f * (end[1] - end[0]);
    paths.bend[i] = 0.5f * (end[0] + end[1]) - nodeAt(x, y, z);
  });
  return paths;
}

/// The paths by the objects' own velocities, whatever their unit, for the time that fits the densities best; none where
/// these fit hardly better than where nothing moves.
std::optional<Paths> pathsOfVelocities(const Images& images, const DensityVelocities& grids) {
  if (!grids[0] || !grids[1]) return std::nullopt;
  const std::array<Vectors, 2> velocity{velocitiesOn(*grids[0], images, kVelocityStep),
                                        velocitiesOn(*grids[1], images, kVelocityStep)};
  float fastest = 0;
  for (const Vectors& field : velocity)
    for (const Vec& v : field) fastest = std::max(fastest, v.norm());
  if (!(fastest > 0) || !std::isfinite(fastest)) return std::nullopt;
  double least = kWorthStarting * misfitOf(images, nothingMoves(images, kVelocityStep));
  std::optional<Paths> best;
  for (float way = kLeastWay; way < kMostWay; way *= kTimeFactor) {
    Paths paths = swimming(images, velocity, way / fastest);
    if (const double misfit = misfitOf(images, paths); misfit < least)
      least = misfit, best = std::move(paths);
  }
  if (!best) return best;
  best->more = best->bend;
  const Vectors told = bendOf(best->box, best->way);
  for (size_t i = 0; i < told.size(); ++i) best->more[i] -= told[i];
  return best;
}

/// What the two objects' velocities say of the paths between them.
struct ToldWays {
  float time = 0;  ///< that passes between the objects
  /// Of the ways and the mean velocity at their two ends, where there is smoke.
  double correlation = 0;
};

ToldWays toldWays(const Images& images, const std::array<Vectors, 2>& velocity, const Paths& paths) {
  const Lattice& box = paths.box;
  const Values smoke[2] = {images.level(0, paths.step), images.level(1, paths.step)};
  std::vector<std::array<double, 3>> slabs(size_t(box.size[2]), {0, 0, 0});
  forNodes(box, [&](size_t i, int x, int y, int z) {
    const Vec middle = nodeAt(x, y, z) + paths.bend[i], a = middle - paths.way[i], b = middle + paths.way[i];
    const double weight = double(std::min(sample(box, smoke[0], a), sample(box, smoke[1], b)));
    if (!(weight > 0)) return;
    const Vec mean = 0.5f * (sample(box, velocity[0], a) + sample(box, velocity[1], b));
    const Vec way = 2 * paths.way[i];
    std::array<double, 3>& sum = slabs[size_t(z)];
    sum[0] += weight * double(mean.dot(way));
    sum[1] += weight * double(mean.squaredNorm()), sum[2] += weight * double(way.squaredNorm());
  });
  std::array<double, 3> all{0, 0, 0};
  for (const auto& slab : slabs)
    for (size_t n = 0; n < 3; ++n) all[n] += slab[n];
  if (!(all[1] > 0 && all[2] > 0)) return {};
  // Ways are smooth, velocities hold the eddies of a moment as well: these are told from the ways, not the ways from them.
  return {float(all[2] / std::max(all[0], 1e-30)), std::min(all[0] / std::sqrt(all[1] * all[2]), 1.0)};
}

/// How paths bend that leave the first object and reach the second one with their velocities, as cubics do: by Hermite's,
/// half way is off the middle of both ends by an eighth of the time times the difference of these. None where velocities
/// are not known, or tell other ways.
std::optional<Vectors> bendByVelocities(const Images& images, const DensityVelocities& grids,
                                        const Paths& paths) {
  if (!grids[0] || !grids[1]) return std::nullopt;
  const Lattice& box = paths.box;
  const std::array<Vectors, 2> velocity{velocitiesOn(*grids[0], images, paths.step),
                                        velocitiesOn(*grids[1], images, paths.step)};
  const ToldWays told = toldWays(images, velocity, paths);
  if (!(told.correlation >= kToldWays)) return std::nullopt;
  const float spread = float(kBendSpread * std::sqrt(1 - told.correlation * told.correlation));
  const Values smoke[2] = {images.level(0, paths.step), images.level(1, paths.step)};
  Vectors bend = paths.bend;
  for (int round = 0; round < kBendRounds; ++round) {
    Values weight(box.count());
    forNodes(box, [&](size_t i, int x, int y, int z) {
      const Vec middle = nodeAt(x, y, z) + bend[i], a = middle - paths.way[i], b = middle + paths.way[i];
      weight[i] = std::min(sample(box, smoke[0], a), sample(box, smoke[1], b)) + kNoSmoke;
      bend[i] = weight[i] * 0.125f * told.time * (sample(box, velocity[1], b) - sample(box, velocity[0], a));
    });
    bend = blurred(box, std::move(bend), spread), weight = blurred(box, std::move(weight), spread);
    for (size_t i = 0; i < bend.size(); ++i) bend[i] /= weight[i];
  }
  return bend;
}

/// Both densities' images of a level, with their channels.
struct Level {
  std::array<Channel, 2> a, b;
  Level(const Images& images, int step)
      : a(channelsOf(images.boxOf(step), images.level(0, step))),
        b(channelsOf(images.boxOf(step), images.level(1, step))) {}
};

/// The steps of the paths' own level.
Paths improved(const Level& level, Paths paths) {
  for (int i = 0; i < kNewtonSteps; ++i) improve(paths, level.a, level.b);
  return paths;
}

/// The bend that goes with the paths' way: velocities tell it, or a fluid's pressure.
Vectors bendWith(const Images& images, const DensityVelocities& velocities, const Paths& paths) {
  if (paths.more.empty())
    if (std::optional<Vectors> told = bendByVelocities(images, velocities, paths)) return *std::move(told);
  return wholeBend(paths);
}

/// The same on the next finer level, as its start.
Paths finer(const Images& images, const DensityVelocities& velocities, const Paths& paths) {
  Paths next{paths.step / 2, images.boxOf(paths.step / 2), {}, {}, {}};
  const auto onNext = [&](const Vectors& field) {
    Vectors result = resized(paths.box, field, next.box, 0.5f);
    for (Vec& v : result) v *= 2;
    return result;
  };
  next.way = onNext(paths.way);
  if (!paths.more.empty()) next.more = onNext(paths.more);
  const std::optional<Vectors> told =
      paths.more.empty() ? bendByVelocities(images, velocities, paths) : std::nullopt;
  next.bend = told ? onNext(*told) : wholeBend(next);
  return next;
}

/// The paths of a level after its steps and those of all finer ones.
Paths refined(const Images& images, const DensityVelocities& velocities, Paths paths) {
  while (paths.step > kFinest)
    paths = improved(Level(images, paths.step / 2), finer(images, velocities, paths));
  paths.bend = bendWith(images, velocities, paths);
  return paths;
}

/// From coarse to fine, begun from whichever of the starts is better on the coarsest level.
Paths found(const Images& images, const DensityVelocities& velocities, const std::array<Paths, 2>& starts) {
  const Level coarsest(images, starts[0].step);
  Paths paths = improved(coarsest, starts[0]);
  if (Paths other = improved(coarsest, starts[1]); misfitOf(images, other) < misfitOf(images, paths))
    paths = std::move(other);
  return refined(images, velocities, std::move(paths));
}

/// The map of the finest paths, on a lattice around which it fades to nothing.
Displacements mapOf(const Images& images, const Paths& paths) {
  float farthest = 0;
  for (const Vec& w : paths.way) farthest = std::max(farthest, w.norm());
  const int margin = int(std::ceil(kFade * double(farthest))) + 2;
  const double spacing = images.spacingOf(kFinest);
  Lattice lattice{
      images.originOf(kFinest) - Vec3d(margin * spacing), spacing,
      openvdb::Coord(paths.box.size[0], paths.box.size[1], paths.box.size[2]).offsetBy(2 * margin)};
  Displacements map{lattice, {VectorField(lattice.count()), VectorField(lattice.count())}};
  tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const int at[3] = {x - margin, y - margin, z - margin};
        int outside = 0;
        Vec p;
        for (int a = 0; a < 3; ++a) {
          outside = std::max({outside, -at[a], at[a] - paths.box.size[a] + 1});
          p[a] = float(at[a]);
        }
        const float share = float(spacing) * std::max(1 - float(outside) / float(margin), 0.f);
        const Vec way = share * sample(paths.box, paths.way, p),
                  bend = share * sample(paths.box, paths.bend, p);
        for (size_t k = 0; k < 2; ++k) {
          const Vec d = k == 0 ? Vec(bend - way) : Vec(bend + way);
          map.of[k][lattice.index(x, y, z)] = openvdb::Vec3s(d[0], d[1], d[2]);
        }
      }
  });
  removeFolds(map);
  return map;
}

}  // namespace

DensityMatch matchDensities(const std::array<FloatGrid::ConstPtr, 2>& densities,
                            const DensityVelocities& velocities, const Chart& chart,
                            const Displacements& map) {
  const Images images(densities, chart);
  int coarsest = kFinest;
  while (images.longest() / (2 * coarsest) >= kCoarsestNodes) coarsest *= 2;
  DensityMatch match;
  match.before = match.after = misfitOf(images, pathsOf(map, images, kFinest));
  match.map = map;
  std::optional<Paths> best;
  const auto take = [&](Paths paths) {
    if (const double misfit = misfitOf(images, paths); misfit < match.after)
      match.after = misfit, best = std::move(paths);
  };
  take(found(images, velocities, {nothingMoves(images, coarsest), pathsOf(map, images, coarsest)}));
  if (const std::optional<Paths> swum = pathsOfVelocities(images, velocities))
    take(refined(images, velocities, improved(Level(images, kVelocityStep), *swum)));
  if (best) match.map = mapOf(images, *best);
  return match;
}

}  // namespace slicemorph
