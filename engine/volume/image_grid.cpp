#include "engine/volume/image_grid.h"

#include "engine/volume/leaf.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

namespace slicemorph {
namespace {

using openvdb::GridBase;

const char* const kTypeNames[] = {"uint8", "int16", "uint16", "int32", "float", "double"};

/// The most frequent value on the image's faces across j and k, which mostly is what surrounds the object.
template <typename T>
T commonest(const ImageLattice& lattice, const std::vector<T>& values) {
  std::map<T, size_t> counts;
  const auto add = [&](int i, int j, int k) { ++counts[values[lattice.index(i, j, k)]]; };
  const openvdb::Coord n = lattice.size;
  for (int k : {0, n[2] - 1})
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) add(i, j, k);
  for (int k = 0; k < n[2]; ++k)
    for (int j : {0, n[1] - 1})
      for (int i = 0; i < n[0]; ++i) add(i, j, k);
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

template <typename GridType, typename T>
GridBase::Ptr filled(const ImageLattice& lattice, const std::vector<T>& values) {
  using V = typename GridType::ValueType;
  using Leaf = typename GridType::TreeType::LeafNodeType;
  const V background = V(commonest(lattice, values));
  auto grid = GridType::create(background);
  const openvdb::Coord n = lattice.size, blocks = (n + openvdb::Coord(kLeaf - 1)) >> Leaf::LOG2DIM;
  std::vector<std::unique_ptr<Leaf>> row(size_t(blocks[0]) * blocks[1]);
  for (int bk = 0; bk < blocks[2]; ++bk) {
    tbb::parallel_for(size_t(0), row.size(), [&](size_t b) {
      const openvdb::Coord origin(int(b % size_t(blocks[0])) * kLeaf, int(b / size_t(blocks[0])) * kLeaf,
                                  bk * kLeaf);
      auto leaf = std::make_unique<Leaf>(origin, background);
      const openvdb::Coord end = openvdb::Coord::minComponent(origin + openvdb::Coord(kLeaf), n);
      for (int k = origin[2]; k < end[2]; ++k)
        for (int j = origin[1]; j < end[1]; ++j)
          for (int i = origin[0]; i < end[0]; ++i) {
            const V value = V(values[lattice.index(i, j, k)]);
            if (value != background) leaf->setValueOn(Leaf::coordToOffset({i, j, k}), value);
          }
      if (!leaf->isEmpty()) row[b] = std::move(leaf);
    });
    for (auto& leaf : row)
      if (leaf) grid->tree().addLeaf(leaf.release());
  }
  return grid;
}

template <typename T>
bool fill(const GridBase& grid, const ImageLattice& lattice, const openvdb::Coord& first,
          std::vector<T>& values) {
  using Types = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                  openvdb::BoolGrid>;
  values.resize(lattice.count());
  return grid.apply<Types>([&](const auto& typed) {
    tbb::parallel_for(0, lattice.size[2], [&](int k) {
      const auto accessor = typed.getConstAccessor();
      size_t at = lattice.index(0, 0, k);
      for (int j = 0; j < lattice.size[1]; ++j)
        for (int i = 0; i < lattice.size[0]; ++i)
          values[at++] = T(accessor.getValue(first + openvdb::Coord(i, j, k)));
    });
  });
}

ImageValues valuesOfType(const std::string& type) {
  if (type == "uint8") return std::vector<std::uint8_t>();
  if (type == "int16") return std::vector<std::int16_t>();
  if (type == "uint16") return std::vector<std::uint16_t>();
  if (type == "int32" || type == "int64" || type == "bool") return std::vector<std::int32_t>();
  if (type == "double") return std::vector<double>();
  return std::vector<float>();
}

}  // namespace

WorldToVoxel::WorldToVoxel(const ImageLattice& lattice) : origin(lattice.origin) {
  Mat3d m;
  for (int d = 0; d < 3; ++d) m.setCol(d, lattice.step[d]);
  inverse = m.inverse();
}

openvdb::math::Transform::Ptr transformOf(const ImageLattice& lattice) {
  openvdb::Mat4d m = openvdb::Mat4d::identity();
  // OpenVDB multiplies row vectors.
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = lattice.step[r][c];
  for (int c = 0; c < 3; ++c) m(3, c) = lattice.origin[c];
  return openvdb::math::Transform::createLinearTransform(m);
}

GridBase::Ptr gridOf(const Image& image, const std::string& name, bool labels) {
  const GridBase::Ptr grid = std::visit(
      [&](const auto& values) -> GridBase::Ptr {
        using T = typename std::decay_t<decltype(values)>::value_type;
        if (labels) return filled<openvdb::Int32Grid>(image.lattice, values);
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::int32_t>)
          return filled<openvdb::DoubleGrid>(image.lattice, values);
        else
          return filled<FloatGrid>(image.lattice, values);
      },
      image.values);
  grid->setTransform(transformOf(image.lattice));
  grid->setName(name);
  grid->insertMeta("image_size", openvdb::Vec3IMetadata(image.lattice.size.asVec3i()));
  grid->insertMeta("image_type", openvdb::StringMetadata(kTypeNames[image.values.index()]));
  return grid;
}

Image imageOf(const GridBase& grid) {
  if (!grid.transform().isLinear())
    throw InputError("the grid '" + grid.getName() + "' has no linear transform and makes no image");
  Image image;
  openvdb::Coord first(0);
  const auto size = grid.getMetadata<openvdb::Vec3IMetadata>("image_size");
  const auto type = grid.getMetadata<openvdb::StringMetadata>("image_type");
  if (size) {
    image.lattice.size = openvdb::Coord(size->value());
  } else {
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) throw InputError("the grid '" + grid.getName() + "' is empty and makes no image");
    first = box.min();
    image.lattice.size = box.dim();
  }
  const openvdb::Mat4d m = grid.transform().baseMap()->getAffineMap()->getMat4();
  for (int d = 0; d < 3; ++d) {
    image.lattice.step[d] = Vec3d(m(d, 0), m(d, 1), m(d, 2));
    image.lattice.origin[d] = m(3, d);
  }
  image.lattice.origin = image.lattice.toWorld(first.asVec3d());
  image.values = valuesOfType(type ? type->value() : grid.valueType());
  const bool known =
      std::visit([&](auto& values) { return fill(grid, image.lattice, first, values); }, image.values);
  if (!known)
    throw InputError("the grid '" + grid.getName() + "' holds " + grid.valueType() +
                     ", no numbers, and makes no image");
  return image;
}

}  // namespace slicemorph
