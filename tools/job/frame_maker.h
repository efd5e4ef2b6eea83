#pragma once

#include "engine/volume/label_field.h"
#include "io/vdb/grid_sets.h"
#include "slicemorph/note.h"
#include "slicemorph/slicemorph.h"
#include "tools/commands/terminal_progress.h"
#include "tools/job/frame_inputs.h"
#include "tools/job/morph_settings.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// One frame's shape and grids.
struct MorphFrame {
  InBetween shape;                      ///< surface null with --method dissolve
  openvdb::GridCPtrVec grids;           ///< of an output that holds grids, in their order
  openvdb::Vec3SGrid::ConstPtr colors;  ///< of the shape's surface; null: it has none
  openvdb::GridBase::ConstPtr
      density;                 ///< of those, the fog that the shapes are part of; null: there is none
  std::optional<Image> image;  ///< of an image output
};

/// Makes the frames of a job, whatever its method: reads the inputs, plans, carries the grids.
class FrameMaker {
 public:
  FrameMaker(const MorphSettings& settings, TerminalProgress& progress);
  ~FrameMaker();

  /// Reads and plans what a frame (index into the settings' frames) needs; frames are to come in order.
  /// `from`, `to`: this step's part of the whole job, for the progress line.
  void moveTo(size_t index, double from, double to);
  /// The shape alone, of the frame moved to.
  InBetween shape() const;
  /// The same with its colours.
  MorphFrame coloredShape() const;
  MorphFrame make() const;

  const std::vector<LoadedObject>& inputs() const { return inputs_.loaded(); }
  /// File metadata and compression of the output: the first VDB input's.
  VdbOutput fileOptions() const;
  /// What was found, decided, left out since the last call, one sentence each.
  Notes takeNotes();
  /// Null but with --method slices.
  const MorphPlan* slicePlan() const { return plan_.get(); }
  /// The surface's value in the grey image of the frame moved to.
  double iso() const;
  std::optional<double> restDistance() const { return restDistance_; }
  double loadSeconds() const { return loadSeconds_; }
  double planSeconds() const { return planSeconds_; }

 private:
  void plan(Progress& progress);
  void planSlices(Progress& progress);
  void planSdf();
  void planLevelSet(Progress& progress);
  void chooseGrids(bool first);
  void keepAsked(const std::vector<std::string>& asked, bool first);
  Pullback pullback() const;
  void chooseColors(GridSets& found);
  openvdb::GridBase::ConstPtr density(Pullback& pullback) const;
  openvdb::GridBase::Ptr velocity(const Pullback& pullback, const openvdb::GridBase& where,
                                  const openvdb::GridCPtrVec& grids) const;
  double voxelSize() const;
  void prepareImages();
  Image image() const;
  const FrameJob& job() const { return settings_.frames[index_]; }

  const MorphSettings& settings_;
  TerminalProgress& progress_;
  FrameInputs inputs_;
  size_t index_ = 0;
  bool fog_ = false;                ///< the result is a fog volume
  bool surfaceWanted_ = true;       ///< as a grid of the output
  std::optional<size_t> shapeSet_;  ///< of sets_, where the result is a fog volume
  std::vector<GridSet> sets_;
  std::string colorName_;  ///< of the grid of the surface's colours; empty: no input has any
  bool images_ = false;    ///< all inputs are images, and the result shows their values
  ImageLattice lattice_;   ///< of in-between images
  std::vector<LabelField> labelFields_;
  std::unique_ptr<MorphPlan> plan_;
  std::function<InBetween()> makeShape_;
  Notes notes_;
  std::optional<double> restDistance_;
  double loadSeconds_ = 0, planSeconds_ = 0;
};

}  // namespace slicemorph
