#include "engine/match/fit_field.h"

#include "engine/numerics/conjugate_gradients.h"
#include "engine/numerics/lattice_cell.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <Eigen/Core>

#include <algorithm>
#include <cstdint>

namespace slicemorph {

template <>
struct Lanes<Eigen::Array4f> {
  using Wide = Eigen::Array4d;
  using Mask = Eigen::Array<bool, 4, 1>;
  static Wide zero() { return Wide::Zero(); }
  static Wide wide(const Eigen::Array4f& v) { return v.cast<double>(); }
  static Eigen::Array4f narrow(const Wide& v) { return v.cast<float>(); }
  static bool any(const Mask& mask) { return mask.any(); }
  static Mask both(const Mask& a, const Mask& b) { return a && b; }
  static Wide where(const Mask& mask, const Wide& v) { return mask.select(v, 0.0); }
};

namespace {

/// The values of four columns (right-hand sides), which are solved side by side.
using Four = Eigen::Array4f;
using FourDoubles = Eigen::Array4d;
using Column = std::vector<Four>;

/// What one task has, so that starting it takes no time against its work: of a lattice's layers, of all nodes, of sites.
constexpr int kLayersPerTask = 8;
constexpr size_t kNodesPerTask = 16384, kSitesPerTask = 4096;

/// The operator of the normal equations, W^T W + stiffness L^T L + 1e-5 I; the last term only makes it
/// definite. W: interpolation at the sites, times the roots of their weights; L: Laplacian. A column holds
/// the lattice's nodes with a border of zeros around them.
class NormalOperator {
 public:
  NormalOperator(const Lattice& lattice, const Sites& sites, double stiffness)
      : lattice_(lattice),
        weight_(sites.weight),
        stiffness_(float(stiffness)),
        layers_(size_t(lattice.size[2])) {
    dy_ = lattice.size[0] + 2, dz_ = dy_ * (lattice.size[1] + 2);
    for (int i = 0; i < 8; ++i) offset_[i] = (i & 1 ? 1 : 0) + (i & 2 ? dy_ : 0) + (i & 4 ? dz_ : 0);
    for (const Vec3d& p : sites.position) {
      const CellPoint point = cellPoint(lattice, p);
      const openvdb::Coord c = lattice.coordOf(point.cell);
      Stencil s{index(c[0], c[1], c[2]), {}};
      for (int i = 0; i < 8; ++i) s.w[i] = point.weight(i);
      for (int above = 0; above < 2; ++above)
        layers_[size_t(c[2] + above)].push_back({std::uint32_t(stencils_.size()), above});
      stencils_.push_back(s);
    }
  }

  size_t index(int x, int y, int z) const { return size_t(x + 1) + (y + 1) * dy_ + (z + 1) * dz_; }
  Column zero() const { return Column(dz_ * (lattice_.size[2] + 2), Four::Zero()); }

  /// `values(i)`: the four columns' values at site i.
  template <typename Values>
  Column rightHandSide(const Values& values) const {
    Column b = zero(), value(stencils_.size());
    forEachSite([&](size_t i) { value[i] = values(i); });
    forEachCorner([&](size_t node, size_t i, float weight) { b[node] += (weight_[i] * weight) * value[i]; });
    return b;
  }

  size_t sites() const { return stencils_.size(); }

  /// y = this times x; `scratch` and `y` are of the same size and zero in the border. `value`: room for one value a site.
  void operator()(const Column& x, Column& scratch, Column& value, Column& y) const {
    forEachRow([&](size_t n, size_t end) {
      for (; n < end; ++n) scratch[n] = laplacian(x, n);
    });
    forEachRow([&](size_t n, size_t end) {
      for (; n < end; ++n) y[n] = stiffness_ * laplacian(scratch, n) + 1e-5f * x[n];
    });
    forEachSite([&](size_t i) {
      const Stencil& s = stencils_[i];
      Four v = Four::Zero();
      for (int c = 0; c < 8; ++c) v += s.w[c] * x[s.base + offset_[c]];
      value[i] = v * weight_[i];
    });
    forEachCorner([&](size_t node, size_t i, float weight) { y[node] += weight * value[i]; });
  }

 private:
  /// A site's cell and the weights of its corners.
  struct Stencil {
    size_t base;
    float w[8];
  };

  /// A site that has corners in a layer of the lattice: those of its cell's lower side, or of the upper one.
  struct SiteInLayer {
    std::uint32_t site;
    int above;
  };

  /// Calls body(i) for every site.
  template <typename Body>
  void forEachSite(const Body& body) const {
    Grain{kSitesPerTask}.forEach(stencils_.size(), body);
  }

  /// Calls body(node, site, weight) for every corner of every site's cell: layer by layer of the lattice, so that none
  /// is written by two tasks, and for each node in the order of the sites.
  template <typename Body>
  void forEachCorner(const Body& body) const {
    tbb::parallel_for(tbb::blocked_range<int>(0, lattice_.size[2], kLayersPerTask),
                      [&](const tbb::blocked_range<int>& layers) {
                        for (int z = layers.begin(); z < layers.end(); ++z)
                          for (const SiteInLayer& in : layers_[size_t(z)]) {
                            const Stencil& s = stencils_[in.site];
                            for (int c = 4 * in.above; c < 4 * in.above + 4; ++c)
                              body(s.base + offset_[c], in.site, s.w[c]);
                          }
                      });
  }

