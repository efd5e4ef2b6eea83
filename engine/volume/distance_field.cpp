#include "engine/volume/distance_field.h"

#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace slicemorph {

namespace {

/// Calls visit(surface point, outward normal, distance) for each voxel next to the surface, with the voxel
/// projected onto it.
template <typename Visit>
void visitSurfacePoints(const FloatGrid& grid, const Visit& visit) {
  const double h = grid.voxelSize()[0];
  const auto& transform = grid.transform();
  auto accessor = grid.getConstAccessor();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      const float f = *it;
      if (std::abs(f) > 0.87 * h) continue;  // half the diagonal of a voxel: sqrt(3) / 2
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

/// std::floor without the call into the library that baseline x86-64 needs.
int floorOf(float v) {
  const int i = int(v);
  return i - (v < float(i));
}

double clampTo(double v, double low, double high) { return std::min(std::max(v, low), high); }

}  // namespace

SurfaceBin surfaceBin(const Vec3d& position, const Vec3d& normal, const Vec3d& origin, double cell) {
  int side = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(normal[a]) > std::abs(normal[side])) side = a;
  const openvdb::Coord c = openvdb::Coord::floor((position - origin) / cell);
  return {c[2], c[1], c[0], 2 * side + (normal[side] < 0)};
}

DistanceField::DistanceField(FloatGrid::ConstPtr levelSet, int nodes)
    : levelSet_(std::move(levelSet)), band_(*levelSet_) {
  voxelSize_ = levelSet_->voxelSize()[0];
  box_ = openvdb::BBoxd();
  visitSurfacePoints(*levelSet_, [&](const Vec3d& p, const Vec3d&, double) { box_.expand(p); });
  if (box_.empty()) throw GeometryError("the level set '" + levelSet_->getName() + "' has no surface");
  anchor_ = box_.getCenter();
  const Vec3d extent = box_.extents();
  const double longest = std::max({extent[0], extent[1], extent[2], 4 * voxelSize_});
  nodes_.spacing = std::max(voxelSize_, longest / nodes);
  constexpr int kMargin =
      6;  // coarse nodes around the box; beyond them coarseAt adds the distance to the outermost ones
  nodes_.origin = box_.min() - Vec3d(kMargin * nodes_.spacing);
  for (int a = 0; a < 3; ++a) nodes_.size[a] = int(std::ceil(extent[a] / nodes_.spacing)) + 2 * kMargin + 1;
  const size_t count = nodes_.count();
  distance_.assign(count, std::numeric_limits<float>::max());
  closest_.assign(count, openvdb::Vec3s(0.f));
  seedFromBand();
  sweep();
  signDistances();
  sampleSurface(8000);
}

void DistanceField::seedFromBand() {
  visitSurfacePoints(*levelSet_, [&](const Vec3d& p, const Vec3d&, double) {
    const Vec3d q = (p - nodes_.origin) / nodes_.spacing;
    const openvdb::Coord base = openvdb::Coord::floor(q);
    for (int dz = 0; dz < 2; ++dz)
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
          const int x = base[0] + dx, y = base[1] + dy, z = base[2] + dz;
          const float d = float((nodePosition(x, y, z) - p).length());
          const size_t i = nodes_.index(x, y, z);
          if (d < distance_[i]) distance_[i] = d, closest_[i] = openvdb::Vec3s(p);
        }
  });
}

/// Propagates closest points from neighbour to neighbour in eight sweeps, one per octant ([Dan80], in
/// Gauss-Seidel order).
void DistanceField::sweep() {
  for (int pass = 0; pass < 8; ++pass) {
    const int sx = pass & 1 ? -1 : 1, sy = pass & 2 ? -1 : 1, sz = pass & 4 ? -1 : 1;
    for (int k = 0; k < nodes_.size[2]; ++k) {
      const int z = sz > 0 ? k : nodes_.size[2] - 1 - k;
      for (int j = 0; j < nodes_.size[1]; ++j) {
        const int y = sy > 0 ? j : nodes_.size[1] - 1 - j;
        for (int i = 0; i < nodes_.size[0]; ++i) {
          const int x = sx > 0 ? i : nodes_.size[0] - 1 - i;
          const size_t here = nodes_.index(x, y, z);
          const openvdb::Vec3s p(nodePosition(x, y, z));
          const auto take = [&](size_t from) {
            if (distance_[from] == std::numeric_limits<float>::max()) return;
            const float d = (p - closest_[from]).length();
            if (d < distance_[here]) distance_[here] = d, closest_[here] = closest_[from];
          };
          if (i > 0) take(nodes_.index(x - sx, y, z));
          if (j > 0) take(nodes_.index(x, y - sy, z));
          if (k > 0) take(nodes_.index(x, y, z - sz));
        }
      }
    }
  }
}

