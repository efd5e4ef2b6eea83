#include "engine/reconstruct/cross_slices.h"

#include "engine/contours/contours.h"
#include "engine/numerics/mask_distance.h"
#include "engine/reconstruct/label_slices.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <map>

namespace slicemorph {

namespace {

/// Voxels: slices next to each other that were all drawn make sheets as thick as this at most.
constexpr int kSheet = 3;
constexpr int kFar = 12;  ///< longer runs of voxels are not told apart
/// Share of a map's voxels that lies in thin sheets, and on slices that were found.
constexpr double kLeastThin = 0.6, kLeastFound = 0.9;
/// Share of a slice's voxels of a label that are its sheet; of others they are lines across it.
constexpr double kLeastSheet = 0.5;
constexpr size_t kLeastVoxels = 3;      ///< of a sheet
constexpr size_t kFirstLooks = 100000;  ///< voxels that are looked at first

/// Per axis and slice: voxels of a label, and those in a sheet along it.
struct Tally {
  std::array<std::vector<size_t>, 3> all, sheet;
};

/// A map's voxels, which must outlive this.
template <typename T>
class Voxels {
 public:
  Voxels(const ImageLattice& lattice, const std::vector<T>& labels) : lattice_(lattice), label_(labels) {}
  int label(size_t n) const { return int(label_[n]); }
  size_t count() const { return label_.size(); }
  openvdb::Coord coord(size_t n) const {
    const size_t x = size_t(lattice_.size[0]), y = size_t(lattice_.size[1]);
    return {int(n % x), int(n / x % y), int(n / x / y)};
  }
  /// Length of the run of equal labels through a voxel, at most kFar.
  int run(size_t n, const openvdb::Coord& at, int axis) const {
    const std::ptrdiff_t step = axis == 0   ? 1
                                : axis == 1 ? lattice_.size[0]
                                            : std::ptrdiff_t(lattice_.size[0]) * lattice_.size[1];
    int length = 1;
    for (int side : {-1, 1})
      for (int k = 1; length < kFar; ++k, ++length) {
        const int to = at[axis] + side * k;
        if (to < 0 || to >= lattice_.size[axis] ||
            label_[size_t(std::ptrdiff_t(n) + side * k * step)] != label_[n])
          break;
      }
    return length;
  }
  /// The axis across the thin sheet that a voxel is in; -1: none, or a line where sheets cross; -2: it is thick.
  int across(size_t n) const {
    const openvdb::Coord at = coord(n);
    const int runs[3] = {run(n, at, 0), run(n, at, 1), run(n, at, 2)};
    const int axis = int(std::min_element(runs, runs + 3) - runs);
    if (runs[axis] > kSheet) return -2;
    return std::count(runs, runs + 3, runs[axis]) > 1 ? -1 : axis;
  }

 private:
  const ImageLattice& lattice_;
  const std::vector<T>& label_;
};

/// Whether most of a map's voxels that have a label are in thin sheets, as far as some of them tell.
template <typename T>
bool isThin(const Voxels<T>& voxels) {
  size_t labelled = 0, number = 0, thin = 0, seen = 0;
  for (size_t n = 0; n < voxels.count(); ++n) labelled += voxels.label(n) != 0;
  const size_t stride = std::max<size_t>(1, labelled / kFirstLooks);
  for (size_t n = 0; n < voxels.count(); ++n)
    if (voxels.label(n) != 0 && number++ % stride == 0) ++seen, thin += voxels.across(n) != -2;
  return seen > 0 && double(thin) >= kLeastThin * double(seen);
}

template <typename T>
std::map<int, Tally> tallied(const Voxels<T>& voxels, const std::vector<size_t>& labelled,
                             const openvdb::Coord& size) {
  std::vector<signed char> across(labelled.size());
  tbb::parallel_for(size_t(0), labelled.size(),
                    [&](size_t i) { across[i] = static_cast<signed char>(voxels.across(labelled[i])); });
  std::map<int, Tally> tallies;
  for (size_t i = 0; i < labelled.size(); ++i) {
    Tally& tally = tallies[voxels.label(labelled[i])];
    const openvdb::Coord at = voxels.coord(labelled[i]);
    for (size_t axis = 0; axis < 3; ++axis) {
      tally.all[axis].resize(size_t(size[axis])), tally.sheet[axis].resize(size_t(size[axis]));
      ++tally.all[axis][size_t(at[axis])];
      tally.sheet[axis][size_t(at[axis])] += across[i] == int(axis);
    }
  }
  return tallies;
}

std::vector<CrossLabel> slicesOf(const std::map<int, Tally>& tallies) {
  std::vector<CrossLabel> labels;
  for (const auto& [value, tally] : tallies) {
    CrossLabel label{value, {}};
    for (size_t axis = 0; axis < 3; ++axis)
      for (size_t at = 0; at < tally.all[axis].size(); ++at)
        if (tally.sheet[axis][at] >= kLeastVoxels &&
            double(tally.sheet[axis][at]) >= kLeastSheet * double(tally.all[axis][at]))
          label.slices.push_back({int(axis), int(at)});
    labels.push_back(std::move(label));
  }
  return labels;
}

/// By axis and number: whether a label was drawn there.
std::array<std::vector<char>, 3> marked(const CrossLabel& label, const openvdb::Coord& size) {
  std::array<std::vector<char>, 3> on;
  for (size_t axis = 0; axis < 3; ++axis) on[axis].assign(size_t(size[axis]), 0);
  for (const CrossSlice& slice : label.slices) on[size_t(slice.axis)][size_t(slice.at)] = 1;
  return on;
}

template <typename T>
std::vector<CrossLabel> crossOf(const Voxels<T>& voxels, const openvdb::Coord& size) {
  if (!isThin(voxels)) return {};
  std::vector<size_t> labelled;
  for (size_t n = 0; n < voxels.count(); ++n)
    if (voxels.label(n) != 0) labelled.push_back(n);
  std::vector<CrossLabel> cross = slicesOf(tallied(voxels, labelled, size));
  std::map<int, std::array<std::vector<char>, 3>> on;
  bool across[3] = {false, false, false};
  for (const CrossLabel& label : cross) {
    on[label.label] = marked(label, size);
    for (const CrossSlice& slice : label.slices) across[slice.axis] = true;
  }
  size_t found = 0;
  for (const size_t n : labelled) {
    const openvdb::Coord at = voxels.coord(n);
    const auto& own = on[voxels.label(n)];
    found += own[0][size_t(at[0])] || own[1][size_t(at[1])] || own[2][size_t(at[2])];
  }
  if (across[0] + across[1] + across[2] < 2 || double(found) < kLeastFound * double(labelled.size()))
    return {};
  return cross;
}

/// A label's signed distance on a slice, positive inside, in a box of pixels around it.
LabelScore scoreOn(const Image& labels, const CrossLabel& label, const CrossSlice& slice) {
  const SliceLayout layout = layoutOf(labels.lattice, slice.axis);
  std::vector<std::uint8_t> mask(size_t(layout.width) * size_t(layout.height));
  std::visit(
      [&](const auto& values) {
        for (int y = 0; y < layout.height; ++y)
          for (int x = 0; x < layout.width; ++x)
            mask[size_t(y) * size_t(layout.width) + size_t(x)] =
                int(values[size_t(slice.at) * layout.slice + size_t(y) * layout.y + size_t(x) * layout.x]) ==
                label.label;
      },
      labels.values);
  const ImageValues flat = std::move(mask);
  const LabelSlice one{flat, {layout.width, layout.height, 1, size_t(layout.width), 0}, 0};
  const ScorePlane plane = scoredPlane(one, {1, 0}, emptyStack(labels.lattice, slice.axis), 0);
  for (const LabelScore& score : plane.labels)
    if (score.label == 0) return score;
  return {};
}

}  // namespace

std::vector<CrossLabel> findCrossSlices(const Image& labels) {
  return std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        return crossOf(Voxels<T>(labels.lattice, values), labels.lattice.size);
      },
      labels.values);
}

