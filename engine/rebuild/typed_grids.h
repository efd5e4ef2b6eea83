#pragma once

#include "engine/rebuild/active_blocks.h"
#include "engine/rebuild/local_block.h"

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace slicemorph {

/// Grid types whose values are blended as numbers, and those whose nearest voxel is taken.
using BlendedTypes =
    openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;
using NearestTypes = openvdb::TypeList<openvdb::BoolGrid, openvdb::MaskGrid, openvdb::Int32Grid,
                                       openvdb::Int64Grid, openvdb::Vec3IGrid>;

/// Values of one leaf under construction, in OpenVDB's leaf order.
template <typename Real>
struct LeafValues {
  enum State : char { kUntouched, kOff, kOn };
  openvdb::Coord origin;
  std::vector<Real> values;  ///< per channel and voxel
  std::vector<char> states;  ///< per voxel
};

/// Grids of one blended type, seen as numbers with one or three channels, so that the blending code
/// is compiled once per number type instead of once per grid type. `Real`: float or double, as the
/// grids have it.
template <typename Real>
class NumberGrids {
 public:
  using Channels = std::array<Real, 3>;

  /// Reads one grid. Each task needs its own.
  class Reader {
   public:
    virtual ~Reader() = default;
    /// Copies all voxels that interpolation at points within `points` (index space) reads.
    virtual void fill(LocalBlock<Real>& block, const openvdb::BBoxd& points) const = 0;
  };

  virtual ~NumberGrids() = default;
  virtual int channels() const = 0;
  virtual Channels background(size_t grid) const = 0;
  virtual ActiveBlocks activeBlocks(size_t grid) const = 0;
  virtual std::unique_ptr<Reader> reader(size_t grid) const = 0;
  /// Allocates `count` leaves of the result.
  virtual void beginLeaves(size_t count, const Channels& background) = 0;
  /// Sets one leaf; it is left out if none of its voxels is active. Different leaves may be set from
  /// different tasks.
  virtual void setLeaf(size_t leaf, const LeafValues<Real>& values) = 0;
  /// The grid made of the leaves, pruned. `band`: the result is a narrow band, whose inside is flood filled
  /// with the negative background.
  virtual openvdb::GridBase::Ptr endLeaves(bool band) = 0;
};

/// Null if the first grid is not a blended type over `Real`. Throws InputError for grids of different types.
template <typename Real>
std::unique_ptr<NumberGrids<Real>> numberGrids(const std::vector<openvdb::GridBase::ConstPtr>& grids);

/// A LeafVisitor calls `cell(positions, first, side)` for each cell of map nodes in the leaf at `origin`: the
/// index-space positions of the cell's side^3 voxels on the only grid (x slowest), and the leaf coordinates
/// of the first one.
using CellVisitor =
    std::function<void(const std::vector<Vec3d>& positions, const openvdb::Coord& first, int side)>;
using LeafVisitor = std::function<void(const openvdb::Coord& origin, const CellVisitor& cell)>;

/// A grid whose voxels take the value of the nearest voxel at the positions that `visit` yields. Null if the
/// grid's type is not one of NearestTypes.
openvdb::GridBase::Ptr nearestValues(const openvdb::GridBase& grid, const std::vector<openvdb::Coord>& leaves,
                                     const LeafVisitor& visit);
/// Null if the grid's type is not one of NearestTypes.
std::unique_ptr<ActiveBlocks> nearestActiveBlocks(const openvdb::GridBase& grid);

}  // namespace slicemorph