/// The fine grid knows the sign everywhere; within 1.8 voxels of the surface its distance is used as well.
void DistanceField::signDistances() {
  const Vec3d first = levelSet_->transform().worldToIndex(nodes_.origin) - band_.origin().asVec3d();
  const double step = nodes_.spacing / voxelSize_;
  tbb::parallel_for(0, int(nodes_.size[2]), [&](int z) {
    auto accessor = levelSet_->getConstAccessor();
    for (int y = 0; y < nodes_.size[1]; ++y)
      for (int x = 0; x < nodes_.size[0]; ++x) {
        const Vec3d p = first + step * Vec3d(x, y, z);
        float f = band_(openvdb::Vec3s(p), std::numeric_limits<float>::max());
        if (f == std::numeric_limits<float>::max())
          f = accessor.getValue(band_.origin() + openvdb::Coord::floor(p));
        float& d = distance_[nodes_.index(x, y, z)];
        d = std::abs(f) < 1.8 * voxelSize_ ? f : std::copysign(d, f);
      }
  });
}

float DistanceField::coarseAt(const openvdb::Vec3s& q) const {
  float outside2 = 0;
  int base[3];
  float w[3];
  for (int a = 0; a < 3; ++a) {
    const float c = std::min(std::max(q[a], 0.f), float(nodes_.size[a] - 1));
    outside2 += (q[a] - c) * (q[a] - c);
    base[a] = std::min(int(c), nodes_.size[a] - 2);
    w[a] = c - float(base[a]);
  }
  const float* v = &distance_[nodes_.index(base[0], base[1], base[2])];
  const size_t dy = nodes_.size[0], dz = size_t(nodes_.size[0]) * nodes_.size[1];
  const auto row = [&](size_t o) { return v[o] + w[0] * (v[o + 1] - v[o]); };
  const float n0 = row(0), f0 = row(dz);
  const float near = n0 + w[1] * (row(dy) - n0);
  const float far = f0 + w[1] * (row(dz + dy) - f0);
  const float inside = near + w[2] * (far - near);
  return outside2 > 0 ? inside + std::sqrt(outside2) * float(nodes_.spacing) : inside;
}

Vec3d DistanceField::closest(const Vec3d& world) const {
  const Vec3d q = (world - nodes_.origin) / nodes_.spacing;
  int base[3];
  for (int a = 0; a < 3; ++a)
    base[a] = std::min(int(clampTo(q[a], 0.0, nodes_.size[a] - 1.0)), nodes_.size[a] - 2);
  Vec3d best;
  double bestDistance = std::numeric_limits<double>::max();
  for (int dz = 0; dz < 2; ++dz)
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const Vec3d p(closest_[nodes_.index(base[0] + dx, base[1] + dy, base[2] + dz)]);
        const double d = (world - p).lengthSqr();
        if (d < bestDistance) bestDistance = d, best = p;
      }
  return best;
}

Vec3d DistanceField::gradient(const Vec3d& world) const {
  Vec3d g;
  for (int a = 0; a < 3; ++a) {
    Vec3d step(0.0);
    step[a] = 0.5 * nodes_.spacing;
    g[a] = coarse(world + step) - coarse(world - step);
  }
  const double length = g.length();
  return length > 0 ? g / length : Vec3d(0, 0, 1);
}

inline const float* BandBlocks::cell(const openvdb::Vec3s& p, openvdb::Vec3s& between) const {
  const int x = floorOf(p[0]), y = floorOf(p[1]), z = floorOf(p[2]);
  const int i = x >> 3, j = y >> 3, k = z >> 3;
  if (i < 0 || j < 0 || k < 0 || i >= size_[0] || j >= size_[1] || k >= size_[2]) return nullptr;
  const int block = block_[(size_t(i) * size_[1] + j) * size_[2] + k];
  if (block < 0) return nullptr;
  between = {p[0] - float(x), p[1] - float(y), p[2] - float(z)};
  return &values_[size_t(block) * kBlock + size_t(((z & 7) * kSide + (y & 7)) * kSide + (x & 7))];
}

inline float BandBlocks::operator()(const openvdb::Vec3s& p, float unknown) const {
  openvdb::Vec3s w;
  const float* v = cell(p, w);
  if (!v) return unknown;
  constexpr int dx = 1, dy = kSide, dz = kSide * kSide;
  const float a = v[0] + w[2] * (v[dz] - v[0]), b = v[dy] + w[2] * (v[dy + dz] - v[dy]);
  const float c = v[dx] + w[2] * (v[dx + dz] - v[dx]), d = v[dx + dy] + w[2] * (v[dx + dy + dz] - v[dx + dy]);
  const float near = a + w[1] * (b - a), far = c + w[1] * (d - c);
  return near + w[0] * (far - near);
}

