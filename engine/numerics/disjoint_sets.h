#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace slicemorph {

/// Disjoint sets of the numbers 0, 1, ... (union-find with path halving [TL84]). A set's root is its smallest
/// number, so nothing depends on the order in which sets were joined.
class DisjointSets {
 public:
  using Index = std::uint32_t;

  explicit DisjointSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), Index(0));
  }

  size_t count() const { return parent_.size(); }

  /// The smallest number of the set that contains `i`.
  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void join(Index a, Index b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

/// Disjoint sets whose members also have an orientation relative to each other, equal or opposite, like the
/// winding of a surface's triangles. Implemented with 2 * count numbers: number i + count stands for the
/// opposite of i. Numbers are joined with those of equal orientation, and their opposites likewise.
class OrientedSets {
 public:
  using Index = DisjointSets::Index;

  explicit OrientedSets(size_t count) : count_(Index(count)), sets_(2 * count) {}

  /// The smallest number of the set that contains `i`, in either orientation.
  Index root(Index i) { return std::min(sets_.find(i), sets_.find(i + count_)); }
  /// Whether `i` is opposite to its set's root.
  bool flipped(Index i) { return sets_.find(i) != root(i); }

  /// Joins two sets; returns false, and joins nothing, if that contradicts the known orientations of
  /// `a` and `b`.
  bool join(Index a, Index b, bool opposite) {
    const Index alike = opposite ? b + count_ : b, unlike = opposite ? b : b + count_;
    if (sets_.find(a) == sets_.find(unlike)) return false;
    sets_.join(a, alike);
    sets_.join(a + count_, unlike);
    return true;
  }

 private:
  Index count_;
  DisjointSets sets_;
};

}  // namespace slicemorph
