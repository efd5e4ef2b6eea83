#pragma once

#include "engine/rebuild/active_blocks.h"
#include "engine/rebuild/local_block.h"

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace slicemorph {

/// Types whose values are blended as numbers, and those of which the nearest voxel is taken.
using BlendedTypes =
    openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;
using NearestTypes = openvdb::TypeList<openvdb::BoolGrid, openvdb::MaskGrid, openvdb::Int32Grid,
                                       openvdb::Int64Grid, openvdb::Vec3IGrid>;

/// Values of one leaf that is being made, in the order of OpenVDB's leaves.
template <typename Real>
struct LeafValues {
  enum State : char { kUntouched, kOff, kOn };
  openvdb::Coord origin;
  std::vector<Real> values;  ///< per channel and voxel
  std::vector<char> states;  ///< per voxel
};

/// Grids of one blended type seen as numbers with one or three channels, so that what blends them is compiled once for each
/// kind of number and not once for each type. `Real`: float or double, as the grids have it.
template <typename Real>
class NumberGrids {
 public:
  using Channels = std::array<Real, 3>;

  /// Reads one grid; for one task.
  class Reader {
   public:
    virtual ~Reader() = default;
    /// Copies what interpolation at index-space points within `points` needs.
    virtual void fill(LocalBlock<Real>& block, const openvdb::BBoxd& points) const = 0;
  };

  virtual ~NumberGrids() = default;
  virtual int channels() const = 0;
  virtual Channels background(size_t grid) const = 0;
  virtual ActiveBlocks activeBlocks(size_t grid) const = 0;
  virtual std::unique_ptr<Reader> reader(size_t grid) const = 0;
  /// Room for that many leaves of the result.
  virtual void beginLeaves(size_t count, const Channels& background) = 0;
  /// Sets one of them; none where nothing of it is active. Different ones from different tasks.
  virtual void setLeaf(size_t leaf, const LeafValues<Real>& values) = 0;
  /// The grid of these leaves, pruned. `band`: the sign of the surface's distance is carried into its inside.
  virtual openvdb::GridBase::Ptr endLeaves(bool band) = 0;
};

/// Null where the first grid is not of a blended type with these numbers. Throws InputError for grids of different types.
template <typename Real>
std::unique_ptr<NumberGrids<Real>> numberGrids(const std::vector<openvdb::GridBase::ConstPtr>& grids);

/// Finds, for one leaf, the index-space positions of one cell's voxels after another on the only grid: calls
/// `cell(positions, first)` with the position of each voxel (x slowest) and the first voxel's coordinates.
using CellVisitor =
    std::function<void(const std::vector<Vec3d>& positions, const openvdb::Coord& first, int side)>;
using LeafVisitor = std::function<void(const openvdb::Coord& origin, const CellVisitor& cell)>;

/// A grid of the nearest voxels' values at positions that are found leaf by leaf. Null where its type is not one of those.
openvdb::GridBase::Ptr nearestValues(const openvdb::GridBase& grid, const std::vector<openvdb::Coord>& leaves,
                                     const LeafVisitor& visit);
/// Null where its type is not one of those whose nearest values are taken.
std::unique_ptr<ActiveBlocks> nearestActiveBlocks(const openvdb::GridBase& grid);

}  // namespace slicemorph
