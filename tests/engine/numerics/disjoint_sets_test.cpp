#include "engine/numerics/disjoint_sets.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

/// Reference by relabelling everything at every join: each number knows its set's smallest number, and
/// whether it is opposite to it.
struct BruteSets {
  std::vector<unsigned> root;
  std::vector<bool> flip;

  explicit BruteSets(size_t count) : root(count), flip(count, false) {
    for (unsigned i = 0; i < count; ++i) root[i] = i;
  }
  bool join(unsigned a, unsigned b, bool opposite) {
    const bool turn = (flip[a] != flip[b]) != opposite;
    if (root[a] == root[b]) return !turn;
    const unsigned low = std::min(root[a], root[b]), high = std::max(root[a], root[b]);
    for (size_t i = 0; i < root.size(); ++i)
      if (root[i] == high) root[i] = low, flip[i] = flip[i] != turn;
    return true;
  }
};

TEST(DisjointSets, AreThoseOfRelabelling) {
  std::mt19937 random(7);
  for (unsigned count : {1u, 2u, 10u, 60u}) {
    DisjointSets sets(count);
    BruteSets brute(count);
    for (unsigned round = 0; round < count; ++round) {
      const unsigned a = random() % count, b = random() % count;
      sets.join(a, b);
      brute.join(a, b, false);
      for (unsigned i = 0; i < count; ++i) ASSERT_EQ(sets.find(i), brute.root[i]) << count << " " << round;
    }
  }
}

TEST(OrientedSets, AreThoseOfRelabelling) {
  std::mt19937 random(11);
  int refused = 0;
  for (int sample = 0; sample < 20; ++sample) {
    const unsigned count = 2 + random() % 40;
    OrientedSets sets(count);
    BruteSets brute(count);
    for (unsigned round = 0; round < 2 * count; ++round) {
      const unsigned a = random() % count, b = random() % count;
      const bool opposite = random() % 2;
      const bool joined = brute.join(a, b, opposite);
      refused += !joined;
      ASSERT_EQ(sets.join(a, b, opposite), joined);
      for (unsigned i = 0; i < count; ++i) {
        ASSERT_EQ(sets.root(i), brute.root[i]);
        ASSERT_EQ(sets.flipped(i), brute.flip[i]);
      }
    }
  }
  EXPECT_GT(refused, 20);  // contradictions did occur
}

}  // namespace
}  // namespace slicemorph
