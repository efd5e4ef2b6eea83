#include "engine/match/assignment.h"

#include <limits>

namespace slicemorph {

std::vector<int> assign(const std::vector<std::vector<double>>& cost) {
  const int n = int(cost.size()), m = n > 0 ? int(cost[0].size()) : 0;
  std::vector<double> u(n + 1, 0), v(m + 1, 0);
  std::vector<int> row(m + 1, 0), previous(m + 1, 0);
  for (int i = 1; i <= n; ++i) {
    row[0] = i;
    int column = 0;
    std::vector<double> least(m + 1, std::numeric_limits<double>::max());
    std::vector<char> used(m + 1, 0);
    do {
      used[column] = 1;
      const int r = row[column];
      double delta = std::numeric_limits<double>::max();
      int next = 0;
      for (int j = 1; j <= m; ++j) {
        if (used[j]) continue;
        const double c = cost[r - 1][j - 1] - u[r] - v[j];
        if (c < least[j]) least[j] = c, previous[j] = column;
        if (least[j] < delta) delta = least[j], next = j;
      }
      for (int j = 0; j <= m; ++j)
        if (used[j])
          u[row[j]] += delta, v[j] -= delta;
        else
          least[j] -= delta;
      column = next;
    } while (row[column] != 0);
    for (; column; column = previous[column]) row[column] = row[previous[column]];
  }
  std::vector<int> result(n, -1);
  for (int j = 1; j <= m; ++j)
    if (row[j] > 0) result[row[j] - 1] = j - 1;
  return result;
}

}  // namespace slicemorph
