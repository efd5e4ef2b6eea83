#pragma once

#include "slicemorph/io/memory.h"
#include "tools/job/job_events.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What is made of one pair of shapes to show what the program does.
struct DemoJob {
  std::vector<std::string> inputs;  ///< two shapes
  std::string folder;               ///< of all results; it is there
  std::string name;                 ///< of the morph, in names of files
  std::string memory;               ///< as --memory says; empty: its default
};

/// A file or sequence that was made, and what it is.
struct DemoResult {
  std::string path, what;
};

/// Makes a short sequence of VDB files, of meshes and of pictures, a contact sheet, EXR slices of the shape half way and a
/// report. Throws InputError, IoError, GeometryError, Cancelled.
std::vector<DemoResult> runDemo(const DemoJob& job, JobEvents& events);

}  // namespace slicemorph
