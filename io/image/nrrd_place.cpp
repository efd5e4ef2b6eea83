#include "io/image/nrrd_place.h"

#include "io/image/chosen_volume.h"
#include "io/image/length_unit.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

void tell(NrrdHeader& header, const char* code, Severity severity, const std::string& text) {
  header.file.notes.emplace_back(code, severity, "", text);
}

/// How the coordinates of a space become LPS.
struct SpaceMeaning {
  Vec3d sign{1, 1, 1};
  bool time = false;    ///< its last coordinate is time
  std::string assumed;  ///< what is assumed where the name leaves it open
};

SpaceMeaning meaningOf(const Nrrd& nrrd) {
  switch (nrrd.space) {
    case nrrdSpaceRightAnteriorSuperiorTime:
      return {{-1, -1, 1}, true, ""};
    case nrrdSpaceRightAnteriorSuperior:
      return {{-1, -1, 1}, false, ""};
    case nrrdSpaceLeftAnteriorSuperiorTime:
      return {{1, -1, 1}, true, ""};
    case nrrdSpaceLeftAnteriorSuperior:
      return {{1, -1, 1}, false, ""};
    case nrrdSpaceLeftPosteriorSuperiorTime:
      return {{1, 1, 1}, true, ""};
    case nrrdSpaceLeftPosteriorSuperior:
      return {};
    case nrrdSpaceScannerXYZTime:
    case nrrdSpaceScannerXYZ:
      return {{1, 1, 1},
              nrrd.space == nrrdSpaceScannerXYZTime,
              "is the scanner's: its axes are taken as left, back, up, as of a patient who lies face up, "
              "head first"};
    case nrrdSpace3DRightHandedTime:
    case nrrdSpace3DRightHanded:
      return {{1, 1, 1},
              nrrd.space == nrrdSpace3DRightHandedTime,
              "does not say where the patient lies: its axes are taken as left, back, up"};
    case nrrdSpace3DLeftHandedTime:
    case nrrdSpace3DLeftHanded:
      return {{1, 1, -1},
              nrrd.space == nrrdSpace3DLeftHandedTime,
              "does not say where the patient lies: its axes are taken as left, back, down (a left-handed "
              "space; with "
              "up it would be mirrored)"};
    default:
      return {{1, 1, 1}, false, "has no name: its axes are taken as left, back, up"};
  }
}

/// What the steps along an axis are in space; false: it is no axis of space.
bool stepOf(const std::string& path, const Nrrd& nrrd, unsigned axis, const SpaceMeaning& space,
            Vec3d& step) {
  const double* direction = nrrd.axis[axis].spaceDirection;
  const unsigned spatial = nrrd.spaceDim - unsigned(space.time);
  step = Vec3d(0.0);
  if (std::isnan(direction[0])) return false;
  for (unsigned c = 0; c < spatial; ++c) step[int(c)] = direction[c];
  const bool inTime = space.time && direction[spatial] != 0;
  if (inTime && step.length() > 0)
    throw IoError(path, "its axis " + std::to_string(axis) + " runs through space and time at once");
  return !inTime;
}

/// Factors that make the coordinates of the space millimetres.
Vec3d unitsOf(NrrdHeader& header, const Nrrd& nrrd, unsigned spatial) {
  Vec3d factor(1.0);
  std::vector<std::string> units;
  for (unsigned c = 0; c < spatial; ++c) units.emplace_back(nrrd.spaceUnits[c] ? nrrd.spaceUnits[c] : "");
  for (unsigned c = 0; c < spatial; ++c) factor[int(c)] = millimetresOf(units[c]).value_or(1);
  noteUnits(units, header.file.notes);
  return factor;
}

/// Sets lattice and axes of an image whose axes have directions.
void placeByDirections(const std::string& path, const NrrdText& text, const Nrrd& nrrd, NrrdHeader& header) {
  const SpaceMeaning space = meaningOf(nrrd);
  const unsigned spatial = nrrd.spaceDim - unsigned(space.time);
  if (nrrd.spaceDim > 4 || spatial > 3)
    throw IoError(path, "its space has " + std::to_string(nrrd.spaceDim) + " dimensions; images have 2 or 3");
  if (!space.assumed.empty()) {
    const std::string name = text.field("space");
    tell(header, "image.space-unknown", Severity::kWarning,
         "its space " + (name.empty() ? "" : "'" + name + "' ") + space.assumed);
  }
  const Vec3d unit = unitsOf(header, nrrd, spatial);
  ImageLattice& lattice = header.file.image.lattice;
  size_t found = 0;
  for (unsigned a = 0; a < nrrd.dim; ++a) {
    Vec3d step;
    header.axes.push_back({nrrd.axis[a].size, stepOf(path, nrrd, a, space, step)});
    if (!header.axes.back().domain) continue;
    if (found < 3) lattice.step[found] = step * unit * space.sign;
    ++found;
  }
  if (found == 0 || found > 3)
    throw IoError(path, "has " + std::to_string(found) + " axes in space; images have 2 or 3");
  const bool placed = !std::isnan(nrrd.spaceOrigin[0]);
  for (unsigned c = 0; c < spatial && placed; ++c)
    lattice.origin[int(c)] = nrrd.spaceOrigin[c] * unit[int(c)] * space.sign[int(c)];
  if (!placed)
    tell(header, "image.place-unknown", Severity::kWarning,
         "it does not say where it lies (no 'space origin'): its first voxel is placed at 0, 0, 0");
  addFlatAxes(lattice, found);
}

