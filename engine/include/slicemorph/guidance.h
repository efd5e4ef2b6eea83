#pragma once

#include "slicemorph/conventions.h"

#include <string>

/// Optional guidance of a morph by its user.
namespace slicemorph {

/// A point, line or disk that exists on all objects: the map shall carry it from one to the other.
struct Feature {
  enum class Kind { kPoint, kLine, kDisk };
  std::string name;  ///< for messages
  Kind kind = Kind::kPoint;
  /// Per object, world space: for a point its position; for a line two or more points along it, in the same
  /// direction on all objects; for a disk its centre.
  std::vector<std::vector<Vec3d>> positions;
  std::vector<Vec3d> normals = {};  ///< of a disk: per object, world space, any length but 0
  std::vector<double> radii = {};   ///< of a disk: per object, world units
};

/// A part of the in-between that has its own weights.
struct Region {
  enum class Kind { kSphere, kBox, kSpine };
  std::string name;  ///< for messages
  Kind kind = Kind::kSphere;
  size_t object = 0;        ///< index of the object on which the region is defined
  Vec3d center{0, 0, 0};    ///< of a sphere, world space
  double radius = 0;        ///< of a sphere, world units
  openvdb::BBoxd box = {};  ///< of a box, world space
  /// Of a part of the spine: fractions of the object's length along it, in the direction in which the world
  /// axis ascends that is nearest to the spine's direction.
  double from = 0, to = 1;
  /// Width of the transition, world units on that object, half inside and half outside; 0: a tenth of the
  /// object's size.
  double border = 0;
  Weights weights = {};  ///< within the region, one per object
};

/// How contours move from object to object.
enum class ContourPath {
  kLinear,    ///< points move along straight lines, limbs swing
  kHermite,   ///< cubic: points leave and reach each contour at right angles
  kIntrinsic  ///< the contours' edge lengths and turning angles are interpolated linearly [SGWM93]
};

}  // namespace slicemorph
