#include "engine/reconstruct/slice_pieces.h"

#include "engine/numerics/disjoint_sets.h"

namespace slicemorph {

std::vector<PieceRun> findRuns(const PixelBox& domain, const int* slice) {
  std::vector<PieceRun> runs;
  const int width = domain.width();
  for (int y = domain.y0; y < domain.y1; ++y) {
    const int* row = slice + domain.index(domain.x0, y);
    for (int x = 0, end = 0; x < width; x = end) {
      for (end = x + 1; end < width && row[end] == row[x];) ++end;
      runs.push_back({y, domain.x0 + x, domain.x0 + end, row[x], std::uint32_t(runs.size())});
    }
  }
  return runs;
}

void joinToPieces(std::vector<PieceRun>& runs, Touching touching) {
  const int reach = touching == Touching::kCorners;
  DisjointSets pieces(runs.size());
  for (size_t i = 0, above = 0; i < runs.size(); ++i) {
    const PieceRun& run = runs[i];
    while (runs[above].y < run.y - 1 || (runs[above].y < run.y && runs[above].x1 + reach <= run.x0)) ++above;
    for (size_t k = above; runs[k].y < run.y && runs[k].x0 < run.x1 + reach; ++k)
      if (runs[k].label == run.label) pieces.join(std::uint32_t(k), std::uint32_t(i));
  }
  for (size_t i = 0; i < runs.size(); ++i) runs[i].piece = pieces.find(std::uint32_t(i));
}

}  // namespace slicemorph
