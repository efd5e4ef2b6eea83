#include "engine/volume/winding_solid.h"

#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace slicemorph {
namespace {

using openvdb::Coord;
using BandLeaf = FloatGrid::TreeType::LeafNodeType;
using BandLeaves = openvdb::tree::LeafManager<FloatGrid::TreeType>;

constexpr double kInside = 0.5;
/// How far from 1/2 a winding number must be to hold for others with no triangle in between: that is so inside and
/// outside of what is closed, and beside the edge of a half plane nowhere nearby, where it falls from 1/2 to -1/2
/// around the edge.
constexpr float kSure = 0.4f;
/// Voxels between those at which winding numbers are taken first; they are at most kHalfWidth from the surface.
constexpr int kFirstStep = 4;
/// More voxels in holes than this come from a mesh that is hardly there.
constexpr size_t kMostHoleVoxels = 200'000'000;
/// Where two measures of the distance to the surface differ by less, voxels, they mean the same piece of it.
constexpr float kSamePiece = 0.5f;

const Coord kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// The unsigned distance to the triangles and the winding number at the same voxels, to which those in holes are added.
struct WoundBand {
  FloatGrid::Ptr distance, winding;
  float voxel;  ///< world units

  Vec3d world(const Coord& c) const { return distance->indexToWorld(c); }
};

/// Reads both, for one task.
struct BandReader {
  explicit BandReader(const WoundBand& band)
      : winding(band.winding->getConstAccessor()),
        distance(band.distance->getConstAccessor()),
        voxel(band.voxel) {}

  FloatGrid::ConstAccessor winding, distance;
  float voxel;
};

/// Whether no triangle can lie between two voxels: each point between them is nearer to one than a triangle is.
bool nothingBetween(float distanceA, float distanceB, float apart) {
  return distanceA + distanceB > apart * 1.0001f;
}

bool isInside(float winding) { return winding > float(kInside); }

/// The finest lattice of steps kFirstStep, ..., 2, 1 that a voxel is on.
int stepOf(const Coord& c) {
  const int bits = c.x() | c.y() | c.z() | kFirstStep;
  return bits & -bits;
}

/// Marks voxels whose winding number is not known yet.
constexpr float kNotWound = std::numeric_limits<float>::infinity();

/// The winding number that a voxel takes over from others; gathers them one by one.
struct Takeover {
  std::optional<float> common;
  bool possible = true;

