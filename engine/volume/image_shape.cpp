#include "engine/volume/image_shape.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/leaf.h"
#include "slicemorph/errors.h"
#include "slicemorph/level_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <sstream>

namespace slicemorph {
namespace {

using FloatLeaf = openvdb::FloatTree::LeafNodeType;

/// What a block of 8 x 8 x 8 voxels becomes: a leaf, or a tile inside or outside.
struct Block {
  std::unique_ptr<FloatLeaf> leaf;
  bool inside = false;
};

/// `value(index)` is a voxel's finite value; above `iso` is inside.
template <typename Value>
FloatGrid::Ptr shapeOf(const ImageLattice& lattice, float iso, float outside, float inside,
                       const Value& value) {
  auto grid = FloatGrid::create(outside);
  grid->setTransform(transformOf(lattice));
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  const openvdb::Coord n = lattice.size, blocks = (n + openvdb::Coord(kLeaf - 1)) >> FloatLeaf::LOG2DIM;
  std::vector<Block> layer(size_t(blocks[0]) * blocks[1]);
  for (int bk = 0; bk < blocks[2]; ++bk) {
    tbb::parallel_for(size_t(0), layer.size(), [&](size_t b) {
      const openvdb::Coord origin(int(b % size_t(blocks[0])) * kLeaf, int(b / size_t(blocks[0])) * kLeaf,
                                  bk * kLeaf);
      // Includes the voxels around the block, so that a surface between blocks gets leaves on both sides.
      const openvdb::Coord low = origin - openvdb::Coord(1), high = origin + openvdb::Coord(kLeaf);
      bool above = false, below = low[0] < 0 || low[1] < 0 || low[2] < 0 || high[0] >= n[0] ||
                                  high[1] >= n[1] || high[2] >= n[2];
      for (int k = std::max(low[2], 0); k <= std::min(high[2], n[2] - 1); ++k)
        for (int j = std::max(low[1], 0); j <= std::min(high[1], n[1] - 1); ++j)
          for (int i = std::max(low[0], 0); i <= std::min(high[0], n[0] - 1); ++i)
            (value(lattice.index(i, j, k)) > iso ? above : below) = true;
      layer[b] = {nullptr, above && !below};
      if (!above || !below) return;
      layer[b].leaf = std::make_unique<FloatLeaf>(origin, outside);
      for (int k = origin[2]; k < std::min(high[2], n[2]); ++k)
        for (int j = origin[1]; j < std::min(high[1], n[1]); ++j)
          for (int i = origin[0]; i < std::min(high[0], n[0]); ++i)
            layer[b].leaf->setValueOn(FloatLeaf::coordToOffset({i, j, k}), value(lattice.index(i, j, k)));
    });
    for (size_t b = 0; b < layer.size(); ++b) {
      const openvdb::Coord origin(int(b % size_t(blocks[0])) * kLeaf, int(b / size_t(blocks[0])) * kLeaf,
                                  bk * kLeaf);
      if (layer[b].leaf)
        grid->tree().addLeaf(layer[b].leaf.release());
      else if (layer[b].inside)
        grid->tree().addTile(1, origin, inside, true);
    }
  }
  if (grid->empty()) throw GeometryError("nothing lies inside");
  return grid;
}

/// Of the finite values.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};

template <typename T>
Range rangeOf(const std::vector<T>& values) {
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, values.size(), 1 << 16), Range(),
      [&](const auto& part, Range r) {
        for (size_t i = part.begin(); i < part.end(); ++i) {
          const double v = double(values[i]);
          if (!std::isfinite(v)) continue;
          if (v < r.low) r.low = v;
          if (v > r.high) r.high = v;
        }
        return r;
      },
      [](const Range& a, const Range& b) {
        return Range{std::min(a.low, b.low), std::max(a.high, b.high)};
      });
}

}  // namespace

FloatGrid::Ptr shapeAbove(const Image& image, double iso) {
  return std::visit(
      [&](const auto& values) {
        const Range range = rangeOf(values);
        if (!(range.low < iso && iso < range.high)) {
          std::ostringstream why;
          why << "the image has no surface at " << iso << ": its values run from " << range.low << " to "
              << range.high;
          throw GeometryError(why.str());
        }
        const auto low = float(range.low), high = float(range.high);
        return shapeOf(image.lattice, float(iso), low, high, [&](size_t i) {
          const auto v = float(values[i]);
          return std::isnan(v) ? low : std::clamp(v, low, high);
        });
      },
      image.values);
}

