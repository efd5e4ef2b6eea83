#include "tools/job/fit_inputs.h"

#include "tools/job/option_values.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// Beyond this ratio of sizes inputs are likely in different units: metres and centimetres differ by 100, metres and
/// millimetres by 1000; a mouse and a man differ by 20.
constexpr double kOtherUnits = 20;

double longestSide(const openvdb::BBoxd& box) {
  if (box.empty()) return 0;
  const Vec3d e = box.extents();
  return std::max({e[0], e[1], e[2]});
}

}  // namespace

FitKind fitOf(const InputPlacing& own, const std::string& ofJob) {
  const std::string& fit = own.fit.empty() ? ofJob : own.fit;
  return fit == "size" ? FitKind::kSize : fit == "box" ? FitKind::kBox : FitKind::kNone;
}

openvdb::BBoxd boxOfShape(const FloatGrid& levelSet) {
  openvdb::BBoxd box;
  const auto accessor = levelSet.getConstAccessor();
  for (auto value = levelSet.cbeginValueOn(); value; ++value)
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Coord next = value.getCoord();
      ++next[axis];
      const double here = *value, there = accessor.getValue(next);
      if ((here < 0) == (there < 0)) continue;
      Vec3d crossing = value.getCoord().asVec3d();
      crossing[axis] += here / (here - there);
      box.expand(levelSet.transform().indexToWorld(crossing));
    }
  return box;
}

std::vector<Placing> fittingPlacings(const std::vector<openvdb::BBoxd>& boxes,
                                     const std::vector<FitKind>& fits) {
  std::vector<Placing> placings(boxes.size());
  for (size_t k = 1; k < boxes.size(); ++k) {
    const double own = longestSide(boxes[k]), first = longestSide(boxes[0]);
    if (fits[k] == FitKind::kNone || !(own > 0) || !(first > 0)) continue;
    const Vec3d middle = boxes[k].getCenter(), to = fits[k] == FitKind::kBox ? boxes[0].getCenter() : middle;
    placings[k].scale = first / own;
    placings[k].move = to - placings[k].scale * middle;
  }
  return placings;
}

Notes notesOnSizes(const std::vector<openvdb::BBoxd>& boxes, const std::vector<FitKind>& fits,
                   const std::vector<std::string>& names) {
  size_t least = 0, most = 0;
  for (size_t k = 0; k < boxes.size(); ++k) {
    if (k > 0 && fits[k] != FitKind::kNone) continue;
    if (longestSide(boxes[k]) < longestSide(boxes[least])) least = k;
    if (longestSide(boxes[k]) > longestSide(boxes[most])) most = k;
  }
  const double small = longestSide(boxes[least]), large = longestSide(boxes[most]);
  if (!(small > 0) || large <= kOtherUnits * small) return {};
  return {{"input.sizes-differ", Severity::kWarning, "",
           "the inputs differ much in size: " + names[least] + " is " + formatNumber(small, 4) + " long, " +
               names[most] + " " + formatNumber(large, 4) +
               " (metres and millimetres?); --fit size brings them to one size, " + names[most] +
               "{scale=" + formatNumber(small / large, 2) + "} scales one of them"}};
}

Note noteOnPlacing(const Placing& placing, const std::string& name) {
  std::string text = "was scaled by " + formatNumber(placing.scale);
  if (placing.rotation != Mat3d::identity()) text += ", turned to the upright axis";
  if (placing.move != Vec3d(0.0))
    text += ", moved by " + formatNumber(placing.move[0]) + "," + formatNumber(placing.move[1]) + "," +
            formatNumber(placing.move[2]);
  return {"input.placed", Severity::kNote, name, text + " (the transform is in the report)"};
}

}  // namespace slicemorph
