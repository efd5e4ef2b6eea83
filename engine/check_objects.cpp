#include "engine/check_objects.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace slicemorph {

namespace {

/// Relative to a voxel. Generous: transforms stored in single precision are off by a few 1e-7.
constexpr double kVoxelTolerance = 1e-4;
/// Of the half width, in voxels. Generous: the background is in single precision.
constexpr double kBandTolerance = 0.01;

std::string listed(const Vec3d& v) {
  std::ostringstream text;
  text << v[0] << ", " << v[1] << ", " << v[2];
  return text.str();
}

void checkRange(const char* name, int value, int low, int high) {
  if (value < low || value > high)
    throw InputError(std::string(name) + " is " + std::to_string(value) + "; it must be from " +
                     std::to_string(low) + " to " + std::to_string(high));
}

void checkDirection(const char* name, const Vec3d& direction) {
  if (!std::isfinite(direction.lengthSqr()))
    throw InputError(std::string(name) + " is (" + listed(direction) + "); its numbers must be finite");
}

void checkFeature(const Feature& feature, size_t objects) {
  const bool disk = feature.kind == Feature::Kind::kDisk;
  const auto count = [&](const char* what, size_t given) {
    if (given != objects)
      throw InputError("feature '" + feature.name + "' has " + what + " for " + std::to_string(given) +
                       " objects; there are " + std::to_string(objects));
  };
  count("places", feature.positions.size());
  if (disk) count("normals", feature.normals.size()), count("radii", feature.radii.size());
  const size_t least = feature.kind == Feature::Kind::kLine ? 2 : 1;
  for (const auto& positions : feature.positions)
    if (positions.size() < least)
      throw InputError("feature '" + feature.name + "' has " + std::to_string(positions.size()) +
                       " places on an object; it needs " + std::to_string(least));
  for (const auto& positions : feature.positions)
    for (const Vec3d& p : positions)
      if (!std::isfinite(p.lengthSqr()))
        throw InputError("feature '" + feature.name + "' has a place that is not finite");
  for (size_t k = 0; disk && k < objects; ++k)
    if (!(feature.radii[k] > 0) || !(feature.normals[k].length() > 0))
      throw InputError("feature '" + feature.name + "': a disk's radius and normal must not be 0");
}

void checkRegion(const Region& region, size_t objects) {
  if (region.object >= objects)
    throw InputError("region '" + region.name + "' is drawn on object " + std::to_string(region.object + 1) +
                     "; there are " + std::to_string(objects));
  if (region.weights.size() != objects)
    throw InputError("region '" + region.name + "' has " + std::to_string(region.weights.size()) +
                     " weights for " + std::to_string(objects) + " objects");
  const Vec3d box = region.box.extents();
  if ((region.kind == Region::Kind::kSphere && !(region.radius > 0)) ||
      (region.kind == Region::Kind::kBox && !(box[0] > 0 && box[1] > 0 && box[2] > 0)) ||
      (region.kind == Region::Kind::kSpine && !(region.from < region.to)) || !(region.border >= 0))
    throw InputError("region '" + region.name + "' has no extent, or a border below 0");
}

void checkVoxels(const FloatGrid& grid, const std::string& name) {
  const openvdb::math::Transform& transform = grid.transform();
  if (!transform.isLinear()) throw GeometryError("'" + name + "' is on a frustum; its voxels must be cubes");
  const Vec3d size = grid.voxelSize();
  if (!(std::abs(size[1] - size[0]) <= kVoxelTolerance * size[0]) ||
      !(std::abs(size[2] - size[0]) <= kVoxelTolerance * size[0]))
    throw GeometryError("'" + name + "' has voxels of " + listed(size) +
                        "; they must be as large along all axes");
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d unit(0.0);
    unit[axis] = 1;
    const Vec3d step = transform.indexToWorld(unit) - transform.indexToWorld(Vec3d(0.0));
    if (!((step - size[0] * unit).length() <= kVoxelTolerance * size[0]))
      throw GeometryError("'" + name + "' has voxels whose " + "xyz"[axis] + " axis points along (" +
                          listed(step.unit()) + "); it must be the world's");
  }
}

void checkBand(const FloatGrid& grid, const std::string& name) {
  std::ostringstream text;
  const double halfWidth = double(grid.background()) / grid.voxelSize()[0];
  if (!(std::abs(halfWidth - kHalfWidth) <= kBandTolerance)) {
    text << "'" << name << "' has a narrow band of half width " << halfWidth << " voxels; it must be "
         << kHalfWidth;
    throw GeometryError(text.str());
  }
  for (auto value = grid.cbeginValueOn(); value; ++value)
    if (!std::isfinite(*value)) {
      text << "'" << name << "' has the value " << *value << " at voxel " << value.getCoord()
           << "; distances must be finite";
      throw GeometryError(text.str());
    }
}

}  // namespace

void checkLevelSet(const FloatGrid& grid, const std::string& name) {
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET)
    throw GeometryError("'" + name + "' is of the class '" +
                        openvdb::GridBase::gridClassToMenuName(grid.getGridClass()) +
                        "'; it must be a level set");
  checkVoxels(grid, name);
  checkBand(grid, name);
}

void checkObjects(const std::vector<Object>& objects, const MorphOptions& options) {
  if (objects.empty()) throw InputError("a morph needs at least one object");
  for (const Object& o : objects) {
    if (!o.levelSet || o.levelSet->empty()) throw GeometryError("'" + o.name + "' is empty");
    checkLevelSet(*o.levelSet, o.name);
    for (size_t n = 0; n < o.inner.size(); ++n)
      if (o.inner[n] && !o.inner[n]->empty())
        checkLevelSet(*o.inner[n],
                      o.name + "', inner surface " + std::to_string(n + 1) + " '" + o.inner[n]->getName());
  }
  checkRange("slices", options.slices, 8, 1024);
  checkRange("samples", options.samples, 16, 4096);
  checkDirection("axis", options.axis);
  checkDirection("up", options.up);
  for (const Feature& feature : options.features) checkFeature(feature, objects.size());
  for (const Region& region : options.regions) checkRegion(region, objects.size());
  if (options.voxelSize < 0 || !std::isfinite(options.voxelSize))
    throw InputError("voxel size is " + std::to_string(options.voxelSize) + "; it must be positive");
}

void checkRegions(const std::vector<Region>& regions, const RegionShares& shares, const Fields& fields,
                  const std::vector<std::string>& names) {
  for (size_t r = 0; r < regions.size(); ++r) {
    const size_t k = regions[r].object;
    if (shares.holdsAnything(r, *fields[k])) continue;
    const openvdb::BBoxd& box = fields[k]->box();
    throw InputError("region '" + regions[r].name + "' holds nothing of '" + names[k] +
                     "', on which it is drawn; that lies between (" + listed(box.min()) + ") and (" +
                     listed(box.max()) + ")");
  }
}

}  // namespace slicemorph
