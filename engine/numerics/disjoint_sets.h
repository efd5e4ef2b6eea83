#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace slicemorph {

/// Disjoint sets of the numbers from 0 on (union-find with path halving [TL84]). A set's
/// root is its smallest number, so nothing depends on the order in which sets were joined.
class DisjointSets {
 public:
  using Index = std::uint32_t;

  explicit DisjointSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), Index(0));
  }

  size_t count() const { return parent_.size(); }

  /// The smallest number of the set that holds `i`.
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

/// Disjoint sets whose members are also alike or opposite to each other, as two triangles of a surface are wound
/// alike or not. Every number has an opposite beside it, `count` further on: numbers are joined with what they are
/// alike to, and their opposites with each other.
class OrientedSets {
 public:
  using Index = DisjointSets::Index;

  explicit OrientedSets(size_t count) : count_(Index(count)), sets_(2 * count) {}

  /// The smallest number of the set that holds `i`, whether alike or opposite.
  Index root(Index i) { return std::min(sets_.find(i), sets_.find(i + count_)); }
  /// Whether `i` is opposite to its set's root.
  bool flipped(Index i) { return sets_.find(i) != root(i); }

  /// Joins two sets; false, with nothing joined, where that contradicts what is known of `a` and `b`.
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
