#include "engine/match/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

namespace slicemorph {
namespace {

using Costs = std::vector<std::vector<double>>;

double totalOf(const Costs& cost, const std::vector<int>& columns) {
  double total = 0;
  for (size_t i = 0; i < cost.size(); ++i) total += cost[i][size_t(columns[i])];
  return total;
}

/// Least total over all ways to give every row a column of its own.
double leastTotal(const Costs& cost) {
  std::vector<int> columns(cost[0].size());
  std::iota(columns.begin(), columns.end(), 0);
  double least = 1e300;
  do least = std::min(least, totalOf(cost, columns));
  while (std::next_permutation(columns.begin(), columns.end()));
  return least;
}

Costs randomCosts(size_t rows, size_t columns, std::mt19937& random) {
  Costs cost(rows, std::vector<double>(columns));
  for (auto& row : cost)
    for (double& c : row) c = int(random() % 13) - 4;  // whole, so that ties happen and sums are exact
  return cost;
}

TEST(Assignment, IsTheBestOfAllPermutations) {
  std::mt19937 random(1);
  for (size_t columns = 1; columns <= 6; ++columns)
    for (size_t rows = 1; rows <= columns; ++rows)
      for (int repeat = 0; repeat < 20; ++repeat) {
        const Costs cost = randomCosts(rows, columns, random);
        const std::vector<int> assigned = assign(cost);
        ASSERT_EQ(assigned.size(), rows);
        EXPECT_EQ(std::set<int>(assigned.begin(), assigned.end()).size(), rows);
        EXPECT_EQ(totalOf(cost, assigned), leastTotal(cost)) << rows << " rows, " << columns << " columns";
      }
}

/// Forbidden pairs have a cost beyond all others.
TEST(Assignment, AvoidsForbiddenPairs) {
  EXPECT_EQ(assign({{1, 1e6}, {0, 5}}), (std::vector<int>{0, 1}));
  EXPECT_EQ(assign({{1e6, 2, 1e6}, {1e6, 1, 3}}), (std::vector<int>{1, 2}));
}

TEST(Assignment, OfNothingIsNothing) { EXPECT_TRUE(assign({}).empty()); }

}  // namespace
}  // namespace slicemorph