  void see(float other) {
    if (other == kNotWound) return;
    if (std::abs(other - float(kInside)) < kSure || (common && isInside(*common) != isInside(other)))
      possible = false;
    common = other;
  }
  std::optional<float> value() const { return possible ? common : std::nullopt; }
};

/// From the corners of the cell of the next coarser lattice that a voxel is on.
std::optional<float> fromCoarserLattice(const BandReader& band, const Coord& c, int step) {
  const float own = band.distance.getValue(c);
  Takeover takeover;
  for (int corner = 0; corner < 8; ++corner) {
    Coord other = c;
    int odd = 0;
    bool twice = false;
    for (int axis = 0; axis < 3; ++axis) {
      const bool up = corner >> axis & 1;
      if (c[axis] & step)
        other[axis] += up ? step : -step, ++odd;
      else
        twice = twice || up;
    }
    if (twice || !band.winding.isValueOn(other)) continue;
    if (nothingBetween(own, band.distance.getValue(other), float(step) * std::sqrt(float(odd)) * band.voxel))
      takeover.see(band.winding.getValue(other));
  }
  return takeover.value();
}

/// From the 26 neighbours.
std::optional<float> fromNeighbours(const BandReader& band, const Coord& c) {
  const float own = band.distance.getValue(c);
  Takeover takeover;
  for (auto other = openvdb::CoordBBox(c.offsetBy(-1), c.offsetBy(1)).begin(); other; ++other) {
    const float apart = float((*other - c).asVec3d().length()) * band.voxel;
    if (band.winding.isValueOn(*other) && nothingBetween(own, band.distance.getValue(*other), apart))
      takeover.see(band.winding.getValue(*other));
  }
  return takeover.value();
}

/// Lets voxels take winding numbers over from neighbours that had one before.
void spread(WoundBand& band, BandLeaves& leaves) {
  std::vector<std::vector<std::pair<openvdb::Index, float>>> found(leaves.leafCount());
  leaves.foreach ([&](BandLeaf& leaf, size_t i) {
    const BandReader reader(band);
    for (auto value = leaf.cbeginValueOn(); value; ++value)
      if (*value == kNotWound)
        if (const std::optional<float> w = fromNeighbours(reader, value.getCoord()))
          found[i].emplace_back(value.pos(), *w);
  });
  leaves.foreach ([&](BandLeaf& leaf, size_t i) {
    for (const auto& [position, w] : found[i]) leaf.setValueOnly(position, w);
  });
}

/// Sets `winding` on the band. It is summed up at few voxels: from lattices that get finer, and then from neighbours,
/// the others take over what cannot change on the way.
void windBand(WoundBand& band, const WindingNumber& winding) {
  BandLeaves leaves(band.winding->tree());
  leaves.foreach ([&](BandLeaf& leaf, size_t) {
    for (auto value = leaf.beginValueOn(); value; ++value) value.setValue(kNotWound);
  });
  for (int step = kFirstStep; step > 0; step /= 2)
    leaves.foreach ([&](BandLeaf& leaf, size_t) {
      const BandReader reader(band);
      for (auto value = leaf.beginValueOn(); value; ++value) {
        const Coord c = value.getCoord();
        if (stepOf(c) != step) continue;
        const std::optional<float> near =
            step < kFirstStep ? fromCoarserLattice(reader, c, step) : std::nullopt;
        if (near || step > 1) value.setValue(near ? *near : float(winding.at(band.world(c))));
      }
    });
  for (int round = 0; round < 2; ++round) spread(band, leaves);
  leaves.foreach ([&](BandLeaf& leaf, size_t) {
    for (auto value = leaf.beginValueOn(); value; ++value)
      if (*value == kNotWound) value.setValue(float(winding.at(band.world(value.getCoord()))));
  });
}

/// Whether the surface passes between two neighbours where no triangle is.
bool passesInHole(float windingA, float distanceA, float windingB, float distanceB, float voxel) {
  return isInside(windingA) != isInside(windingB) && nothingBetween(distanceA, distanceB, voxel);
}

void sortUnique(std::vector<Coord>& coords) {
  std::sort(coords.begin(), coords.end());
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
}

/// Those of `candidates` and their neighbours between which the surface passes in a hole.
std::vector<Coord> atHole(const WoundBand& band, const std::vector<Coord>& candidates) {
  const FloatGrid::ConstAccessor winding = band.winding->getConstAccessor(),
                                 distance = band.distance->getConstAccessor();
  std::vector<Coord> found;
  for (const Coord& c : candidates) {
    for (int side = 0; side < 6; ++side) {
      const Coord next = side < 3 ? c + kAxes[side] : c - kAxes[side - 3];
      if (!winding.isValueOn(next)) continue;
      if (!passesInHole(winding.getValue(c), distance.getValue(c), winding.getValue(next),
                        distance.getValue(next), band.voxel))
        continue;
      found.push_back(c);
      found.push_back(next);
    }
  }
  sortUnique(found);
  return found;
}

/// Voxels of the band at holes that may have neighbours outside of it.
std::vector<Coord> firstAtHoles(const WoundBand& band) {
  BandLeaves leaves(band.winding->tree());
  std::vector<std::vector<Coord>> found(leaves.leafCount());
  leaves.foreach ([&](BandLeaf& leaf, size_t i) {
    const FloatGrid::ConstAccessor distance = band.distance->getConstAccessor();
    std::vector<Coord> outer;
    for (auto value = leaf.cbeginValueOn(); value; ++value)
      if (distance.getValue(value.getCoord()) > band.voxel) outer.push_back(value.getCoord());
    found[i] = atHole(band, outer);
  });
  std::vector<Coord> all;
  for (const std::vector<Coord>& part : found) all.insert(all.end(), part.begin(), part.end());
  sortUnique(all);
  return all;
}

/// The neighbours (26) of some voxels whose winding number is not known.
std::vector<Coord> unknownAround(const WoundBand& band, const std::vector<Coord>& coords) {
  const FloatGrid::ConstAccessor winding = band.winding->getConstAccessor();
  std::vector<Coord> unknown;
  for (const Coord& c : coords)
    for (auto next = openvdb::CoordBBox(c.offsetBy(-1), c.offsetBy(1)).begin(); next; ++next)
      if (!winding.isValueOn(*next)) unknown.push_back(*next);
  sortUnique(unknown);
  return unknown;
}

/// Follows the surface from the band across holes, wave after wave. Every piece of it where no triangle is begins
/// beside one, for away from them the winding number is harmonic and has no closed surfaces of equal value.
void followAcrossHoles(WoundBand& band, const WindingNumber& winding) {
  std::vector<Coord> front = firstAtHoles(band);
  size_t added = 0;
  for (std::vector<Coord> unknown = unknownAround(band, front); !unknown.empty();
       unknown = unknownAround(band, front)) {
    std::vector<float> values(unknown.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, unknown.size(), 64),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i)
                          values[i] = float(winding.at(band.world(unknown[i])));
                      });
    FloatGrid::Accessor writer = band.winding->getAccessor();
    for (size_t i = 0; i < unknown.size(); ++i) writer.setValue(unknown[i], values[i]);
    added += unknown.size();
    if (added > kMostHoleVoxels)
      throw InputError("the mesh's holes take more than 2e8 voxels; use a larger voxel size");
    front = atHole(band, unknown);
  }
}