ContourSet outlinesOf(const Image& labels, const CrossLabel& label) {
  const ImageLattice& lattice = labels.lattice;
  ContourSet set;
  set.label = label.label, set.name = "label " + std::to_string(label.label);
  for (const CrossSlice& slice : label.slices) {
    const int u = slice.axis == 0 ? 1 : 0, w = slice.axis == 2 ? 1 : 2;
    const LabelScore score = scoreOn(labels, label, slice);
    // A rim of two pixels around the box, so that contours close at the map's border.
    SlicePlanes pixels;
    pixels.pixel = 1, pixels.nx = score.box.width() + 4, pixels.ny = score.box.height() + 4;
    pixels.origin = Vec2d(score.box.x0 - 2, score.box.y0 - 2);
    SliceImage image(size_t(pixels.nx) * size_t(pixels.ny),
                     float(std::min(lattice.spacing()[u], lattice.spacing()[w])));
    for (int y = 0; y < score.box.height(); ++y)
      for (int x = 0; x < score.box.width(); ++x)
        image[size_t(y + 2) * size_t(pixels.nx) + size_t(x + 2)] =
            -score.values[size_t(y) * size_t(score.box.width()) + size_t(x)];
    Vec3d at(0.0);
    at[slice.axis] = slice.at;
    PlaneContours plane = planeAt(lattice.toWorld(at), lattice.step[u].cross(lattice.step[w]));
    for (const Contour& contour : traceContours(image, pixels, 0)) {
      std::vector<Vec2d> loop;
      for (const Vec2d& p : contour.points) {
        at[u] = p[0], at[w] = p[1];
        loop.push_back(plane.toPlane(lattice.toWorld(at)));
      }
      plane.loops.push_back(std::move(loop));
    }
    if (!plane.loops.empty()) set.planes.push_back(std::move(plane));
  }
  return set;
}

Image withGiven(const Image& labels, const std::vector<CrossLabel>& cross, const Image& between) {
  Image result = labels;
  const openvdb::Coord size = labels.lattice.size;
  std::vector<std::array<std::vector<char>, 3>> on;
  for (const CrossLabel& label : cross) on.push_back(marked(label, size));
  std::visit(
      [&](auto& out, const auto& painted) {
        tbb::parallel_for(0, size[2], [&](int k) {
          for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i) {
              const size_t n = labels.lattice.index(i, j, k);
              if (out[n] != 0 || painted[n] == 0) continue;
              const size_t number = size_t(painted[n]) - 1;
              const auto& own = on[number];
              if (!own[0][size_t(i)] && !own[1][size_t(j)] && !own[2][size_t(k)])
                out[n] = std::decay_t<decltype(out[n])>(cross[number].label);
            }
        });
      },
      result.values, between.values);
  return result;
}

}  // namespace slicemorph
