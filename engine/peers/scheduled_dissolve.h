#pragma once

#include "engine/numerics/lattice.h"
#include "slicemorph/progress.h"

#include <memory>
#include <vector>

namespace slicemorph {

/// A linear transform of the values of a lattice into as many parts, from coarse to fine.
class LatticeTransform {
 public:
  virtual ~LatticeTransform() = default;
  /// The next larger number of nodes along an axis that it can take.
  virtual int nodes(int atLeast) const = 0;
  virtual void forward(const Lattice& lattice, std::vector<float>& values) const = 0;
  virtual void inverse(const Lattice& lattice, std::vector<float>& values) const = 0;
  /// Of the part at a node of the transformed lattice: 0 the coarsest to 1 the finest.
  virtual double fineness(const Lattice& lattice, const openvdb::Coord& part) const = 0;
};

/// The share that a part of an input has in a blend where the input's weight is `weight`. The coarsest parts have that
/// weight. Finer ones go sooner and come later: the finest are gone when 1 - weight is `fade`, others later by the square
/// of their fineness, so that coarse parts hardly differ from the coarsest.
double scheduledShare(double weight, double fineness, double fade);

/// Blend of distance fields part by part, by a schedule [Hug92]: the fine detail of one object fades, the coarse shape
/// changes, the fine detail of the other appears.
class ScheduledDissolve {
 public:
  /// Takes the box about all level sets, wider by a sixteenth and four voxels on each side. `voxelSize`: world units;
  /// `fade`: as of scheduledShare, 0 to 1. Throws InputError, which names `method`, for more than kMostNodes; Cancelled.
  /// Keeps four bytes for each node and level set.
  ScheduledDissolve(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize, double fade,
                    std::unique_ptr<LatticeTransform> transform, const char* method,
                    Progress* progress = nullptr);
  /// A level set named "surface". Throws InputError unless there is one weight per level set.
  FloatGrid::Ptr frame(const Weights& weights) const;

  static constexpr double kMostNodes = 512.0 * 512 * 512;

 private:
  Lattice lattice_;
  double fade_;
  std::unique_ptr<LatticeTransform> transform_;
  std::vector<std::vector<float>> parts_;  ///< per level set
};

}  // namespace slicemorph
