#include "engine/reconstruct/stray_pieces.h"

#include "engine/numerics/disjoint_sets.h"
#include "engine/numerics/lattice_cell.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

namespace slicemorph {

namespace {

/// Consecutive nodes of one row of a lattice on the same side of the surface.
struct Run {
  size_t begin = 0, end = 0;
  bool inside = false;
};

/// Runs of nodes on the same side, joined with those of neighbouring rows.
class SidesOfSurface {
 public:
  SidesOfSurface(const Lattice& lattice, const std::vector<float>& values)
      : lattice_(lattice), first_(size_t(lattice.size[1]) * lattice.size[2] + 1) {
    std::vector<std::vector<Run>> slabs(lattice.size[2]);
    tbb::parallel_for(0, lattice.size[2], [&](int k) {
      for (int j = 0; j < lattice.size[1]; ++j) {
        const size_t begin = lattice.index(0, j, k), end = begin + lattice.size[0], before = slabs[k].size();
        for (size_t n = begin; n < end; ++n) {
          const bool inside = values[n] < 0;
          if (n == begin || inside != slabs[k].back().inside) slabs[k].push_back({n, n, inside});
          slabs[k].back().end = n + 1;
        }
        first_[size_t(k) * lattice.size[1] + j + 1] = slabs[k].size() - before;
      }
    });
    for (size_t row = 1; row < first_.size(); ++row) first_[row] += first_[row - 1];
    for (const std::vector<Run>& slab : slabs) runs_.insert(runs_.end(), slab.begin(), slab.end());
    sets_ = DisjointSets(runs_.size());
    for (size_t row = 0; row + 1 < first_.size(); ++row) {
      if (row % lattice.size[1]) joinRows(row, row - 1);
      if (row >= size_t(lattice.size[1])) joinRows(row, row - lattice.size[1]);
    }
  }

  const std::vector<Run>& runs() const { return runs_; }
  std::uint32_t sideOf(size_t node) {
    const size_t row = node / lattice_.size[0];
    const auto after =
        std::upper_bound(runs_.begin() + long(first_[row]), runs_.begin() + long(first_[row + 1]), node,
                         [](size_t n, const Run& run) { return n < run.begin; });
    return find(std::uint32_t(after - runs_.begin() - 1));
  }
  std::uint32_t find(std::uint32_t run) { return sets_.find(run); }

 private:
  void joinRows(size_t a, size_t b) {
    const size_t shift = (a - b) * lattice_.size[0];
    for (size_t i = first_[a], j = first_[b]; i < first_[a + 1] && j < first_[b + 1];) {
      if (runs_[i].inside == runs_[j].inside) sets_.join(std::uint32_t(i), std::uint32_t(j));
      if (runs_[i].end < runs_[j].end + shift)
        ++i;
      else
        ++j;
    }
  }

  const Lattice& lattice_;
  std::vector<Run> runs_;
  std::vector<size_t> first_;  ///< index of each row's first run
  DisjointSets sets_{0};
};

}  // namespace

WithoutStrays dropStrayPieces(const PlaneSet& planes, const Lattice& lattice, std::vector<float> values) {
  const std::array<std::uint32_t, 8> corners = cornerOffsets(lattice);
  SidesOfSurface sides(lattice, values);
  std::vector<char> touched(sides.runs().size(), 0);
  touched[sides.sideOf(0)] = 1;
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges) {
      const std::uint32_t cell = cellPoint(lattice, planes.world(int(i), 0.5 * (e.a + e.b))).cell;
      for (std::uint32_t c : corners) touched[sides.sideOf(cell + c)] = 1;
    }
  int strays = 0;
  for (std::uint32_t r = 0; r < touched.size(); ++r) {
    const std::uint32_t side = sides.find(r);
    if (touched[side]) continue;
    strays += side == r;
    for (size_t n = sides.runs()[r].begin; n < sides.runs()[r].end; ++n) values[n] = -values[n];
  }
  return {std::move(values), strays};
}

}  // namespace slicemorph
