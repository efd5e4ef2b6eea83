#pragma once

#include "engine/sections/place_sections.h"
#include "io/exr/exr_slice_writer.h"
#include "slicemorph/note.h"

#include <string>
#include <vector>

namespace slicemorph {

class OptionSet;

/// Where slices are cut and how they are written, as typed and checked.
struct SliceOptions {
  SectionOptions section;
  std::string axis = "auto", planeFile;
  std::vector<std::string> planes;
  bool spine = false;
  SliceExrOptions exr;

  std::vector<PlaneInSpace> given = {};  ///< filled by the check
};

/// The command's slice options, checked; reads the file of planes. `prefix`: of the names of those that say
/// where slices are cut. Throws InputError naming the option, its value and what would be right, and IoError.
SliceOptions checkedSlices(const OptionSet& options, const std::string& prefix = "");

/// The planes through all of some grids. `shape`: whose spine leaning slices follow; null without --spine.
/// Says in `notes` where it has none. Throws as the functions of place_sections.h.
std::vector<SectionPlane> placeSlices(const SliceOptions& options, const openvdb::GridCPtrVec& grids,
                                      const FloatGrid::ConstPtr& shape, Notes& notes);

}  // namespace slicemorph
