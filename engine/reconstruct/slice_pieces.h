#pragma once

#include "engine/numerics/disjoint_sets.h"
#include "engine/numerics/pixel_box.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// The pixels [x0, x1) of one row that have one label and belong to one piece.
struct PieceRun {
  int y, x0, x1, label;
  std::uint32_t piece;  ///< index of the piece's first run
};

/// Which pixels of a label hang together.
enum class Touching { kSides, kCorners };

/// A slice's runs of equal labels, row by row, from left to right; each run is a piece.
std::vector<PieceRun> findRuns(const PixelBox& domain, const int* slice);

/// Of every run, row by row and from left to right as those are, the first run of all that hang together with it. Those
/// that touch hang together where `alike(a, b)`.
template <typename Run, typename Alike>
std::vector<std::uint32_t> joinedRuns(const std::vector<Run>& runs, Touching touching, const Alike& alike) {
  const int reach = touching == Touching::kCorners;
  DisjointSets joined(runs.size());
  for (size_t i = 0, above = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    while (runs[above].y < run.y - 1 || (runs[above].y < run.y && runs[above].x1 + reach <= run.x0)) ++above;
    for (size_t k = above; runs[k].y < run.y && runs[k].x0 < run.x1 + reach; ++k)
      if (alike(runs[k], run)) joined.join(std::uint32_t(k), std::uint32_t(i));
  }
  std::vector<std::uint32_t> first;
  for (size_t i = 0; i < runs.size(); ++i) first.push_back(joined.find(std::uint32_t(i)));
  return first;
}

/// Joins the runs of a slice to pieces.
void joinToPieces(std::vector<PieceRun>& runs, Touching touching);

}  // namespace slicemorph