inline openvdb::Vec3s BandBlocks::gradient(const openvdb::Vec3s& p) const {
  openvdb::Vec3s w;
  const float* v = cell(p, w);
  if (!v) return openvdb::Vec3s(0.f);
  constexpr int dx = 1, dy = kSide, dz = kSide * kSide;
  const float za = v[dz] - v[0], zb = v[dy + dz] - v[dy];
  const float zc = v[dx + dz] - v[dx], zd = v[dx + dy + dz] - v[dx + dy];
  const float a = v[0] + w[2] * za, b = v[dy] + w[2] * zb, c = v[dx] + w[2] * zc, d = v[dx + dy] + w[2] * zd;
  const auto between = [](float low, float high, float f) { return low + f * (high - low); };
  return {between(c, d, w[1]) - between(a, b, w[1]), between(b - a, d - c, w[0]),
          between(between(za, zb, w[1]), between(zc, zd, w[1]), w[0])};
}

DistanceField::Sampler::Sampler(const DistanceField& field)
    : field_(&field),
      voxelSize_(float(field.voxelSize_)),
      coarseScale_(float(1 / field.nodes_.spacing)),
      fineScale_(float(1 / field.voxelSize_)),
      coarseOrigin_((field.anchor_ - field.nodes_.origin) / field.nodes_.spacing),
      fineOrigin_(field.levelSet_->transform().worldToIndex(field.anchor_) - field.band_.origin().asVec3d()) {
}

/// Fine values are used up to 1.8 voxels and fade into the coarse distance until 2.7 voxels, before they are
/// clamped at 3. There the coarse distance is kept from falling below nearby fine values.
float DistanceField::Sampler::operator()(const openvdb::Vec3s& p) const {
  const float h = voxelSize_, beyond = std::numeric_limits<float>::max();
  const float fine = field_->band_(p * fineScale_ + fineOrigin_, beyond);
  const float depth = std::abs(fine) / h;
  if (depth < 1.8f) return fine;
  const float coarse = this->coarse(p);
  if (fine == beyond) return coarse;
  if (depth > 2.7f) return std::copysign(std::max(std::abs(coarse), 2.2f * h), fine);
  const float w = (depth - 1.8f) / 0.9f;
  return fine + w * w * (3 - 2 * w) * (std::copysign(std::max(std::abs(coarse), 1.6f * h), fine) - fine);
}

openvdb::Vec3s DistanceField::Sampler::gradient(const openvdb::Vec3s& p) const {
  const openvdb::Vec3s at = p * fineScale_ + fineOrigin_;
  openvdb::Vec3s g(0.f);
  if (std::abs(field_->band_(at, std::numeric_limits<float>::max())) < 1.8f * voxelSize_)
    g = field_->band_.gradient(at);
  const float length = g.length();
  return length > 0 ? g / length : openvdb::Vec3s(field_->gradient(field_->anchor_ + Vec3d(p)));
}

BandBlocks::BandBlocks(const FloatGrid& levelSet) {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  std::vector<const Leaf*> leaves;
  levelSet.tree().getNodes(leaves);
  openvdb::CoordBBox box;
  for (const Leaf* leaf : leaves) box.expand(leaf->origin());
  if (leaves.empty()) return;
  origin_ = box.min();
  for (int a = 0; a < 3; ++a) size_[a] = (box.max()[a] - box.min()[a]) / int(Leaf::DIM) + 1;
  block_.assign(size_t(size_[0]) * size_[1] * size_[2], -1);
  values_.resize(leaves.size() * kBlock);
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, leaves.size()), [&](const tbb::blocked_range<size_t>& range) {
        auto accessor = levelSet.getConstAccessor();
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const openvdb::Coord at = leaves[i]->origin(), cell = at - origin_;
          block_[(size_t(cell[0] >> 3) * size_[1] + (cell[1] >> 3)) * size_[2] + (cell[2] >> 3)] = int(i);
          const float* own = leaves[i]->buffer().data();
          float* v = &values_[i * kBlock];
          for (int z = 0; z < kSide; ++z)
            for (int y = 0; y < kSide; ++y)
              for (int x = 0; x < kSide; ++x)
                *v++ = x < 8 && y < 8 && z < 8 ? own[(x * 8 + y) * 8 + z]
                                               : accessor.getValue(at.offsetBy(x, y, z));
        }
      });
}

void DistanceField::sampleSurface(int count) {
  struct Bin {
    Vec3d position{0, 0, 0}, normal{0, 0, 0};
    double weight = 0;
  };
  size_t voxels = 0;
  visitSurfacePoints(*levelSet_, [&](const Vec3d&, const Vec3d&, double) { ++voxels; });
  const double h = voxelSize_;
  // Voxels within 0.87 h of the surface form a shell 1.74 voxels thick.
  const double area = double(voxels) * h * h / 1.74;
  // Not finer than the voxels, so that every bin holds some points.
  const double cell = std::max(std::sqrt(area / count) * 1.3, 1.5 * h);
  std::map<SurfaceBin, Bin> bins;
  const Vec3d origin = box_.min();
  visitSurfacePoints(*levelSet_, [&](const Vec3d& p, const Vec3d& n, double) {
    Bin& bin = bins[surfaceBin(p, n, origin, cell)];
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
