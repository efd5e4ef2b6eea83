#include "engine/measure/label_measures.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <map>

namespace slicemorph {
namespace {

constexpr int kDirections = 13;
constexpr int kSteps[kDirections][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 0},  {1, -1, 0},
                                        {1, 0, 1},  {1, 0, -1}, {0, 1, 1},  {0, 1, -1}, {1, 1, 1},
                                        {1, 1, -1}, {1, -1, 1}, {1, -1, -1}};

/// Area that belongs to one line of each of the 13 directions, times the share of all directions
/// nearest to it.
std::array<double, kDirections> lineAreas(const ImageLattice& lattice) {
  constexpr int kPoints = 40000;  // directions sampled on a hemisphere
  std::array<Vec3d, kDirections> direction;
  std::array<double, kDirections> area{};
  const double voxel = std::abs(lattice.step[0].dot(lattice.step[1].cross(lattice.step[2])));
  for (int n = 0; n < kDirections; ++n)
    direction[n] =
        kSteps[n][0] * lattice.step[0] + kSteps[n][1] * lattice.step[1] + kSteps[n][2] * lattice.step[2];
  for (int i = 0; i < kPoints; ++i) {  // spiral of uniform density on a hemisphere
    const double z = (i + 0.5) / kPoints, turn = i * M_PI * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
    const Vec3d p(r * std::cos(turn), r * std::sin(turn), z);
    int nearest = 0;
    double most = -1;
    for (int n = 0; n < kDirections; ++n)
      if (const double c = std::abs(p.dot(direction[n])) / direction[n].length(); c > most)
        most = c, nearest = n;
    area[size_t(nearest)] += 1.0 / kPoints;
  }
  for (int n = 0; n < kDirections; ++n) area[size_t(n)] *= voxel / direction[n].length();
  return area;
}

struct Tally {
  size_t voxels = 0;
  openvdb::CoordBBox box;
  Vec3d sum{0, 0, 0};
  std::array<size_t, kDirections> changes{};

  void add(const Tally& other) {
    voxels += other.voxels, sum += other.sum;
    box.expand(other.box);
    for (int n = 0; n < kDirections; ++n) changes[n] += other.changes[n];
  }
};
using Tallies = std::map<std::int64_t, Tally>;

/// `value(index)`: the label of a voxel.
template <typename Value>
Tallies tally(const ImageLattice& lattice, const Value& value) {
  const openvdb::Coord n = lattice.size;
  std::vector<Tallies> slices(static_cast<size_t>(n[2]));
  tbb::parallel_for(0, n[2], [&](int k) {
    Tallies& slice = slices[size_t(k)];
    const auto at = [&](int x, int y, int z) {
      return x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2] ? std::int64_t(0)
                                                                            : value(lattice.index(x, y, z));
    };
    Tally* last = nullptr;
    std::int64_t lastLabel = 0;
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const std::int64_t label = value(lattice.index(i, j, k));
        if (label == 0) continue;
        if (!last || label != lastLabel) last = &slice[label], lastLabel = label;
        ++last->voxels;
        last->sum += Vec3d(i, j, k);
        last->box.expand(openvdb::Coord(i, j, k));
        // Each voxel looks in both directions and counts its own changes.
        for (int d = 0; d < kDirections; ++d) {
          const int* s = kSteps[d];
          last->changes[size_t(d)] += size_t(at(i + s[0], j + s[1], k + s[2]) != label) +
                                      size_t(at(i - s[0], j - s[1], k - s[2]) != label);
        }
      }
  });
  Tallies all;
  for (const Tallies& slice : slices)
    for (const auto& [label, tally] : slice) all[label].add(tally);
  return all;
}

std::vector<LabelMeasures> measured(const ImageLattice& lattice, const Tallies& tallies) {
  const std::array<double, kDirections> area = lineAreas(lattice);
  const Vec3d spacing = lattice.spacing();
  const double voxel = std::abs(lattice.step[0].dot(lattice.step[1].cross(lattice.step[2])));
  std::vector<LabelMeasures> result;
  for (const auto& [label, t] : tallies) {
    LabelMeasures m;
    m.label = label, m.voxels = t.voxels;
    m.volume = voxel * double(t.voxels);
    // Cauchy: the area is four times the mean projection, and every line that enters also leaves.
    for (int n = 0; n < kDirections; ++n) m.area += 2 * area[size_t(n)] * double(t.changes[size_t(n)]);
    for (int d = 0; d < 3; ++d) m.extents[d] = (t.box.max()[d] - t.box.min()[d] + 1) * spacing[d];
    m.centroid = lattice.toWorld(t.sum / double(t.voxels));
    result.push_back(m);
  }
  return result;
}

}  // namespace

std::vector<LabelMeasures> measureLabels(const Image& labels) {
  return std::visit(
      [&](const auto& values) {
        return measured(labels.lattice,
                        tally(labels.lattice, [&](size_t i) { return std::int64_t(values[i]); }));
      },
      labels.values);
}

LabelMeasures measureAbove(const Image& image, double iso) {
  return std::visit(
      [&](const auto& values) {
        const auto found =
            measured(image.lattice,
                     tally(image.lattice, [&](size_t i) { return std::int64_t(double(values[i]) > iso); }));
        return found.empty() ? LabelMeasures() : found[0];
      },
      image.values);
}

}  // namespace slicemorph
