#include "engine/volume/distance_field.h"

#include "engine/errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace slicemorph {

namespace {

/// The band's voxels next to the surface, as points on it with their outward normals.
template <typename Visit>
void visitSurfacePoints(const FloatGrid& grid, const Visit& visit) {
  const double h = grid.voxelSize()[0];
  const auto& transform = grid.transform();
  auto accessor = grid.getConstAccessor();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      const float f = *it;
      if (std::abs(f) > 0.87 * h) continue;  // half a voxel's diagonal
      const openvdb::Coord c = it.getCoord();
      Vec3d g;
      for (int a = 0; a < 3; ++a) {
        openvdb::Coord step(0, 0, 0);
        step[a] = 1;
        g[a] = accessor.getValue(c + step) - accessor.getValue(c - step);
      }
      const double length = g.length();
      if (!(length > 0.2 * h)) continue;
      g /= length;
      visit(transform.indexToWorld(c) - double(f) * g, g, double(f));
    }
  }
}

double clampTo(double v, double low, double high) { return std::min(std::max(v, low), high); }

}  // namespace

DistanceField::DistanceField(FloatGrid::ConstPtr levelSet, int nodes) : levelSet_(std::move(levelSet)) {
  voxelSize_ = levelSet_->voxelSize()[0];
  fineOrigin_ = levelSet_->transform().indexToWorld(Vec3d(0.0));
  box_ = openvdb::BBoxd();
  visitSurfacePoints(*levelSet_, [&](const Vec3d& p, const Vec3d&, double) { box_.expand(p); });
  if (box_.empty()) throw GeometryError("the level set '" + levelSet_->getName() + "' has no surface");
  const Vec3d extent = box_.extents();
  const double longest = std::max({extent[0], extent[1], extent[2], 4 * voxelSize_});
  spacing_ = std::max(voxelSize_, longest / nodes);
  constexpr int kMargin = 6;
  origin_ = box_.min() - Vec3d(kMargin * spacing_);
  for (int a = 0; a < 3; ++a) size_[a] = int(std::ceil(extent[a] / spacing_)) + 2 * kMargin + 1;
  const size_t count = size_t(size_[0]) * size_[1] * size_[2];
  distance_.assign(count, std::numeric_limits<float>::max());
  closest_.assign(count, openvdb::Vec3s(0.f));
  seedFromBand();
  sweep();
  signDistances();
  sampleSurface(8000);
}

void DistanceField::seedFromBand() {
  visitSurfacePoints(*levelSet_, [&](const Vec3d& p, const Vec3d&, double) {
    const Vec3d q = (p - origin_) / spacing_;
    const openvdb::Coord base = openvdb::Coord::floor(q);
    for (int dz = 0; dz < 2; ++dz)
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
          const int x = base[0] + dx, y = base[1] + dy, z = base[2] + dz;
          const float d = float((nodePosition(x, y, z) - p).length());
          const size_t i = index(x, y, z);
          if (d < distance_[i]) distance_[i] = d, closest_[i] = openvdb::Vec3s(p);
        }
  });
}

/// Closest points handed from neighbour to neighbour, in eight sweeps (Danielsson 1980, in Gauss-Seidel order).
void DistanceField::sweep() {
  for (int pass = 0; pass < 8; ++pass) {
    const int sx = pass & 1 ? -1 : 1, sy = pass & 2 ? -1 : 1, sz = pass & 4 ? -1 : 1;
    for (int k = 0; k < size_[2]; ++k) {
      const int z = sz > 0 ? k : size_[2] - 1 - k;
      for (int j = 0; j < size_[1]; ++j) {
        const int y = sy > 0 ? j : size_[1] - 1 - j;
        for (int i = 0; i < size_[0]; ++i) {
          const int x = sx > 0 ? i : size_[0] - 1 - i;
          const size_t here = index(x, y, z);
          const openvdb::Vec3s p(nodePosition(x, y, z));
          const auto take = [&](size_t from) {
            if (distance_[from] == std::numeric_limits<float>::max()) return;
            const float d = (p - closest_[from]).length();
            if (d < distance_[here]) distance_[here] = d, closest_[here] = closest_[from];
          };
          if (i > 0) take(index(x - sx, y, z));
          if (j > 0) take(index(x, y - sy, z));
          if (k > 0) take(index(x, y, z - sz));
        }
      }
    }
  }
}

/// The fine grid knows the side everywhere, and the distance itself inside its band.
void DistanceField::signDistances() {
  Sampler sampler(*this);
  for (int z = 0; z < size_[2]; ++z)
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x) {
        const float f = sampler.fine(openvdb::Vec3s((nodePosition(x, y, z) - fineOrigin_) / voxelSize_));
        float& d = distance_[index(x, y, z)];
        d = std::abs(f) < 1.8 * voxelSize_ ? f : std::copysign(d, f);
      }
}

float DistanceField::coarseAt(const openvdb::Vec3s& q) const {
  float outside2 = 0;
  int base[3];
  float w[3];
  for (int a = 0; a < 3; ++a) {
    const float c = std::min(std::max(q[a], 0.f), float(size_[a] - 1));
    outside2 += (q[a] - c) * (q[a] - c);
    base[a] = std::min(int(c), size_[a] - 2);
    w[a] = c - float(base[a]);
  }
  const float* v = &distance_[index(base[0], base[1], base[2])];
  const size_t dy = size_[0], dz = size_t(size_[0]) * size_[1];
  const auto row = [&](size_t o) { return v[o] + w[0] * (v[o + 1] - v[o]); };
  const float n0 = row(0), f0 = row(dz);
  const float near = n0 + w[1] * (row(dy) - n0);
  const float far = f0 + w[1] * (row(dz + dy) - f0);
  const float inside = near + w[2] * (far - near);
  return outside2 > 0 ? inside + std::sqrt(outside2) * float(spacing_) : inside;
}

