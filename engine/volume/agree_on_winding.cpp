#include "engine/volume/agree_on_winding.h"

#include "engine/numerics/disjoint_sets.h"
#include "engine/numerics/edge_table.h"

namespace slicemorph {
namespace {

/// The sets of triangles that are connected across edges with two faces and either all turned or all not.
std::vector<std::uint32_t> piecesOf(const EdgeTable& edges, const std::vector<char>& turned) {
  DisjointSets pieces(turned.size());
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) != 2) continue;
    const std::uint32_t a = edges.half(e, 0).triangle(), b = edges.half(e, 1).triangle();
    if (turned[a] == turned[b]) pieces.join(a, b);
  }
  std::vector<std::uint32_t> piece(turned.size());
  for (std::uint32_t t = 0; t < piece.size(); ++t) piece[t] = pieces.find(t);
  return piece;
}

}  // namespace

AgreedWinding agreeOnWinding(std::vector<openvdb::Vec3I> triangles) {
  using Index = std::uint32_t;
  const EdgeTable edges(triangles);
  const size_t count = triangles.size();
  OrientedSets patches(count);
  DisjointSets shells(count);
  AgreedWinding result;
  for (size_t e = 0; e < edges.count(); ++e) {
    const HalfEdge& first = edges.half(e, 0);
    for (size_t i = 1; i < edges.faces(e); ++i) shells.join(first.triangle(), edges.half(e, i).triangle());
    if (edges.faces(e) > 2) ++result.nonManifold;
    if (edges.faces(e) != 2) continue;
    const HalfEdge& second = edges.half(e, 1);
    if (!patches.join(first.triangle(), second.triangle(), first.forward == second.forward)) ++result.twisted;
  }
  std::vector<ptrdiff_t> against(count, 0);
  result.patch.resize(count);
  result.shell.resize(count);
  for (Index t = 0; t < count; ++t) {
    result.patch[t] = patches.root(t);
    result.shell[t] = shells.find(t);
    result.shells += result.shell[t] == t;
    against[result.patch[t]] += patches.flipped(t) ? 1 : -1;
  }
  std::vector<char> turned(count, 0);
  for (Index t = 0; t < count; ++t)
    if (patches.flipped(t) != (against[result.patch[t]] > 0)) {
      std::swap(triangles[t][1], triangles[t][2]);
      turned[t] = 1;
      ++result.turned;
    }
  result.piece = result.turned > 0 ? piecesOf(edges, turned) : result.patch;
  result.triangles = std::move(triangles);
  return result;
}

std::vector<std::vector<std::uint32_t>> trianglesOfSets(const std::vector<std::uint32_t>& setOf) {
  constexpr auto kNone = std::uint32_t(-1);
  std::vector<std::uint32_t> number(setOf.size(), kNone);
  std::vector<std::vector<std::uint32_t>> sets;
  for (std::uint32_t t = 0; t < setOf.size(); ++t) {
    std::uint32_t& n = number[setOf[t]];
    if (n == kNone) n = std::uint32_t(sets.size()), sets.emplace_back();
    sets[n].push_back(t);
  }
  return sets;
}

}  // namespace slicemorph