  /// Calls body(n, end) for every row, with the index of its first node and the one past its last; a task has a few
  /// layers of rows.
  template <typename Body>
  void forEachRow(const Body& body) const {
    tbb::parallel_for(tbb::blocked_range<int>(0, lattice_.size[2], kLayersPerTask),
                      [&](const tbb::blocked_range<int>& layers) {
                        for (int z = layers.begin(); z < layers.end(); ++z)
                          for (int y = 0; y < lattice_.size[1]; ++y)
                            body(index(0, y, z), index(lattice_.size[0], y, z));
                      });
  }

  Four laplacian(const Column& x, size_t n) const {
    return x[n] - (x[n - 1] + x[n + 1] + x[n - dy_] + x[n + dy_] + x[n - dz_] + x[n + dz_]) * (1 / 6.f);
  }

  const Lattice& lattice_;
  const std::vector<float>& weight_;
  float stiffness_;
  size_t dy_, dz_;
  std::vector<Stencil> stencils_;
  std::vector<std::vector<SiteInLayer>> layers_;  ///< per layer, in the order of the sites
  size_t offset_[8];
};

/// The normal equations of all nodes in the form that conjugateGradients takes.
class ColumnSystem {
 public:
  explicit ColumnSystem(const NormalOperator& op) : op_(op), scratch_(op.zero()), value_(op.sites()) {}

  size_t size() const { return scratch_.size(); }
  size_t node(size_t i) const { return i; }
  float diagonal(size_t) const { return 1; }
  Grain grain() const { return {kNodesPerTask}; }
  void apply(const Column& x, Column& product) { op_(x, scratch_, value_, product); }

 private:
  const NormalOperator& op_;
  Column scratch_, value_;
};

/// Solves four columns from `x`, each to a residual of a thousandth of its right-hand side or `most` steps.
Column solve(const NormalOperator& op, const Column& b, Column x, int most) {
  ColumnSystem system(op);
  Column residual = op.zero();
  system.apply(x, residual);
  const FourDoubles sum = system.grain().sum(b.size(), FourDoubles(FourDoubles::Zero()), [&](size_t i) {
    residual[i] = b[i] - residual[i];
    return FourDoubles(b[i].cast<double>() * b[i].cast<double>());
  });
  const FourDoubles scale = sum.max(1e-30);
  conjugateGradients(system, {most, 1e-6}, std::move(residual), x, &scale);
  return x;
}

}  // namespace

Displacements fitFields(const Lattice& lattice, const Sites& sites, double stiffness,
                        const Displacements& start, int steps) {
  const size_t objects = sites.value.size();
  const NormalOperator op(lattice, sites, stiffness);
  Displacements result{lattice, start.of};
  // The fit is linear: the last object's field follows from the others' and from the fit of their sum, which
  // is zero unless points move on parabolas.
  std::vector<Vec3d> sums(sites.position.size(), Vec3d(0.0));
  VectorField sum(lattice.count(), openvdb::Vec3s(0.f));
  double largest = 0;
  for (size_t k = 0; k < objects; ++k)
    for (size_t i = 0; i < sums.size(); ++i) {
      sums[i] += sites.value[k][i];
      largest = std::max(largest, sites.value[k][i].lengthSqr());
    }
  double most = tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, sum.size()), 0.0,
      [&](const tbb::blocked_range<size_t>& nodes, double longest) {
        for (size_t i = nodes.begin(); i < nodes.end(); ++i) {
          for (size_t k = 0; k < objects; ++k) sum[i] += start.of[k][i];
          longest = std::max(longest, double(sum[i].lengthSqr()));
        }
        return longest;
      },
      [](double a, double b) { return std::max(a, b); });
  for (const Vec3d& s : sums) most = std::max(most, s.lengthSqr());
  const bool bowed = most > 1e-8 * largest;
  if (!bowed) std::fill(sum.begin(), sum.end(), openvdb::Vec3s(0.f));
  const size_t columns = 3 * (objects - 1 + bowed);
  tbb::parallel_for(size_t(0), (columns + 3) / 4, [&](size_t four) {
    const auto forEachColumn = [&](const auto& body) {
      for (int lane = 0; lane < 4; ++lane)
        if (const size_t column = 4 * four + lane; column < columns) body(lane, column / 3, int(column % 3));
    };
    const auto forEachNode = [&](const auto& body) {
      tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
        for (int y = 0; y < lattice.size[1]; ++y)
          for (int x = 0; x < lattice.size[0]; ++x) body(lattice.index(x, y, z), op.index(x, y, z));
      });
    };
    Column first = op.zero();
    forEachColumn([&](int lane, size_t object, int component) {
      const VectorField& from = object == objects - 1 ? sum : start.of[object];
      forEachNode([&](size_t node, size_t ringed) { first[ringed][lane] = from[node][component]; });
    });
    const Column wanted = op.rightHandSide([&](size_t site) {
      Four value = Four::Zero();
      forEachColumn([&](int lane, size_t object, int component) {
        value[lane] = float((object == objects - 1 ? sums : sites.value[object])[site][component]);
      });
      return value;
    });
    const Column x = solve(op, wanted, std::move(first), steps);
    forEachColumn([&](int lane, size_t object, int component) {
      VectorField& to = object == objects - 1 ? sum : result.of[object];
      forEachNode([&](size_t node, size_t ringed) { to[node][component] = x[ringed][lane]; });
    });
  });
  Grain{kNodesPerTask}.forEach(lattice.count(), [&](size_t i) {
    result.of.back()[i] = sum[i];
    for (size_t k = 0; k + 1 < objects; ++k) result.of.back()[i] -= result.of[k][i];
  });
  return result;
}

}  // namespace slicemorph