Vec3d DistanceField::closest(const Vec3d& world) const {
  const Vec3d q = (world - origin_) / spacing_;
  int base[3];
  for (int a = 0; a < 3; ++a) base[a] = std::min(int(clampTo(q[a], 0.0, size_[a] - 1.0)), size_[a] - 2);
  Vec3d best;
  double bestDistance = std::numeric_limits<double>::max();
  for (int dz = 0; dz < 2; ++dz)
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const Vec3d p(closest_[index(base[0] + dx, base[1] + dy, base[2] + dz)]);
        const double d = (world - p).lengthSqr();
        if (d < bestDistance) bestDistance = d, best = p;
      }
  return best;
}

Vec3d DistanceField::gradient(const Vec3d& world) const {
  Vec3d g;
  for (int a = 0; a < 3; ++a) {
    Vec3d step(0.0);
    step[a] = 0.5 * spacing_;
    g[a] = coarse(world + step) - coarse(world - step);
  }
  const double length = g.length();
  return length > 0 ? g / length : Vec3d(0, 0, 1);
}

DistanceField::Sampler::Affine::Affine(const Mat3d& linear, const Vec3d& origin) {
  for (int i = 0; i < 9; ++i) m[i] = float(linear(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) o[i] = float(origin[i]);
}

DistanceField::Sampler::Sampler(const DistanceField& field, const Mat3d& linear, const Vec3d& origin)
    : field_(&field),
      toCoarse_(linear * (1 / field.spacing_), (origin - field.origin_) / field.spacing_),
      toFine_(linear * (1 / field.voxelSize_), (origin - field.fineOrigin_) / field.voxelSize_),
      accessor_(field.levelSet_->tree()) {}

float DistanceField::Sampler::fine(const openvdb::Vec3s& p) {
  const openvdb::Coord c = openvdb::Coord::floor(p);
  const float wx = p[0] - float(c[0]), wy = p[1] - float(c[1]), wz = p[2] - float(c[2]);
  float v[8];
  const auto* leaf = accessor_.probeConstLeaf(c);
  if (leaf && (c[0] & 7) != 7 && (c[1] & 7) != 7 && (c[2] & 7) != 7) {
    const float* data = leaf->buffer().data() + openvdb::FloatTree::LeafNodeType::coordToOffset(c);
    v[0] = data[0], v[1] = data[1], v[2] = data[8], v[3] = data[9];
    v[4] = data[64], v[5] = data[65], v[6] = data[72], v[7] = data[73];
  } else {
    for (int i = 0; i < 8; ++i) v[i] = accessor_.getValue(c.offsetBy(i >> 2 & 1, i >> 1 & 1, i & 1));
  }
  const float a = v[0] + wz * (v[1] - v[0]), b = v[2] + wz * (v[3] - v[2]);
  const float d = v[4] + wz * (v[5] - v[4]), e = v[6] + wz * (v[7] - v[6]);
  const float near = a + wy * (b - a), far = d + wy * (e - d);
  return near + wx * (far - near);
}

float DistanceField::Sampler::operator()(const openvdb::Vec3s& p) {
  const float coarse = field_->coarseAt(toCoarse_(p));
  const float h = float(field_->voxelSize_);
  if (std::abs(coarse) > 4 * h + 0.2f * float(field_->spacing_)) return coarse;
  const float fine = this->fine(toFine_(p));
  const float depth = std::abs(fine) / h;
  if (depth < 1.8f) return fine;
  if (depth > 2.7f) return std::copysign(std::max(std::abs(coarse), 2.2f * h), fine);
  const float w = (depth - 1.8f) / 0.9f;
  return fine + w * w * (3 - 2 * w) * (std::copysign(std::max(std::abs(coarse), 1.6f * h), fine) - fine);
}

void DistanceField::sampleSurface(int count) {
  struct Bin {
    Vec3d position{0, 0, 0}, normal{0, 0, 0};
    double weight = 0;
  };
  size_t voxels = 0;
  visitSurfacePoints(*levelSet_, [&](const Vec3d&, const Vec3d&, double) { ++voxels; });
  const double h = voxelSize_;
  // The shell of voxels within 0.87 h of the surface is 1.74 voxels thick.
  const double area = double(voxels) * h * h / 1.74;
  // Never finer than the voxels: every bin holds some points.
  const double cell = std::max(std::sqrt(area / count) * 1.3, 1.5 * h);
  // Opposite sides of a thin part must not be averaged: a bin holds normals of one octant's main direction only.
  using Key = std::tuple<int, int, int, int>;
  std::map<Key, Bin> bins;
  const Vec3d origin = box_.min();
  visitSurfacePoints(*levelSet_, [&](const Vec3d& p, const Vec3d& n, double) {
    const Vec3d q = (p - origin) / cell;
    int side = 0;
    for (int a = 1; a < 3; ++a)
      if (std::abs(n[a]) > std::abs(n[side])) side = a;
    Bin& bin = bins[Key(int(std::floor(q[2])), int(std::floor(q[1])), int(std::floor(q[0])), 2 * side + (n[side] < 0))];
    bin.position += p, bin.normal += n, bin.weight += 1;
  });
  for (auto& [key, bin] : bins) {
    if (bin.normal.length() < 0.5 * bin.weight) continue;
    Vec3d p = bin.position / bin.weight;
    bin.normal.normalize();
    const Vec3d c = closest(p);
    if ((c - p).length() < cell) p = c;
    samples_.push_back({p, bin.normal, bin.weight * h * h / 1.74});
  }
}

}  // namespace slicemorph
