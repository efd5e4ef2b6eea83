#include "io/image/nrrd_header.h"

#include "io/image/chosen_volume.h"
#include "io/image/length_unit.h"
#include "io/image/nrrd_text.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <NrrdIO.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <sstream>

namespace slicemorph {
namespace {

struct FreeNrrd {
  void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
  void operator()(NrrdIoState* state) const { nrrdIoStateNix(state); }
};
using NrrdPointer = std::unique_ptr<Nrrd, FreeNrrd>;

/// The library's last word on what went wrong, without the names of its functions.
std::string reasonOfNrrd() {
  const std::unique_ptr<char, decltype(&std::free)> text(biffGetDone("nrrd"), &std::free);
  std::string last;
  std::istringstream lines(text ? text.get() : "");
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t") != std::string::npos) last = line;
  const size_t mark = last.find(": ");
  if (last.compare(0, 1, "[") == 0 && mark != std::string::npos) last.erase(0, mark + 2);
  return last;
}

NrrdPointer parsed(const std::string& path, const NrrdText& text) {
  NrrdPointer nrrd(nrrdNew());
  const std::unique_ptr<NrrdIoState, FreeNrrd> state(nrrdIoStateNew());
  state->skipData = 1;
  if (nrrdStringRead(nrrd.get(), text.rest.c_str(), state.get()))
    throw IoError(path, "its NRRD header cannot be read: " + reasonOfNrrd());
  return nrrd;
}

RawType rawTypeOfNrrd(const std::string& path, const Nrrd& nrrd) {
  switch (nrrd.type) {
    case nrrdTypeChar:
      return {1, RawType::kSigned};
    case nrrdTypeUChar:
      return {1, RawType::kUnsigned};
    case nrrdTypeShort:
      return {2, RawType::kSigned};
    case nrrdTypeUShort:
      return {2, RawType::kUnsigned};
    case nrrdTypeInt:
      return {4, RawType::kSigned};
    case nrrdTypeUInt:
      return {4, RawType::kUnsigned};
    case nrrdTypeLLong:
      return {8, RawType::kSigned};
    case nrrdTypeULLong:
      return {8, RawType::kUnsigned};
    case nrrdTypeFloat:
      return {4, RawType::kFloat};
    case nrrdTypeDouble:
      return {8, RawType::kFloat};
    default:
      throw IoError(path, "its voxels are blocks of bytes; only numbers can be read");
  }
}

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

void describeVolumes(const std::string& path, const Nrrd& nrrd, NrrdHeader& header) {
  ImageFile& file = header.file;
  const double most = double(std::int64_t(1) << 40);
  double all = 1, volumes = 1;
  size_t found = 0;
  for (unsigned a = 0; a < nrrd.dim; ++a) {
    const NrrdAxisInfo& axis = nrrd.axis[a];
    all *= double(axis.size);
    if (!(all <= most) || axis.size > size_t(1) << 30)
      throw IoError(path, "its size along axis " + std::to_string(a) + ", " + std::to_string(axis.size) +
                              ", makes no sense");
    if (header.axes[a].domain) {
      file.image.lattice.size[int(found++)] = int(axis.size);
      continue;
    }
    volumes *= double(axis.size);
    if (axis.size == 1) continue;
    const std::string label = axis.label ? axis.label : "";
    header.volumeKinds.push_back(axis.kind != nrrdKindUnknown ? airEnumStr(nrrdKind, axis.kind)
                                 : label.empty()              ? "values"
                                                              : label);
    if ((axis.kind == nrrdKindRGBColor && axis.size == 3) ||
        (axis.kind == nrrdKindRGBAColor && axis.size == 4))
      header.colours = int(a);
  }
  file.volumes = int(std::min(volumes, double(1 << 30)));
}

DataFiles dataOfNrrd(const std::string& path, const NrrdText& text) {
  DataFiles data;
  const std::string encoding = lowered(text.field("encoding"));
  const std::pair<const char*, DataFiles::Encoding> names[] = {
      {"raw", DataFiles::kRaw},    {"text", DataFiles::kText},   {"txt", DataFiles::kText},
      {"ascii", DataFiles::kText}, {"hex", DataFiles::kHex},     {"gzip", DataFiles::kGzip},
      {"gz", DataFiles::kGzip},    {"bzip2", DataFiles::kBzip2}, {"bz2", DataFiles::kBzip2},
  };
  const auto* known = std::find_if(std::begin(names), std::end(names),
                                   [&](const auto& row) { return encoding == row.first; });
  if (known == std::end(names))
    throw IoError(path,
                  "its encoding '" + encoding + "' is not known; there are raw, text, hex, gzip and bzip2");
  data.encoding = known->second;
  const std::string given = text.field("data file");
  data.files = given.empty() ? std::vector<std::string>{path} : namedDataFiles(path, given, text.dataFiles);
  if (given.empty()) data.from = text.end;
  data.bigEndian = lowered(text.field("endian")) == "big";
  const auto number = [&](const char* name) {
    const std::string value = text.field(name);
    if (value.empty()) return 0L;
    char* end = nullptr;
    const long skipped = std::strtol(value.c_str(), &end, 10);
    if (*end || skipped < -1)
      throw IoError(path, "its " + std::string(name) + " '" + value + "' makes no sense");
    return skipped;
  };
  data.byteSkip = number("byte skip");
  data.lineSkip = std::uint64_t(std::max(0L, number("line skip")));
  if (data.byteSkip < 0 && data.encoding != DataFiles::kRaw)
    throw IoError(path, "its byte skip -1 needs the encoding raw, not " + encoding);
  return data;
}

}  // namespace

NrrdHeader readNrrdHeader(const std::string& path) {
  const NrrdText text = readNrrdText(path);
  const NrrdPointer nrrd = parsed(path, text);
  NrrdHeader header;
  header.file.format = "NRRD";
  if (nrrd->content) header.file.about = nrrd->content;
  header.type = rawTypeOfNrrd(path, *nrrd);
  if (text.hasDirections())
    placeByDirections(path, text, *nrrd, header);
  else
    placeBySpacings(path, text, *nrrd, header);
  if (!text.dropped.empty())
    tell(header, "image.header-repaired", Severity::kNote,
         "its header has " + text.dropped + " beside 'space directions', which the format forbids: not used");
  describeVolumes(path, *nrrd, header);
  checkPlace(path, header.file.image.lattice);
  header.data = dataOfNrrd(path, text);
  return header;
}

}  // namespace slicemorph