/// Distance from a voxel to where the surface passes in a hole beside it: of the plane through its crossings along the
/// axes.
float distanceInHole(const BandReader& band, const Coord& c) {
  const float w = band.winding.getValue(c), d = band.distance.getValue(c);
  double inverse = 0;
  for (const Coord& axis : kAxes) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Coord& next : {c + axis, c - axis}) {
      if (!band.winding.isValueOn(next)) continue;
      const float other = band.winding.getValue(next);
      if (!passesInHole(w, d, other, band.distance.getValue(next), band.voxel)) continue;
      nearest = std::min(nearest, (double(w) - kInside) / (double(w) - other) * band.voxel);
    }
    inverse += 1 / std::max(nearest * nearest, 1e-12 * band.voxel * band.voxel);
  }
  return inverse > 0 ? float(1 / std::sqrt(inverse)) : std::numeric_limits<float>::max();
}

/// The band with a sign: exact beside triangles that part inside from outside, else only right about where the surface
/// is.
FloatGrid::Ptr signedBand(const WoundBand& band) {
  FloatGrid::Ptr field = band.winding->deepCopy();
  field->setGridClass(openvdb::GRID_LEVEL_SET);
  const float background = float(kHalfWidth) * band.voxel;
  BandLeaves(field->tree()).foreach ([&](BandLeaf& leaf, size_t) {
    const BandReader reader(band);
    for (auto value = leaf.beginValueOn(); value; ++value) {
      const Coord c = value.getCoord();
      const float d = std::min(reader.distance.getValue(c), distanceInHole(reader, c));
      const float size = std::clamp(d, 1e-4f * band.voxel, background);
      value.setValue(isInside(reader.winding.getValue(c)) ? -size : size);
    }
  });
  openvdb::tools::changeBackground(field->tree(), background);
  openvdb::tools::signedFloodFill(field->tree());
  return field;
}

/// Distances to the surface of a signed band, with its signs; where the nearest piece is one of triangles, those to
/// them.
FloatGrid::Ptr measuredAgain(const WoundBand& band, const FloatGrid& signs) {
  const Mesh surface = surfaceOf(signs);
  FloatGrid::Ptr result = unsignedDistance(surface, band.voxel);
  BandLeaves(result->tree()).foreach ([&](BandLeaf& leaf, size_t) {
    const FloatGrid::ConstAccessor sign = signs.getConstAccessor(),
                                   distance = band.distance->getConstAccessor();
    for (auto value = leaf.beginValueOn(); value; ++value) {
      const Coord c = value.getCoord();
      float own;
      const bool known = distance.probeValue(c, own);
      const float d = known && std::abs(own - *value) <= kSamePiece * band.voxel ? own : *value;
      value.setValue(sign.getValue(c) < 0 ? -d : d);
    }
  });
  openvdb::tools::signedFloodFill(result->tree());
  return result;
}

}  // namespace

FloatGrid::Ptr windingLevelSet(const Mesh& mesh, const WindingNumber& winding, double voxelSize) {
  WoundBand band{unsignedDistance(mesh, voxelSize), nullptr, float(voxelSize)};
  band.winding = band.distance->deepCopy();
  windBand(band, winding);
  followAcrossHoles(band, winding);
  const FloatGrid::Ptr signs = signedBand(band);
  requireInside(*signs);
  const FloatGrid::Ptr result = measuredAgain(band, *signs);
  requireInside(*result);
  result->setGridClass(openvdb::GRID_LEVEL_SET);
  return result;
}

}  // namespace slicemorph
