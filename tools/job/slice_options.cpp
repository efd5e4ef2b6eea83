#include "tools/job/slice_options.h"

#include "engine/spine/fit_spine.h"
#include "slicemorph/errors.h"
#include "tools/job/option_set.h"
#include "tools/job/option_values.h"
#include "tools/job/plane_file.h"

namespace slicemorph {

SliceOptions checkedSlices(const OptionSet& options, const std::string& prefix) {
  SliceOptions s = options.values().slices;
  const std::string axis = prefix + "axis", plane = prefix + "plane", planes = prefix + "planes";
  if (s.axis != "auto")
    s.section.axis = options.about(axis, [&] { return parseDirection("--" + axis, s.axis); });
  // --print-config reads no files.
  if (!s.planeFile.empty() && !options.values().printConfig)
    s.given = options.about(planes, [&] { return readPlanes(s.planeFile); });
  for (const std::string& text : s.planes)
    s.given.push_back(options.about(plane, [&] { return parsePlane("--" + plane, text); }));
  return s;
}

std::vector<SectionPlane> placeSlices(const SliceOptions& s, const openvdb::GridCPtrVec& grids,
                                      const FloatGrid::ConstPtr& shape, Notes& notes) {
  if (!s.given.empty()) return sectionPlanesAt(s.given, grids, s.section.pixelSize);
  if (s.spine) {
    if (const auto spine = fitSpine(DistanceField(shape)))
      return sectionPlanesAlong(spine->chart, grids, s.section.count, s.section.pixelSize);
    notes.emplace_back("slice.no-spine", Severity::kWarning, "--spine",
                       "the shape has no clear axis of its own: the slices are parallel");
  }
  return sectionPlanes(grids, s.section);
}

}  // namespace slicemorph
