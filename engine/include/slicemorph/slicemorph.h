#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/guidance.h"
#include "slicemorph/image.h"
#include "slicemorph/note.h"
#include "slicemorph/progress.h"

#include <memory>
#include <optional>
#include <string>

/// slicemorph: morphs volumes through oriented slices. Grids in, grids out; reads no files, prints
/// nothing. Method: Yasmin & Talib, "A Method for 3D Morphing Using Slices" [YT09]; the stages are the
/// calls in engine/pipeline.cpp.
namespace slicemorph {

/// One input of a morph: a level set that follows the conventions.
struct Object {
  std::string name;
  FloatGrid::ConstPtr levelSet;
  /// Further surfaces, as level sets, that help to match the objects: other isovalues, labels. The n-th one
  /// of each object belongs together; null, or beyond the end: the object has none.
  std::vector<FloatGrid::ConstPtr> inner = {};
  /// The fog whose shape this is; null: it is none. Where all objects have one and keep their positions (Align::kNone), as
  /// two frames of a simulation do, the map is refined until their densities lie on each other.
  FloatGrid::ConstPtr density = nullptr;
  /// How fast the density moves, world units in any unit of time; null: not known. Two of them are where the search for
  /// that map begins.
  openvdb::Vec3SGrid::ConstPtr velocity = nullptr;
};

enum class SpineKind { kAuto, kStraight, kCurved };
enum class Align { kAuto, kNone, kDirections };

struct MorphOptions {
  int slices = 96;                     ///< slices per object, 8 to 1024
  int samples = 128;                   ///< points per contour, 16 to 4096
  SpineKind spine = SpineKind::kAuto;  ///< kAuto: curved or twisted if that gives more overlap
  /// kNone: world positions and directions are kept. kDirections: objects stand in one world, as frames of a simulation
  /// do: they do not turn, and move only where that matches them better.
  Align align = Align::kAuto;
  Vec3d axis{0, 0, 0};   ///< slicing direction of the first object, world; zero: chosen automatically
  double voxelSize = 0;  ///< of every frame, world units; 0: interpolated from the objects' own
  std::vector<Feature> features = {};  ///< positions that the map shall carry onto each other
  /// Parts with their own weights; where they overlap the later one counts.
  std::vector<Region> regions = {};
  ContourPath path = ContourPath::kLinear;
  /// World direction; turns about it are preferred, so that upright models stay upright; zero: none are
  Vec3d up{0, 1, 0};
};

/// One slice of the plan, for debug pictures: contours in chart space (x, y) and the pairs
/// that were accepted.
struct SlicePicture {
  struct Contour {
    std::vector<openvdb::Vec2d> points;  ///< closed; the first point is not repeated at the end
    bool hole = false;
    int partner = -1;  ///< index of the matched contour of the next object; -1: no match was trusted
  };
  double u = 0;
  std::vector<std::vector<Contour>> objects;  ///< per object: its contours
};

struct InBetween {
  FloatGrid::Ptr surface;  ///< level set named "surface"
  /// Share of the map near the surface whose Jacobian is below 0.05, relative to its mean.
  double foldShare = 0;
  int smallComponents = 0;  ///< loose components of less than 3 % that no object has and that were removed
};

struct CarriedGrid;
class LabelField;  // slicemorph/label_field.h

struct PullbackOptions {
  /// Preserve totals: the sum of all values times the voxel volume is the weighted sum of the objects'.
  bool conserve = false;
  double voxelSize = 0;  ///< world units, on the world's axes; 0: as the grids' own
  /// Leave out what is fainter than anything in the objects' grids: active values of a magnitude below their smallest one
  /// that is not 0, and zeros. Of float and double grids.
  bool dropFaint = false;
};

/// Where velocities are given, and how closely.
struct VelocityOptions {
  /// Units of time: velocities are also given where things arrive within it, or come from, since renderers look them
  /// up there.
  double reach = 0;
  /// By how much interpolation between the grid's voxels may be wrong, world units per unit of time: the voxels are up
  /// to four times as large as the other grid's where the map is smooth enough. 0: voxels as the other grid's.
  double tolerance = 0;
};

/// The map of one in-between, which carries everything that belongs to the shapes: density, temperature,
/// colour, flags. Make it once for all grids of a frame, because it caches what they share. Use it from one
/// thread (it uses all threads itself). It must not outlive its plan.
class Pullback {
 public:
  /// In-between of values: each grid is carried with its object's shape, and the values are blended.
  /// Colours (recognised by the grid's name) are blended where they are active, never with the background.
  /// `grids`: one per object, of one type, on any transform; null if the object has none, which counts as
  /// background. Values of float, double, vec3s and vec3d grids are blended; those of bool, mask, int32,
  /// int64 and vec3i grids are taken from the heaviest object. Vectors turn with the map unless they are
  /// colours or texture coordinates.
  /// The result has the metadata of the first grid. Unless a voxel size is given it has the grids' transform
  /// if their axes and voxels agree, else the world's axes with the weighted mean of the voxel sizes; at
  /// weight 1 it is that object's grid itself. `conserve` is for densities. Throws InputError for grids that
  /// do not fit together or cannot be carried.
  openvdb::GridBase::ConstPtr carry(const std::vector<openvdb::GridBase::ConstPtr>& grids,
                                    const PullbackOptions& options = {});

