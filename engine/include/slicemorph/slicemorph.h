#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/guidance.h"
#include "slicemorph/image.h"
#include "slicemorph/note.h"
#include "slicemorph/progress.h"

#include <memory>
#include <optional>
#include <string>

/// slicemorph: morphs volumes through oriented slices. Grids in, grids out; loads nothing, prints nothing.
/// Method: Yasmin & Talib, "A Method for 3D Morphing Using Slices" [YT09]; the stages are the calls of
/// engine/pipeline.cpp.
namespace slicemorph {

/// One input of a morph: a level set by the conventions.
struct Object {
  std::string name;
  FloatGrid::ConstPtr levelSet;
  /// Further surfaces, level sets by the conventions, that help to match the objects: other isovalues,
  /// labels. The n-th of one object belongs with the n-th of the others; null, or beyond the end: it has
  /// none.
  std::vector<FloatGrid::ConstPtr> inner = {};
};

enum class SpineKind { kAuto, kStraight, kCurved };
enum class Align { kAuto, kNone };

struct MorphOptions {
  int slices = 96;                     ///< slices per object, 8 to 1024
  int samples = 128;                   ///< points per contour, 16 to 4096
  SpineKind spine = SpineKind::kAuto;  ///< kAuto: curved or twisted where that wins overlap
  Align align = Align::kAuto;          ///< kNone: world positions and directions are kept
  Vec3d axis{0, 0, 0};                 ///< slicing direction of the first object, world; zero: found
  double voxelSize = 0;                ///< of every frame, world units; 0: follows the objects' own
  std::vector<Feature> features = {};  ///< places that the map is to carry onto each other
  std::vector<Region> regions =
      {};  ///< parts with weights of their own; where they overlap the later one counts
  ContourPath path = ContourPath::kLinear;
  Vec3d up{0, 1, 0};  ///< world; turns about it are preferred: upright models stay so; zero: none are
};

/// One slice of the plan, for debug pictures: contours in chart space (x, y) and the pairs that were
/// accepted.
struct SlicePicture {
  struct Contour {
    std::vector<openvdb::Vec2d> points;  ///< closed, the first point is not repeated
    bool hole = false;
    int partner = -1;  ///< index of the matched contour of the next object, -1: none was trusted
  };
  double u = 0;
  std::vector<std::vector<Contour>> objects;  ///< per object, its contours
};

struct InBetween {
  FloatGrid::Ptr surface;  ///< level set named "surface"
  double foldShare =
      0;  ///< share of the near-surface whose map has a Jacobian below 0.05, relative to its mean
  int smallComponents = 0;  ///< loose parts of less than 3 % that no object has and that were removed
};

struct CarriedGrid;
class LabelField;  // slicemorph/label_field.h

struct PullbackOptions {
  bool conserve =
      false;  ///< the sum of all values times the voxels' volume is the weighted sum of the objects' own
  double voxelSize = 0;  ///< world units, on the world's axes; 0: follows the grids' own
};

/// One in-between's map, for all that rides with the shapes: density, temperature, colour, flags. It is made
/// once for all grids of a frame and keeps what they share; use it from one thread (it uses all itself). Not
/// to outlive its plan.
class Pullback {
 public:
  /// In-between of values: each grid goes along with its object's shape, and the values are blended where
  /// they meet. Colours (by the grid's name) are blended where they are active, and never with the
  /// background. `grids`: one per object, of one type, on any transform; null where the object has none,
  /// which counts as background. Float, double, vec3s and vec3d are blended; bool, mask, int32, int64 and
  /// vec3i are the heaviest object's. Vectors turn with the map unless they are colours or places. The result
  /// has the metadata of the first grid; unless a voxel size is asked for it lies on the grids' transform
  /// where their axes and voxels agree, else on the world's axes with the weighted mean of the voxel sizes,
  /// and at weight 1 it is that object's grid itself. `conserve` is for densities. Throws InputError for
  /// grids that do not fit together or cannot be carried.
  openvdb::GridBase::ConstPtr carry(const std::vector<openvdb::GridBase::ConstPtr>& grids,
                                    const PullbackOptions& options = {});

