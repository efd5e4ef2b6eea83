#include "engine/volume/triangulate_faces.h"

#include "engine/volume/clip_ears.h"

#include <algorithm>
#include <array>

namespace slicemorph {

namespace {

using openvdb::Vec3I;
using Index = std::uint32_t;

std::vector<Index> distinctCorners(const PolygonMesh& mesh, const WeldedPoints& welded, size_t f) {
  std::vector<Index> face;
  for (Index c = mesh.faceStarts[f]; c < mesh.faceStarts[f + 1]; ++c) {
    const Index corner = welded.newIndex[mesh.corners[c]];
    if (face.empty() || face.back() != corner) face.push_back(corner);
  }
  while (face.size() > 1 && face.front() == face.back()) face.pop_back();
  return face;
}

bool isDegenerate(const Vec3I& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Drops triangles with the same three points as an earlier one, whatever the winding; returns how many.
size_t dropDuplicates(std::vector<Vec3I>& triangles) {
  using Key = std::array<Index, 4>;
  std::vector<Key> keys(triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i) {
    Vec3I t = triangles[i];
    std::sort(&t[0], &t[0] + 3);
    keys[i] = {t[0], t[1], t[2], Index(i)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<bool> drop(triangles.size(), false);
  for (size_t i = 1; i < keys.size(); ++i) {
    drop[keys[i][3]] = std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin());
  }
  size_t kept = 0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (!drop[i]) triangles[kept++] = triangles[i];
  }
  const size_t dropped = triangles.size() - kept;
  triangles.resize(kept);
  return dropped;
}

}  // namespace

TriangulatedFaces triangulateFaces(const PolygonMesh& mesh, const WeldedPoints& welded) {
  TriangulatedFaces result;
  for (size_t f = 0; f < mesh.faceCount(); ++f) {
    const std::vector<Index> face = distinctCorners(mesh, welded, f);
    if (face.size() < 3) {
      ++result.degenerate;
      continue;
    }
    if (face.size() == 3) {
      result.triangles.emplace_back(face[0], face[1], face[2]);
    } else {
      ++result.polygons;
      for (const Vec3I& t : clipEars(welded.points, face)) result.triangles.push_back(t);
    }
  }
  const auto end = std::remove_if(result.triangles.begin(), result.triangles.end(), isDegenerate);
  result.degenerate += size_t(result.triangles.end() - end);
  result.triangles.erase(end, result.triangles.end());
  result.duplicate = dropDuplicates(result.triangles);
  return result;
}

}  // namespace slicemorph
