#pragma once

#include "slicemorph/conventions.h"

#include <string>

/// What an artist may say to a morph; none of it is needed.
namespace slicemorph {

/// A place that all objects have: the map is to carry it from one to the other.
struct Feature {
  enum class Kind { kPoint, kLine, kDisk };
  std::string name;  ///< for messages
  Kind kind = Kind::kPoint;
  /// Per object, world: of a point its place; of a line two or more places along it, the same way round on
  /// all objects; of a disk its centre.
  std::vector<std::vector<Vec3d>> positions;
  std::vector<Vec3d> normals = {};  ///< of a disk: per object, world, any length but 0
  std::vector<double> radii = {};   ///< of a disk: per object, world units
};

/// A part of the in-between that has weights of its own.
struct Region {
  enum class Kind { kSphere, kBox, kSpine };
  std::string name;  ///< for messages
  Kind kind = Kind::kSphere;
  size_t object = 0;        ///< the object on which it is drawn
  Vec3d center{0, 0, 0};    ///< of a sphere, world
  double radius = 0;        ///< of a sphere, world units
  openvdb::BBoxd box = {};  ///< of a box, world
  double from = 0, to = 1;  ///< of a stretch of the spine: shares of that object's length along it, rising
                            ///< the way the world's axis rises that the spine follows most nearly
  double border = 0;  ///< world units on that object: the width over which it goes over, half inside and half
                      ///< outside; 0: a tenth of the object's size
  Weights weights = {};  ///< there, one per object
};

/// The way contours take from object to object.
enum class ContourPath {
  kLinear,    ///< points go straight on, limbs swing
  kHermite,   ///< cubic: points leave and reach each contour at right angles
  kIntrinsic  ///< the contours' edge lengths and turning angles go straight on [SGWM93]
};

}  // namespace slicemorph
