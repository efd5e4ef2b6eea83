#include "engine/volume/turn_outwards.h"

#include "engine/numerics/edge_table.h"

#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

using Index = std::uint32_t;

constexpr Index kNoPart = std::numeric_limits<Index>::max();

struct Part {
  std::vector<Index> triangles;
  openvdb::BBoxd box;
  double volume = 0;
  bool closed = true;
};

std::vector<Part> partsOf(const Mesh& mesh, const std::vector<Index>& patch) {
  std::vector<Index> partOf(mesh.triangles.size(), kNoPart);
  std::vector<Part> parts;
  const Vec3d origin = Vec3d(mesh.points[mesh.triangles[0][0]]);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    Index& part = partOf[patch[t]];
    if (part == kNoPart) {
      part = Index(parts.size());
      parts.emplace_back();
    }
    parts[part].triangles.push_back(Index(t));
    parts[part].volume += signedVolume(mesh.points, mesh.triangles[t], origin);
    for (int k = 0; k < 3; ++k) parts[part].box.expand(Vec3d(mesh.points[mesh.triangles[t][k]]));
  }
  const EdgeTable edges(mesh.triangles);
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) == 2) continue;
    // Patches meet here. One is closed by itself if its faces at the edge balance in direction.
    for (size_t i = 0; i < edges.faces(e); ++i) {
      const Index own = partOf[patch[edges.half(e, i).triangle()]];
      int balance = 0;
      for (size_t j = 0; j < edges.faces(e); ++j) {
        if (partOf[patch[edges.half(e, j).triangle()]] == own) balance += edges.half(e, j).forward ? 1 : -1;
      }
      if (balance != 0) parts[own].closed = false;
    }
  }
  return parts;
}

/// Winding number of a closed part around a point, summed from solid angles [VS83].
double windingNumber(const Mesh& mesh, const Part& part, const Vec3d& point) {
  double sum = 0;
  for (Index t : part.triangles) {
    const Vec3d a = Vec3d(mesh.points[mesh.triangles[t][0]]) - point;
    const Vec3d b = Vec3d(mesh.points[mesh.triangles[t][1]]) - point;
    const Vec3d c = Vec3d(mesh.points[mesh.triangles[t][2]]) - point;
    const double la = a.length(), lb = b.length(), lc = c.length();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * M_PI);
}

}  // namespace

double signedVolume(const std::vector<openvdb::Vec3s>& points, const openvdb::Vec3I& t, const Vec3d& origin) {
  const Vec3d a = Vec3d(points[t[0]]) - origin;
  return a.dot((Vec3d(points[t[1]]) - origin).cross(Vec3d(points[t[2]]) - origin)) / 6;
}

void turnOver(Mesh& mesh, const std::vector<Index>& triangles) {
  for (Index t : triangles) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
}

TurnedParts turnOutwards(Mesh& mesh, const std::vector<Index>& patch) {
  const std::vector<Part> parts = partsOf(mesh, patch);
  TurnedParts result;
  for (const Part& part : parts) {
    if (!part.closed || part.volume == 0) continue;
    const Vec3d probe = Vec3d(mesh.points[mesh.triangles[part.triangles[0]][0]]);
    bool cavity = false;
    for (const Part& other : parts) {
      const bool candidate = other.closed && (other.volume < 0) != (part.volume < 0) &&
                             std::abs(other.volume) > std::abs(part.volume) && other.box.isInside(part.box);
      if (candidate && std::abs(windingNumber(mesh, other, probe)) > 0.5) {
        cavity = true;
        break;
      }
    }
    result.cavities += cavity;
    if (part.volume > 0) continue;
    result.insideOut += !cavity;
    turnOver(mesh, part.triangles);
    result.triangles.insert(result.triangles.end(), part.triangles.begin(), part.triangles.end());
  }
  return result;
}

}  // namespace slicemorph
