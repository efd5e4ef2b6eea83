#include "tools/job/slice_options.h"

#include "engine/spine/fit_spine.h"
#include "slicemorph/errors.h"
#include "tools/job/option_values.h"
#include "tools/job/plane_file.h"

namespace slicemorph {

std::vector<JobOption> addSliceOptions(CLI::App& command, SliceOptions& s, const std::string& prefix) {
  std::vector<JobOption> options;
  const auto remember = [&](const std::string& name, JobType type, CLI::Option* option,
                            const std::string& fallback = "") {
    options.push_back({name, type, option, {}, fallback});
    return option;
  };
  const auto add = [&](const std::string& name, auto& value, JobType type, const std::string& help,
                       const std::string& typeName) {
    const std::string fallback = fallbackOf(value);
    return remember(name, type, command.add_option("--" + name, value, help)->type_name(typeName), fallback);
  };
  const auto flag = [&](const std::string& name, bool& value, const std::string& help) {
    remember(name, JobType::kFlag, command.add_flag("--" + name, value, help));
  };
  CLI::Validator compressions = CLI::IsMember(exrCompressions());
  compressions.description("");
  s.prefix = prefix;
  s.countGiven = add(prefix + "slices", s.section.count, JobType::kInteger, "Slices, 1 to 100000 (64)", "N");
  s.axisGiven = add(prefix + "axis", s.axis, JobType::kText, "Slicing direction; auto: the volume's longest",
                    "auto|x|y|z|DX,DY,DZ");
  flag(prefix + "spine", s.spine, "Slices lean: they stand across the shape's own curved axis");
  add(prefix + "plane", s.planes, JobType::kTexts,
      "Slice here: a point and a normal, world units; may be given again", "OX,OY,OZ/NX,NY,NZ")
      ->allow_extra_args(false);
  add(prefix + "planes", s.planeFile, JobType::kText,
      "Slice on the planes of a text or CSV file: ox oy oz nx ny nz a line", "FILE");
  s.pixelGiven = add("pixel-size", s.section.pixelSize, JobType::kNumber,
                     "Edge of a slice's pixel, world units (one voxel)", "H");
  flag("half", s.exr.halfFloat, "Slices in 16-bit floats; whole numbers keep 32 bits");
  add("compression", s.exr.compression, JobType::kText,
      "Of the slices' EXR files (zip); from pxr24 on values lose precision",
      "none|rle|zips|zip|piz|pxr24|b44|b44a|dwaa|dwab")
      ->check(compressions);
  s.tilesGiven = add("tiles", s.exr.tile, JobType::kInteger,
                     "Slices in tiles of N x N pixels, 8 to 65536 (scan lines)", "N");
  return options;
}

void checkSliceOptions(SliceOptions& s) {
  const std::string name = "--" + s.prefix;
  checkRange(name + "slices", s.section.count, 1, 100000);
  if (s.pixelGiven->count()) checkPositive("--pixel-size", s.section.pixelSize);
  if (s.tilesGiven->count()) checkRange("--tiles", s.exr.tile, 8, 65536);
  if (s.axis != "auto") s.section.axis = parseDirection(name + "axis", s.axis);
  s.given.clear();
  if (!s.planeFile.empty()) s.given = readPlanes(s.planeFile);
  for (const std::string& plane : s.planes) s.given.push_back(parsePlane(name + "plane", plane));
  const int ways = int(!s.given.empty()) + int(s.spine) + int(s.axisGiven->count() > 0);
  if (ways > 1)
    throw InputError(name + "axis, " + name + "spine and " + name + "plane or " + name +
                     "planes exclude each other");
  if (!s.given.empty() && s.countGiven->count())
    throw InputError(name + "slices " + std::to_string(s.section.count) +
                     ": the planes are given, their number too");
}

std::vector<SectionPlane> placeSlices(const SliceOptions& s, const openvdb::GridCPtrVec& grids,
                                      const FloatGrid::ConstPtr& shape, Notes& notes) {
  if (!s.given.empty()) return sectionPlanesAt(s.given, grids, s.section.pixelSize);
  if (s.spine) {
    if (const auto spine = fitSpine(DistanceField(shape)))
      return sectionPlanesAlong(spine->chart, grids, s.section.count, s.section.pixelSize);
    notes.push_back("the shape has no clear axis of its own: the slices are parallel");
  }
  return sectionPlanes(grids, s.section);
}

}  // namespace slicemorph
