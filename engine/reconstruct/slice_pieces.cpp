#include "engine/reconstruct/slice_pieces.h"

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
  const auto alike = [](const PieceRun& a, const PieceRun& b) { return a.label == b.label; };
  const std::vector<std::uint32_t> first = joinedRuns(runs, touching, alike);
  for (size_t i = 0; i < runs.size(); ++i) runs[i].piece = first[i];
}

}  // namespace slicemorph
