#include "engine/shapes.h"

#include "engine/frame/typical_order.h"
#include "engine/numerics/parallel_each.h"
#include "engine/volume/same_grid.h"
#include "engine/volume/small_components.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

namespace slicemorph {

namespace {

/// The shapes in another order: the new index i is the old by[i].
Shapes reordered(Shapes shapes, const std::vector<size_t>& by) {
  std::vector<size_t> number(by.size());
  for (size_t i = 0; i < by.size(); ++i) number[by[i]] = i;
  for (size_t& shape : shapes.shapeOf) shape = number[shape];
  const auto move = [&](auto& list) {
    auto old = std::exchange(list, {});
    for (size_t i : by)
      if (i < old.size()) list.push_back(old[i]);
  };
  move(shapes.levelSets), move(shapes.names), move(shapes.order), move(shapes.fields), move(shapes.pieces);
  return shapes;
}

Shapes distinctShapes(const std::vector<Object>& objects) {
  Shapes shapes;
  for (const Object& object : objects) {
    shapes.shapeOf.push_back(indexOfSame(shapes.levelSets, object.levelSet));
    if (shapes.shapeOf.back() == shapes.names.size()) shapes.names.push_back(object.name);
  }
  shapes.order.resize(shapes.levelSets.size());
  std::iota(shapes.order.begin(), shapes.order.end(), size_t(0));
  return shapes;
}

/// What is smaller, voxels along its longest side, has no inside to be matched: balls of 1.33 voxels fail, of 1.67 do
/// not.
constexpr double kLeastVoxels = 1.5;

std::string thinnerThan(const char* where, double voxel) {
  std::ostringstream why;
  why << "is thinner than a voxel " << where << ", at a voxel size of " << voxel
      << "; it needs smaller voxels (--voxel-size, --resolution)";
  return why.str();
}

/// Throws GeometryError for what is too small. Its size is that of the box of the voxels inside it, and twice the
/// depth of the deepest of them beyond that, which for a ball in one voxel is its diameter.
void checkSize(const FloatGrid& levelSet, const std::string& name) {
  openvdb::CoordBBox inside;
  double deepest = 0;
  for (auto value = levelSet.cbeginValueOn(); value; ++value) {
    if (!(*value < 0)) continue;
    inside.expand(value.getCoord());
    deepest = std::max(deepest, -double(*value));
  }
  if (inside.empty()) return;
  const double voxel = levelSet.voxelSize()[0];
  const double longest = (inside.dim()[int(inside.maxExtent())] - 1) * voxel + 2 * deepest;
  if (longest >= kLeastVoxels * voxel) return;
  std::ostringstream why;
  why << "is smaller than a voxel: " << longest << " along its longest side, at a voxel size of " << voxel
      << "; it needs a voxel size of at most " << longest / kLeastVoxels
      << ", or a --resolution, which holds for each object";
  throw GeometryError(name, why.str());
}

std::shared_ptr<const DistanceField> fieldOf(const FloatGrid::ConstPtr& levelSet, const std::string& name) {
  try {
    return std::make_shared<DistanceField>(levelSet);
  } catch (const GeometryError&) {  // no point of a surface was found
    throw GeometryError(name, thinnerThan("everywhere", levelSet->voxelSize()[0]));
  }
}

/// Throws GeometryError for what falls between the nodes on which shapes are measured, as a blade does that is thinner
/// than a voxel nearly everywhere.
void checkInside(const DistanceField& field, const std::string& name) {
  const Lattice& nodes = field.nodes();
  for (int z = 0; z < nodes.size[2]; ++z)
    for (int y = 0; y < nodes.size[1]; ++y)
      for (int x = 0; x < nodes.size[0]; ++x)
        if (field.nodeDistance(x, y, z) < 0) return;
  throw GeometryError(name, thinnerThan("nearly everywhere", field.voxelSize()));
}

Shapes withFields(Shapes shapes, const Shapes* before) {
  shapes.fields.resize(shapes.levelSets.size());
  shapes.pieces.resize(shapes.levelSets.size());
  parallelEach(shapes.fields.size(), [&](size_t k) {
    FloatGrid::ConstPtr& levelSet = shapes.levelSets[k];
    if (before && k < before->levelSets.size() && isSame(*before->levelSets[k], *levelSet)) {
      levelSet = before->levelSets[k];
      shapes.fields[k] = before->fields[k], shapes.pieces[k] = before->pieces[k];
      return;
    }
    checkSize(*levelSet, shapes.names[k]);
    shapes.fields[k] = fieldOf(levelSet, shapes.names[k]);
    checkInside(*shapes.fields[k], shapes.names[k]);
    shapes.pieces[k] = countPieces(*levelSet);
  });
  return shapes;
}

/// Fields of the inner surfaces; surfaces that only one shape has are left out, as they cannot be matched.
std::vector<Fields> innerFields(const std::vector<Object>& objects, const Shapes& shapes) {
  std::vector<Fields> inner;
  size_t count = 0;
  for (const Object& object : objects) count = std::max(count, object.inner.size());
  for (size_t n = 0; n < count; ++n) {
    std::vector<FloatGrid::ConstPtr> grids(shapes.levelSets.size());
    for (size_t k = 0; k < objects.size(); ++k)
      if (n < objects[k].inner.size() && objects[k].inner[n] && !objects[k].inner[n]->empty())
        grids[shapes.shapeOf[k]] = objects[k].inner[n];
    if (grids.size() - size_t(std::count(grids.begin(), grids.end(), nullptr)) < 2) continue;
    Fields surface(grids.size());
    parallelEach(surface.size(), [&](size_t k) {
      if (grids[k]) surface[k] = std::make_shared<DistanceField>(grids[k]);
    });
    inner.push_back(std::move(surface));
  }
  return inner;
}

/// A feature in terms of the shapes; of equal objects the first one's positions are used.
Feature ofShapes(const Feature& feature, const Shapes& shapes) {
  const size_t count = shapes.levelSets.size();
  Feature own{feature.name, feature.kind, {}, {}, {}};
  own.positions.resize(count), own.normals.resize(count), own.radii.resize(count);
  for (size_t k = shapes.shapeOf.size(); k-- > 0;) {
    const size_t shape = shapes.shapeOf[k];
    own.positions[shape] = feature.positions[k];
    if (feature.kind != Feature::Kind::kDisk) continue;
    own.normals[shape] = feature.normals[k], own.radii[shape] = feature.radii[k];
  }
  return own;
}

Region ofShapes(Region region, const Shapes& shapes) {
  region.object = shapes.shapeOf[region.object];
  region.weights = shapes.weightsFrom(region.weights);
  return region;
}

}  // namespace

Shapes measureShapes(const std::vector<Object>& objects, const MorphOptions& options, const Shapes* before) {
  Shapes shapes = distinctShapes(objects);
  if (before && before->order.size() == shapes.order.size())
    shapes = reordered(std::move(shapes), before->order);
  shapes = withFields(std::move(shapes), before);
  // With more than two objects the result must not depend on the order in which they were given: start from
  // the most typical one. A prescribed slicing axis, however, is the first object's; then the order is kept.
  if (!before && shapes.fields.size() > 2 && options.axis.length() == 0) {
    const std::vector<size_t> order = typicalOrder(shapes.fields);
    shapes = reordered(std::move(shapes), order);
  }
  shapes.inner = innerFields(objects, shapes);
  shapes.densities.resize(shapes.levelSets.size()), shapes.velocities.resize(shapes.levelSets.size());
  for (size_t k = objects.size(); k-- > 0;) {
    shapes.densities[shapes.shapeOf[k]] = objects[k].density;
    shapes.velocities[shapes.shapeOf[k]] = objects[k].velocity;
  }
  for (const Feature& feature : options.features) shapes.features.push_back(ofShapes(feature, shapes));
  for (const Region& region : options.regions) shapes.regions.push_back(ofShapes(region, shapes));
  return shapes;
}

Weights Shapes::weightsFrom(const Weights& ofObjects) const {
  if (ofObjects.size() != shapeOf.size())
    throw InputError(std::to_string(ofObjects.size()) + " weights were given for " +
                     std::to_string(shapeOf.size()) + " objects");
  double sum = 0;
  for (double w : ofObjects) {
    if (!(w >= kLeastWeight))
      throw InputError("weight " + std::to_string(w) + " is below " + std::to_string(kLeastWeight) +
                       "; weights are 0 or more");
    sum += w;
  }
  if (!(std::abs(sum - 1) <= 1e-6))
    throw InputError("the weights sum to " + std::to_string(sum) + "; they must sum to 1");
  Weights result(levelSets.size(), 0);
  for (size_t k = 0; k < ofObjects.size(); ++k) result[shapeOf[k]] += ofObjects[k] / sum;
  if (const std::optional<size_t> alone = aloneIn(result)) {
    result.assign(result.size(), 0);
    result[*alone] = 1;
  }
  return result;
}

std::optional<size_t> Shapes::aloneAt(const Weights& weights) const {
  const std::optional<size_t> alone = aloneIn(weights);
  for (const Region& region : regions)
    if (aloneIn(region.weights) != alone) return std::nullopt;
  return alone;
}

double Shapes::voxelSizeAt(const Weights& weights, double wanted) const {
  if (wanted > 0) return wanted;
  double size = 0;
  double least = 1e300;
  for (size_t k = 0; k < weights.size(); ++k) {
    const double own = levelSets[k]->voxelSize()[0];
    size += weights[k] * own, least = std::min(least, own);
  }
  return std::max(size, 0.5 * least);  // negative weights could make it zero or negative
}

int Shapes::piecesAt(const Weights& weights) const {
  int most = 1;
  for (size_t k = 0; k < weights.size(); ++k)
    if (weights[k] > 0) most = std::max(most, pieces[k]);
  return most;
}

}  // namespace slicemorph
