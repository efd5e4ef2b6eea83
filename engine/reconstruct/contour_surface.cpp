#include "engine/reconstruct/contour_surface.h"

#include "engine/numerics/lattice_cell.h"
#include "engine/numerics/readable.h"
#include "engine/reconstruct/lattice_level_set.h"
#include "engine/reconstruct/meet_contours.h"
#include "engine/reconstruct/plane_set.h"
#include "engine/reconstruct/plate_surface.h"
#include "engine/reconstruct/specks.h"
#include "engine/reconstruct/stray_pieces.h"
#include "engine/volume/manifold.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

constexpr double kMostNodes = 1.2e8;  ///< of the finest lattice: about a gigabyte with its images

double defaultVoxelSize(const PlaneSet& planes, double mostNodes) {
  const Sampling s = samplingOf(planes);
  double h = std::min({0.6 * s.edge, s.gap / 3.3, s.extent / 32});
  h = std::max(h, s.extent / 500);
  const openvdb::Vec3d size = planes.box.extents() + Vec3d(4 * planes.gap);
  return std::max(h, std::cbrt(size[0] * size[1] * size[2] / mostNodes));
}

void requireSize(const ContourSet& set, const PlaneSet& planes, double h) {
  if (!(h > 0) || !std::isfinite(h))
    throw InputError("voxel size " + std::to_string(h) + " is no positive number of world units");
  const openvdb::Vec3d size = planes.box.extents() + Vec3d(4 * planes.gap);
  const double nodes = size[0] * size[1] * size[2] / (h * h * h);
  if (nodes > kMostNodes)
    throw InputError(set.name + ": voxel size " + std::to_string(h) + " would make a lattice of " +
                     readableCount(nodes) + " nodes; at least " +
                     std::to_string(h * std::cbrt(nodes / kMostNodes)) + " is possible");
}

/// Largest distance of a contour point to the surface, to first order: value over gradient.
double farthestContour(const PlaneSet& planes, const Lattice& lattice, const std::vector<float>& values) {
  double farthest = 0;
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges) {
      const CellPoint point = cellPoint(lattice, planes.world(int(i), e.a));
      const double steepness = std::max(gradientAt(lattice, values, point).length(), 0.1);
      farthest = std::max(farthest, std::abs(valueAt(lattice, values, point)) / steepness);
    }
  return farthest;
}

}  // namespace

double contourVoxelSize(const ContourSet& set) {
  Notes notes;
  return defaultVoxelSize(cleanPlanes(set, notes), ContourSurfaceOptions().mostNodes);
}

ContourSurface contourSurface(const ContourSet& set, const ContourSurfaceOptions& options,
                              Progress* progress) {
  ContourSurface out;
  PlaneSet planes = cleanPlanes(set, out.notes, options.bridgedGaps);
  out.voxelSize = options.voxelSize != 0 ? options.voxelSize : defaultVoxelSize(planes, options.mostNodes);
  out.gap = planes.gap;
  requireSize(set, planes, out.voxelSize);
  makeImages(planes, out.voxelSize);
  PlateSurface surface = plateSurface(planes, out.voxelSize, progress);
  const Lattice& lattice = surface.lattice;
  WithoutStrays kept = dropStrayPieces(planes, lattice, std::move(surface.values));
  if (kept.strays > 0)
    out.notes.push_back({"contours.pieces-left-out", Severity::kNote, "",
                         std::to_string(kept.strays) + " pieces that no contour touches left out"});
  out.farthestContour = farthestContour(planes, lattice, kept.values);
  out.grid = latticeLevelSet(lattice, std::move(kept.values));
  return out;
}

Mesh contourMesh(const ContourSet& set, const ContourSurface& surface) {
  const Mesh whole = makeManifold(surfaceOf(*surface.grid)).mesh;
  Mesh mesh = withoutSpecks(whole, set, surface.voxelSize);
  meetContours(set, surface.voxelSize, mesh);
  return mesh;
}

}  // namespace slicemorph
