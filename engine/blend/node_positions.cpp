#include "engine/blend/node_positions.h"

#include "engine/numerics/catmull_rom.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

namespace {

openvdb::Vec3s combined(const std::array<float, 4>& w, const openvdb::Vec3s& p, const openvdb::Vec3s& q,
                        const openvdb::Vec3s& r, const openvdb::Vec3s& s) {
  return openvdb::Vec3s(w[0] * p[0] + w[1] * q[0] + w[2] * r[0] + w[3] * s[0],
                        w[0] * p[1] + w[1] * q[1] + w[2] * r[1] + w[3] * s[1],
                        w[0] * p[2] + w[1] * q[2] + w[2] * r[2] + w[3] * s[2]);
}

}  // namespace

std::vector<openvdb::Coord> leavesWith(const NodeMap& nodes,
                                       const std::function<bool(int, int, int)>& active) {
  const int perLeaf = kLeaf / nodes.step;
  const auto leafOf = [&](int node) {
    return node >= 0 ? node / perLeaf : -((-node + perLeaf - 1) / perLeaf);
  };
  openvdb::Coord low, high;
  for (int a = 0; a < 3; ++a)
    low[a] = leafOf(nodes.origin[a]), high[a] = leafOf(nodes.origin[a] + std::max(nodes.size[a] - 1, 0));
  std::vector<std::vector<openvdb::Coord>> found(std::max(0, high[2] - low[2] + 1));
  tbb::parallel_for(0, int(found.size()), [&](int s) {
    const int z = low[2] + s;
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x) {
        bool any = false;
        for (int c = 0; c < perLeaf * perLeaf * perLeaf && !any; ++c)
          any = active(x * perLeaf + c % perLeaf, y * perLeaf + c / perLeaf % perLeaf,
                       z * perLeaf + c / (perLeaf * perLeaf));
        if (any) found[s].emplace_back(x * kLeaf, y * kLeaf, z * kLeaf);
      }
  });
  std::vector<openvdb::Coord> all;
  for (const auto& list : found) all.insert(all.end(), list.begin(), list.end());
  return all;
}

NodePositions::NodePositions(const NodeMap& nodes) : nodes_(nodes), step_(nodes.step) {
  for (int i = 0; i < step_; ++i) {
    const std::array<double, 4> w = catmullRomWeights(double(i) / step_);
    spline_.push_back({float(w[0]), float(w[1]), float(w[2]), float(w[3])});
  }
}

void NodePositions::find(int i, int j, int k, size_t object, std::vector<openvdb::Vec3s>& positions) const {
  openvdb::Vec3s node[4][4][4];
  bool all = nodes_.inside(i - 1, j - 1, k - 1) && nodes_.inside(i + 2, j + 2, k + 2);
  for (int c = 0; c < 4 && all; ++c)
    for (int b = 0; b < 4 && all; ++b)
      for (int a = 0; a < 4 && all; ++a) {
        const size_t n = nodes_.index(i - 1 + a, j - 1 + b, k - 1 + c);
        all = nodes_.known[n];
        node[a][b][c] = nodes_.at[n * nodes_.objects + object];
      }
  if (!all || torn(i - 1, j - 1, k - 1, 4, object)) return findLinearly(i, j, k, object, positions);
  openvdb::Vec3s alongZ[4][4][kLeaf], alongY[4][kLeaf][kLeaf];
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      for (int z = 0; z < step_; ++z)
        alongZ[a][b][z] = combined(spline_[z], node[a][b][0], node[a][b][1], node[a][b][2], node[a][b][3]);
  for (int a = 0; a < 4; ++a)
    for (int y = 0; y < step_; ++y)
      for (int z = 0; z < step_; ++z)
        alongY[a][y][z] =
            combined(spline_[y], alongZ[a][0][z], alongZ[a][1][z], alongZ[a][2][z], alongZ[a][3][z]);
  size_t v = 0;
  for (int x = 0; x < step_; ++x)
    for (int y = 0; y < step_; ++y)
      for (int z = 0; z < step_; ++z)
        positions[v++] =
            combined(spline_[x], alongY[0][y][z], alongY[1][y][z], alongY[2][y][z], alongY[3][y][z]);
}

bool NodePositions::torn(int i, int j, int k, int side, size_t object) const {
  if (nodes_.jump.empty()) return false;
  const float longest = float(nodes_.jump[object] * nodes_.jump[object]);
  const auto position = [&](int a, int b, int c) {
    return nodes_.at[nodes_.index(a, b, c) * nodes_.objects + object];
  };
  for (int c = k; c < k + side; ++c)
    for (int b = j; b < j + side; ++b)
      for (int a = i; a < i + side; ++a) {
        const openvdb::Vec3s p = position(a, b, c);
        if (a + 1 < i + side && (position(a + 1, b, c) - p).lengthSqr() > longest) return true;
        if (b + 1 < j + side && (position(a, b + 1, c) - p).lengthSqr() > longest) return true;
        if (c + 1 < k + side && (position(a, b, c + 1) - p).lengthSqr() > longest) return true;
      }
  return false;
}

void NodePositions::findLinearly(int i, int j, int k, size_t object,
                                 std::vector<openvdb::Vec3s>& positions) const {
  openvdb::Vec3s node[8];
  for (int c = 0; c < 8; ++c)
    node[c] = nodes_.at[nodes_.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) * nodes_.objects + object];
  size_t v = 0;
  for (int x = 0; x < step_; ++x)
    for (int y = 0; y < step_; ++y)
      for (int z = 0; z < step_; ++z) {
        const float a = float(x) / step_, b = float(y) / step_, c = float(z) / step_;
        openvdb::Vec3s sum(0.f);
        for (int n = 0; n < 8; ++n)
          sum += node[n] * ((n & 1 ? a : 1 - a) * (n & 2 ? b : 1 - b) * (n & 4 ? c : 1 - c));
        positions[v++] = sum;
      }
}

}  // namespace slicemorph