  /// Velocity of what is at the active voxels of a grid while the weights change by `rate` a unit of time
  /// (one number per object, of sum 0): world units per that time, named "vel". Of the forward map. On the
  /// same voxels and as far around them as they get within `reach` of that time: a renderer looks velocities
  /// up where things arrive. Throws InputError for other rates.
  openvdb::Vec3SGrid::Ptr velocity(const openvdb::GridBase& where, const Weights& rate,
                                   double reach = 0) const;

  /// In-between of dense images on a lattice: sum_k w_k V_k(M_k(p)), trilinear; beyond an image its smallest
  /// value. Of the images' own number type where they share one (whole numbers are rounded), else of one that
  /// holds all. At weight 1 it is that image itself, resampled only where its lattice is another. `images`:
  /// one per object, none null. `isos`: the value at each one's surface, or none; the in-between then has their
  /// blend on its own surface, and only inside it more. Throws InputError.
  Image carry(const std::vector<const Image*>& images, const ImageLattice& on,
              const std::vector<double>& isos = {}) const;

  /// Colours of an in-between's surface, one for each active voxel of its level set, named "Cd": sum_k w_k
  /// c_k of the nearest places of the objects' surfaces, so that nothing but surfaces' colours is blended.
  /// `colors`: per object, on voxels around its surface, any transform; null where it has none: the others'
  /// count. At weight 1 they are that object's own. Throws InputError where no object has colours.
  openvdb::Vec3SGrid::Ptr colors(const FloatGrid& surface,
                                 const std::vector<openvdb::Vec3SGrid::ConstPtr>& colors);

  /// In-between of label maps: at every voxel the label whose blended distance, sum_k w_k d_k(M_k(p)), lies
  /// deepest inside; the space without a label counts as one. No gaps, no overlaps, no order of labels.
  /// `labels`: one per object, none null; else InputError.
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

/// Weights below 0 lead on beyond the objects, no further than this.
constexpr double kLeastWeight = -0.5;

/// The object that an in-between of these weights is, if it is one: its weight is 1 and all others are 0.
std::optional<size_t> aloneIn(const Weights& weights);
/// For values, which do not go beyond what they are blended of: weights below 0 are 0, and the others sum
/// to 1.
Weights withoutNegatives(const Weights& weights);

/// What a morph needs to know once; every frame is then an independent task. Thread-safe after construction.
class MorphPlan {
 public:
  /// Throws InputError for fewer than one object or options out of range, GeometryError for a level set that is
  /// empty or against the conventions; the message names the object, its value and what would be right.
  MorphPlan(std::vector<Object> objects, const MorphOptions& options = {}, Progress* progress = nullptr);
  /// The plan of the next frame of a sequence: `before` is the plan of the frame before, of the same objects
  /// a moment earlier, whose options it takes. What was decided there holds (axes, turns, spines, twist,
  /// limbs) and follows the objects' motion; the matching starts from the one before. Where that is no start
  /// any more (a cut) the objects are planned anew, and notes() says so. Throws InputError for another number
  /// of objects, GeometryError as above.
  MorphPlan(std::vector<Object> objects, const MorphPlan& before, Progress* progress = nullptr);
  ~MorphPlan();
  MorphPlan(MorphPlan&&) noexcept;
  MorphPlan& operator=(MorphPlan&&) noexcept;

  /// The in-between of the given weights: one per object, of sum 1 within 1e-6, none below kLeastWeight
  /// (splines through keys go a little beyond the objects); else InputError.
  InBetween frame(const Weights& weights) const;

  /// For the grids that ride with the shapes; weights as frame().
  Pullback pullback(const Weights& weights) const;

  /// Where what one in-between has at some world points is on another one, by the map alone; weights as
  /// frame().
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, const Weights& from,
                                 const Weights& to) const;
  /// What an object has, carried to an in-between. Throws InputError where there is no such object.
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, size_t from, const Weights& to) const;
  /// The same from one object to another one; throws alike.
  std::vector<Vec3d> correspond(const std::vector<Vec3d>& points, size_t from, size_t to) const;

  size_t objectCount() const;
  std::vector<SlicePicture> slicePictures() const;
  /// What was decided, one sentence each (axes, alignment, share of trusted pairs).
  Notes notes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slicemorph
