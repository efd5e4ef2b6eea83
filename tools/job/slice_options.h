#pragma once

#include "engine/sections/place_sections.h"
#include "io/exr/exr_slice_writer.h"
#include "slicemorph/note.h"

#include <string>
#include <vector>

namespace slicemorph {

class OptionSet;

/// Where slices are cut and how they are written, as typed and, once checked, parsed.
struct SliceOptions {
  SectionOptions section;
  std::string axis = "auto", planeFile;
  std::vector<std::string> planes;
  bool spine = false;
  SliceExrOptions exr;

  std::vector<PlaneInSpace> given = {};  ///< filled by the check
};

/// The command's slice options, checked; reads the file of planes. `prefix`: of the names of the options that
/// say where slices are cut. Throws InputError naming the option, its value and what would be right; IoError.
SliceOptions checkedSlices(const OptionSet& options, const std::string& prefix = "");

/// The planes that cut all of the grids. `shape`: the slices are across its spine if the options ask for that
/// (else it may be null); if it has no clear spine, `notes` says so and the slices are parallel. Throws as
/// the functions of place_sections.h.
std::vector<SectionPlane> placeSlices(const SliceOptions& options, const openvdb::GridCPtrVec& grids,
                                      const FloatGrid::ConstPtr& shape, Notes& notes);

}  // namespace slicemorph
