#pragma once

#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/mesh.h"
#include "tools/job/job_events.h"
#include "tools/job/option_set.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// What `slicemorph reconstruct` is to do. Numbers that are 0 and texts that are empty were not given.
struct ReconstructJob {
  std::string input, output;
  std::shared_ptr<const HeldInput> held;  ///< the input where it is in memory: an image
  int axis = -1;                      ///< array axis along which slices follow each other, 0 to 2; -1: found
  int every = 0;                      ///< every n-th slice is given
  std::vector<int> given;             ///< numbers of the given slices, ascending
  int between = 0;                    ///< all slices are given, and this many are made between every two
  double voxelSize = 0;               ///< of surfaces or grids, world units
  std::string like;                   ///< an image whose voxels a dense label map gets
  MeshSpace space = MeshSpace::kLps;  ///< of meshes
  std::string source, names;          ///< of structures, as StructuresJob has them
  std::optional<std::vector<std::string>> grids;  ///< of EXR slices; none: all
  std::vector<std::string> reports;               ///< .json, .csv
  ImageKind imageKind = ImageKind::kAuto;
  ImageOptions image;
  MemoryLimit memory;
  /// Take what would be written, a map or grey image, and each surface by its name; empty: it is written.
  std::function<void(Image)> takeImage;
  std::function<void(const std::string& name, const Mesh&)> takeSurface;
};

/// Checks the options of `reconstruct`, but not whether files are there or can be written. Throws InputError.
ReconstructJob reconstructJob(const OptionSet& options);

/// Makes a dense label map, masks, structures or closed surfaces from a label map with empty slices, a stack of slices
/// or contours; a dense image from grey slices; grids from EXR slices. Throws InputError, IoError, GeometryError, Cancelled.
void reconstruct(const ReconstructJob& job, JobEvents& events);

}  // namespace slicemorph