  /// Velocity of what is at the active voxels of a grid while the weights change by `rate` per unit of time (one
  /// number per object, summing to 0): world units per that time unit, named "vel"; of the forward map. What does
  /// not move is not active, and has the background's value, 0. Throws InputError for other rates, options below
  /// 0, and grid types whose active voxels are not supported.
  openvdb::Vec3SGrid::Ptr velocity(const openvdb::GridBase& where, const Weights& rate,
                                   const VelocityOptions& options = {}) const;

  /// In-between of dense images on a lattice: sum_k w_k V_k(M_k(p)), trilinear; beyond an image its smallest
  /// value. Has the images' number type if they share one (integers are rounded), else one that holds all. At
  /// weight 1 it is that image itself, resampled only if its lattice differs. `images`: one per object, none
  /// null. `isos`: the value at each object's surface, or empty; if given, the in-between has their weighted
  /// mean at its own surface: values beside it that are on the wrong side of that mean, smaller ones inside and larger
  /// ones outside, are mirrored at it, as far as depths there had to be matched; others stay. Throws InputError.
  Image carry(const std::vector<const Image*>& images, const ImageLattice& on,
              const std::vector<double>& isos = {}) const;

  /// Colours of an in-between's surface, one per active voxel of its level set, named "Cd": sum_k w_k c_k at
  /// the nearest points of the objects' surfaces, so that only surface colours are blended. `colors`: per
  /// object, on voxels around its surface, any transform; null if it has none: then the others' count. At
  /// weight 1 they are that object's own. Throws InputError if no object has colours.
  openvdb::Vec3SGrid::Ptr colors(const FloatGrid& surface,
                                 const std::vector<openvdb::Vec3SGrid::ConstPtr>& colors);

  /// In-between of label maps: at every voxel the label with the greatest blended depth, sum_k
  /// w_k d_k(M_k(p)); the space without a label takes part as if it were one. So there are no
  /// gaps and no overlaps, and the order of labels has no influence. `labels`: one per object,
  /// none null; else InputError.
  Image carryLabels(const std::vector<const LabelField*>& labels, const ImageLattice& on) const;

  struct Impl;
  explicit Pullback(std::unique_ptr<Impl> impl);
  ~Pullback();
  Pullback(Pullback&&) noexcept;
  Pullback& operator=(Pullback&&) noexcept;