FloatGrid::Ptr shapeOfLabels(const Image& labels) {
  return std::visit(
      [&](const auto& values) {
        return shapeOf(labels.lattice, 0.5f, 0, 1, [&](size_t i) { return values[i] != 0 ? 1.f : 0.f; });
      },
      labels.values);
}

FloatGrid::Ptr shapeOfLabel(const Image& labels, std::int64_t label) {
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        return shapeOf(labels.lattice, 0.5f, 0, 1,
                       [&](size_t i) { return values[i] == T(label) ? 1.f : 0.f; });
      },
      labels.values);
}

FloatGrid::Ptr levelSetOf(const FloatGrid::ConstPtr& shape, double iso, double voxelSize) {
  const double surface = iso == 0 ? double(std::numeric_limits<float>::min()) : iso;
  return toLevelSet(shape, voxelSize, surface).grid;
}

double otsuValue(const Image& image) {
  constexpr size_t kBins = 1024;  // the threshold is exact to a thousandth of the range of values
  return std::visit(
      [&](const auto& values) {
        const Range range = rangeOf(values);
        if (!(range.high > range.low)) return range.low;
        std::vector<double> count(kBins, 0);
        const double scale = kBins / (range.high - range.low);
        for (const auto v : values)
          if (std::isfinite(double(v))) ++count[std::min(size_t((double(v) - range.low) * scale), kBins - 1)];
        double total = 0, sum = 0;
        for (size_t b = 0; b < kBins; ++b) total += count[b], sum += count[b] * (double(b) + 0.5);
        double below = 0, sumBelow = 0, most = -1;
        // If the two classes are far apart, many bins separate them equally well; the middle one is taken.
        size_t first = 0, last = 0;
        for (size_t b = 0; b + 1 < kBins; ++b) {
          below += count[b], sumBelow += count[b] * (double(b) + 0.5);
          if (below == 0 || below == total) continue;
          const double apart = sumBelow / below - (sum - sumBelow) / (total - below);
          const double between = below * (total - below) * apart * apart;
          if (between > most * (1 + 1e-12))
            most = between, first = last = b;
          else if (between >= most * (1 - 1e-12))
            last = b;
        }
        return range.low + (0.5 * double(first + last) + 1) / scale;
      },
      image.values);
}

bool looksLikeLabels(const Image& image) {
  // Share of equal neighbours, leaving out pairs of zeros: measured on 25 images of both kinds, 0.55 to 0.97
  // in label maps and 0 to 0.25 in grey images.
  constexpr double kSame = 0.4;
  return std::visit(
      [&](const auto& values) {
        size_t pairs = 0, same = 0;
        std::set<double> distinct;
        const size_t row = size_t(image.lattice.size[0]);
        for (size_t i = 0; i < values.size(); ++i) {
          const double v = double(values[i]);
          if (!(v >= 0) || v != std::rint(v) || v > 1e6) return false;
          if (i % row == 0) continue;
          const double before = double(values[i - 1]);
          if (v == 0 && before == 0) continue;
          ++pairs, same += v == before;
          if (v != before && distinct.size() <= 65535) distinct.insert(v);
        }
        const bool mask = distinct.size() - distinct.count(0) == 1;
        return mask || (pairs > 0 && distinct.size() <= 65535 && double(same) >= kSame * double(pairs));
      },
      image.values);
}

std::vector<std::int64_t> labelsOf(const Image& image) {
  return std::visit(
      [&](const auto& values) {
        std::set<std::int64_t> found;
        std::int64_t before = 0;
        for (const auto value : values) {
          const double v = double(value);
          if (!(v >= 0 && v <= 2147483647.0) || v != std::rint(v)) {
            std::ostringstream why;
            why << "the value " << v << " is no label: labels are whole numbers from 0 on";
            throw InputError(why.str());
          }
          const auto label = std::int64_t(v);
          if (label == before) continue;
          before = label;
          if (label != 0 && found.insert(label).second && found.size() > 65535)
            throw InputError("it has more than 65535 different values, which are no labels");
        }
        return std::vector<std::int64_t>(found.begin(), found.end());
      },
      image.values);
}

}  // namespace slicemorph
