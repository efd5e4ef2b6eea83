#include "io/exr/exr_slice_header.h"

#include <ImathMatrix.h>
#include <ImfDoubleAttribute.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfVecAttribute.h>

namespace slicemorph {
namespace {

Imath::V3d toImath(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

/// A matrix with these rows, to be multiplied by row vectors from the left, as Imath does.
Imath::M44d matrixOf(const Vec3d& x, const Vec3d& y, const Vec3d& z, const Vec3d& origin) {
  Imath::M44d matrix;
  const Vec3d* rows[4] = {&x, &y, &z, &origin};
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 3; ++c) matrix[r][c] = (*rows[r])[c];
  return matrix;
}

/// Camera space: x right, y up, z along the normal, origin in the image's centre, world units.
Imath::M44f worldToCamera(const SectionPlane& plane) {
  const Vec3d centre = plane.toWorld(0.5 * (plane.width - 1), 0.5 * (plane.height - 1));
  // The axes are orthonormal, so the inverse of camera-to-world is its transpose.
  const Vec3d axes[3] = {plane.xAxis, -plane.yAxis, plane.normal};
  Imath::M44f matrix;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) matrix[r][c] = float(axes[c][r]);
    matrix[3][c] = float(-centre.dot(axes[c]));
  }
  return matrix;
}

/// -1 to 1 across the display window, in whose upper left corner the slice lies, y up, as in pictures (see exr_writer.h).
Imath::M44f worldToNdc(const Imath::Box2i& display, const SectionPlane& plane) {
  const double across = display.max.x + 1.0, down = display.max.y + 1.0;
  Imath::M44f screen;
  screen[0][0] = float(2 / (across * plane.pixelSize)), screen[3][0] = float(plane.width / across - 1);
  screen[1][1] = float(2 / (down * plane.pixelSize)), screen[3][1] = float(1 - plane.height / down);
  return worldToCamera(plane) * screen;
}

/// The background value; a scalar's in all three components.
Vec3d backgroundOf(const openvdb::GridBase& grid) {
  Vec3d background(0.0);
  grid.apply<openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                               openvdb::BoolGrid>>(
      [&](const auto& typed) { background = Vec3d(double(typed.background())); });
  grid.apply<openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>>(
      [&](const auto& typed) { background = Vec3d(typed.background()); });
  return background;
}

}  // namespace

void placeSlice(Imf::Header& header, const SectionPlane& plane) {
  header.insert("sliceOrigin", Imf::V3dAttribute(toImath(plane.origin)));
  header.insert("sliceAxisX", Imf::V3dAttribute(toImath(plane.xAxis)));
  header.insert("sliceAxisY", Imf::V3dAttribute(toImath(plane.yAxis)));
  header.insert("sliceNormal", Imf::V3dAttribute(toImath(plane.normal)));
  header.insert("slicePixelSize", Imf::DoubleAttribute(plane.pixelSize));
  header.insert("sliceIndex", Imf::IntAttribute(plane.index));
  header.insert("sliceCount", Imf::IntAttribute(plane.count));
  header.insert("sliceU", Imf::DoubleAttribute(plane.u));
  header.insert("pixelToWorld",
                Imf::M44dAttribute(matrixOf(plane.xAxis * plane.pixelSize, plane.yAxis * plane.pixelSize,
                                            plane.normal * plane.pixelSize, plane.origin)));
  Imf::addWorldToCamera(header, worldToCamera(plane));
  Imf::addWorldToNDC(header, worldToNdc(header.displayWindow(), plane));
}

void describeGrid(Imf::Header& header, const SliceGrid& slice) {
  const openvdb::GridBase& grid = *slice.grid;
  const auto put = [&](const char* what, const Imf::Attribute& value) {
    header.insert(slice.name + "." + what, value);
  };
  put("class", Imf::StringAttribute(openvdb::GridBase::gridClassToString(grid.getGridClass())));
  put("type", Imf::StringAttribute(grid.type()));
  put("vectorType", Imf::StringAttribute(openvdb::GridBase::vecTypeToString(grid.getVectorType())));
  put("halfFloat", Imf::IntAttribute(grid.saveFloatAsHalf()));
  put("background", Imf::V3dAttribute(toImath(backgroundOf(grid))));
  put("voxelSize", Imf::V3dAttribute(toImath(grid.voxelSize())));
  const Vec3d origin = grid.indexToWorld(Vec3d(0.0));
  Vec3d step[3];
  for (int a = 0; a < 3; ++a) {
    Vec3d unit(0.0);
    unit[a] = 1;
    step[a] = grid.indexToWorld(unit) - origin;
  }
  put("transform", Imf::M44dAttribute(matrixOf(step[0], step[1], step[2], origin)));
}

}  // namespace slicemorph