 private:
  void fillVelocities(openvdb::Vec3SGrid& grid, const Weights& rate) const;
  openvdb::GridBase::Ptr warped(const std::vector<CarriedGrid>& grids, const openvdb::GridBase& prototype,
                                const PullbackOptions& options);
  std::unique_ptr<Impl> impl_;
};

/// How an in-between is made of its objects: figures that show where a map is not to be trusted.
struct FrameStrain {
  /// Of the objects' surfaces beyond the change of size, mean over the objects by weight: the greater principal stretch or
  /// the inverse of the lesser one; 1 where nothing is stretched.
  double meanStretch = 1, worstStretch = 1;
  double muchStretched = 0;  ///< share of the surface stretched more than threefold
  double meanTurn = 0;       ///< radians by which the surface is turned against the whole, in the mean
};

/// How sure a plan is of which way round an object lies against the first one.
struct TurnChoice {
  double degrees = 0;     ///< by which it is turned
  double distortion = 0;  ///< of inner distances, 0: the objects are alike; below zero: not measured
  /// By how much more the best turn distorts that differs by more than 60 degrees and might have been chosen (an upright
  /// one, if the chosen one is), as a share; below zero: not measured, or the objects look the same that way, too.
  double margin = -1;
};

/// The least allowed weight. Weights below 0 extrapolate beyond the objects.
constexpr double kLeastWeight = -0.5;

/// The object that an in-between of these weights equals, if any: its weight is 1 and all others are 0.
std::optional<size_t> aloneIn(const Weights& weights);
/// Weights for values, which are not extrapolated: negative ones become 0, and the others are scaled to sum
/// to 1.
Weights withoutNegatives(const Weights& weights);

/// Everything about a morph that is computed once; after that every frame is an independent task. Thread-safe
/// after construction.
class MorphPlan {
 public:
  /// Throws InputError for fewer than one object or options out of range, GeometryError for a level set
  /// that is empty or does not follow the conventions; the message names the object, its value and what
  /// would be right.
  MorphPlan(std::vector<Object> objects, const MorphOptions& options = {}, Progress* progress = nullptr);
  /// The plan of the next frame of a sequence. `before` is the plan of the previous frame, made for the same
  /// objects a moment earlier; its options are used. Its decisions (axes, turns, spines, twist, limbs) are
  /// kept and follow the objects' motion; the matching starts from the previous one. If that is no usable
  /// start (a cut), the objects are planned anew, and notes() says so. Throws InputError for a different
  /// number of objects, GeometryError as above.
  MorphPlan(std::vector<Object> objects, const MorphPlan& before, Progress* progress = nullptr);
  /// A plan by the decisions() of an earlier one, of the same objects and options: frames are the same bytes, and planning
  /// takes only the time to measure the objects. It has no slicePictures() and cannot be the plan `before` of another.
  /// Throws InputError for decisions that are damaged, of another version or of other objects; GeometryError as above.
  static MorphPlan decidedBefore(std::vector<Object> objects, const MorphOptions& options,
                                 const std::string& decisions, Progress* progress = nullptr);
  ~MorphPlan();
  MorphPlan(MorphPlan&&) noexcept;
  MorphPlan& operator=(MorphPlan&&) noexcept;

  /// The in-between for the given weights: one per object, summing to 1 within 1e-6, none below kLeastWeight
  /// (splines through keys go a little beyond the objects); else InputError.
  InBetween frame(const Weights& weights) const;

  /// The map for grids that move with the shapes; weights as for frame().
  Pullback pullback(const Weights& weights) const;

  /// World positions on in-between `to` of the points that are at `points` on in-between `from`, by the map
  /// alone; weights as for frame().
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, const Weights& from,
                                 const Weights& to) const;
  /// The same from an object to an in-between. Throws InputError if there is no such object.
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, size_t from, const Weights& to) const;
  /// The same from one object to another; throws as above.
  std::vector<Vec3d> correspond(const std::vector<Vec3d>& points, size_t from, size_t to) const;

  /// The plan of a neighbouring stretch of a sequence; null: there is none. `ratio`: how long this plan's stretch is
  /// against that one.
  struct Stretch {
    const MorphPlan* plan = nullptr;
    double ratio = 1;
  };
  /// Of a plan from one frame of a sequence to the next: paths go on smoothly from the stretch before, whose second
  /// object is this plan's first one, and into the one after, so that nothing changes its speed suddenly at a frame that
  /// is given. Frames at the objects themselves stay as they are. Throws InputError for other than two objects.
  void passSmoothly(const Stretch& before, const Stretch& after);

  /// See FrameStrain; weights as for frame().
  FrameStrain strain(const Weights& weights) const;
  /// Per object but the first, in the plan's own order; empty with Align::kNone.
  std::vector<TurnChoice> turnChoices() const;
  /// Of the warped objects in the middle space, intersection over union, 0 to 1.
  double overlap() const;

  /// How the objects are laid, and the map between them, as bytes for decidedBefore(): a few megabytes.
  std::string decisions() const;

  size_t objectCount() const;
  std::vector<SlicePicture> slicePictures() const;
  /// What was decided, one sentence each (axes, alignment, share of trusted pairs).
  Notes notes() const;

 private:
  struct Impl;
  struct Made {};  ///< so that MorphPlan({}) means no objects
  MorphPlan(Made, std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace slicemorph
