#pragma once

#include "engine/sections/place_sections.h"
#include "io/exr/exr_slice_writer.h"
#include "slicemorph/note.h"
#include "tools/job/job_file.h"

#include <string>
#include <vector>

namespace slicemorph {

/// Where slices are cut and how they are written, as typed and checked.
struct SliceOptions {
  SectionOptions section;
  std::string axis = "auto", planeFile;
  std::vector<std::string> planes;
  bool spine = false;
  SliceExrOptions exr;
  std::string prefix;  ///< of the options that say where
  CLI::Option *countGiven = nullptr, *axisGiven = nullptr, *pixelGiven = nullptr, *tilesGiven = nullptr;

  std::vector<PlaneInSpace> given = {};  ///< filled by the check
};

/// `--slices --axis --spine --plane --planes`, their names after a prefix, and `--pixel-size --half
/// --compression
/// --tiles`. Returns them as a job file knows them.
std::vector<JobOption> addSliceOptions(CLI::App& command, SliceOptions& options,
                                       const std::string& prefix = "");
/// Reads the file of planes. Throws InputError naming the option, its value and what would be right, and
/// IoError.
void checkSliceOptions(SliceOptions& options);

/// The planes through all of some grids. `shape`: whose spine leaning slices follow; null without --spine.
/// Says in `notes` where it has none. Throws as the functions of place_sections.h.
std::vector<SectionPlane> placeSlices(const SliceOptions& options, const openvdb::GridCPtrVec& grids,
                                      const FloatGrid::ConstPtr& shape, Notes& notes);

}  // namespace slicemorph