bool isDomainKind(int kind) {
  return kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace;
}

/// Distance of samples and place of the first one along an axis without a direction.
struct AxisPlace {
  double spacing = 1, first = 0;
  bool told = false;
};
AxisPlace placeOfAxis(const NrrdAxisInfo& axis) {
  AxisPlace place;
  const bool cells = axis.center == nrrdCenterCell;
  const bool range = std::isfinite(axis.min) && std::isfinite(axis.max) && axis.max > axis.min;
  if (std::isfinite(axis.spacing) && axis.spacing != 0)
    place.spacing = axis.spacing, place.told = true;
  else if (range && (cells || axis.size > 1))
    place.spacing = (axis.max - axis.min) / double(cells ? axis.size : axis.size - 1), place.told = true;
  if (std::isfinite(axis.min))
    place.first = axis.min + (axis.center == nrrdCenterCell ? place.spacing / 2 : 0);
  return place;
}

/// The unit of a space's coordinate; empty: not told.
std::string unitOfSpace(const Nrrd& nrrd, unsigned coordinate) {
  const bool told = coordinate < nrrd.spaceDim && nrrd.spaceUnits[coordinate];
  return told ? nrrd.spaceUnits[coordinate] : "";
}

/// The same of an image that has spacings, or not even these. Units of its axes count for its origin, and those of its
/// space for the axes, where only one of them is told.
void placeBySpacings(const std::string& path, const NrrdText& text, const Nrrd& nrrd, NrrdHeader& header) {
  ImageLattice& lattice = header.file.image.lattice;
  size_t found = 0;
  bool told = true;
  std::vector<std::string> units;
  for (unsigned a = 0; a < nrrd.dim; ++a) {
    const NrrdAxisInfo& axis = nrrd.axis[a];
    header.axes.push_back({axis.size, isDomainKind(axis.kind) && found < 3});
    if (!header.axes.back().domain) continue;
    const AxisPlace place = placeOfAxis(axis);
    units.push_back(axis.units && *axis.units ? axis.units
                    : place.told              ? unitOfSpace(nrrd, unsigned(found))
                                              : "");
    const double unit = millimetresOf(units.back()).value_or(1);
    told &= place.told;
    lattice.step[found] = Vec3d(0.0);
    lattice.step[found][int(found)] = place.spacing * unit;
    lattice.origin[int(found)] = place.first * unit;
    ++found;
  }
  if (found == 0) throw IoError(path, "has no axis in space");
  const std::string space = text.field("space");
  const bool leftHanded = nrrd.space == nrrdSpace3DLeftHanded || nrrd.space == nrrdSpace3DLeftHandedTime;
  addFlatAxes(lattice, found);
  if (nrrd.spaceDim > 0 && !std::isnan(nrrd.spaceOrigin[0])) {
    const SpaceMeaning meaning = meaningOf(nrrd);
    for (unsigned c = 0; c < std::min(nrrd.spaceDim, 3u); ++c) {
      const std::string own = unitOfSpace(nrrd, c),
                        unit = own.empty() ? units[std::min<size_t>(c, found - 1)] : own;
      lattice.origin[int(c)] = nrrd.spaceOrigin[c] * millimetresOf(unit).value_or(1) * meaning.sign[int(c)];
      units.push_back(unit);
    }
  }
  noteUnits(units, header.file.notes);
  if (leftHanded) lattice.step[2] = -lattice.step[2];
  if (nrrd.space != nrrdSpaceUnknown) {
    tell(header, "image.space-without-directions", Severity::kWarning,
         "its space '" + space +
             "' comes with spacings alone: voxels are placed by these, axes as left, back, " +
             (leftHanded ? "down (a left-handed space; with up it would be mirrored)" : "up"));
  } else {
    tell(header, "image.place-unknown", Severity::kWarning,
         std::string("it does not say where the patient lies (no 'space directions'): ") +
             (told ? "taken from its spacings" : "without spacings, voxels of 1 mm") +
             ", axes as left, back, up");
  }
}

}  // namespace

void placeNrrd(const std::string& path, const NrrdText& text, const Nrrd& nrrd, NrrdHeader& header) {
  if (text.hasDirections())
    placeByDirections(path, text, nrrd, header);
  else
    placeBySpacings(path, text, nrrd, header);
}

}  // namespace slicemorph
