#include "slicemorph/io/placing.h"

#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"

namespace slicemorph {
namespace {

/// The quarter turn that takes one axis to another.
Mat3d turnOfAxis(int from, int to) {
  if (from == to) return Mat3d::identity();
  // About the third axis, which stays: `from` becomes `to`, `to` becomes the opposite of `from`.
  const int third = 3 - from - to;
  Mat3d turn = Mat3d::zero();
  turn(to, from) = 1, turn(from, to) = -1, turn(third, third) = 1;
  return turn;
}

/// OpenVDB multiplies rows from the left.
openvdb::Mat4d matrixOfRows(const Placing& placing) {
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      matrix(row, column) = placing.scale * placing.rotation(column, row);
  for (int column = 0; column < 3; ++column) matrix(3, column) = placing.move[column];
  return matrix;
}

template <typename Grid, typename Change>
openvdb::GridBase::Ptr changed(const openvdb::GridBase::Ptr& grid, const Change& change) {
  const auto copy = openvdb::GridBase::grid<Grid>(grid)->deepCopy();
  for (auto value = copy->beginValueAll(); value; ++value) value.setValue(change(*value));
  auto& root = copy->tree().root();
  root.setBackground(change(root.background()), false);
  return copy;
}

/// The grid with values as the placing makes them; the same grid where these stay.
openvdb::GridBase::Ptr withPlacedValues(const openvdb::GridBase::Ptr& grid, const Placing& placing) {
  const double s = placing.scale;
  const auto numbers = [&](auto value) { return decltype(value)(double(value) * s); };
  if (grid->getGridClass() == openvdb::GRID_LEVEL_SET && s != 1) {
    if (grid->isType<FloatGrid>()) return changed<FloatGrid>(grid, numbers);
    if (grid->isType<openvdb::DoubleGrid>()) return changed<openvdb::DoubleGrid>(grid, numbers);
  }
  if (isColorName(grid->getName())) return grid;
  const auto vectors = [&](auto value) { return decltype(value)(s * (placing.rotation * Vec3d(value))); };
  if (grid->isType<openvdb::Vec3SGrid>()) return changed<openvdb::Vec3SGrid>(grid, vectors);
  if (grid->isType<openvdb::Vec3DGrid>()) return changed<openvdb::Vec3DGrid>(grid, vectors);
  return grid;
}

}  // namespace

Placing placingOf(const InputPlacing& asked, char up) {
  Placing placing;
  if (asked.scale > 0) placing.scale = asked.scale;
  if (asked.upright) placing.rotation = turnOfAxis(asked.upright - 'x', up - 'x');
  return placing;
}

void place(std::vector<openvdb::Vec3s>& points, const Placing& placing) {
  if (placing.isIdentity()) return;
  for (openvdb::Vec3s& p : points) p = openvdb::Vec3s(placing(Vec3d(p)));
}

void place(ImageLattice& lattice, const Placing& placing) {
  if (placing.isIdentity()) return;
  lattice.origin = placing(lattice.origin);
  for (Vec3d& step : lattice.step) step = placing.scale * (placing.rotation * step);
}

openvdb::GridBase::Ptr placed(const openvdb::GridBase::Ptr& grid, const Placing& placing) {
  if (!grid || placing.isIdentity()) return grid;
  if (!grid->transform().isLinear())
    throw InputError("grid '" + grid->getName() +
                     "' is on a frustum and cannot be brought to another size or place");
  const openvdb::GridBase::Ptr changed = withPlacedValues(grid, placing);
  const openvdb::GridBase::Ptr result = changed == grid ? grid->copyGrid() : changed;
  const openvdb::Mat4d own = grid->transform().baseMap()->getAffineMap()->getMat4();
  result->setTransform(openvdb::math::Transform::createLinearTransform(own * matrixOfRows(placing)));
  return result;
}

}  // namespace slicemorph
