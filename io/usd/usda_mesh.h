#pragma once

#include "io/scratch_folder.h"
#include "io/usd/usda_text.h"
#include "slicemorph/mesh.h"

#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// Writes a mesh as the one Mesh of a `.usda` stage: no subdivision, vertex normals, colours as
/// `primvars:displayColor` as they are, what was taken out of far points (Mesh::origin) as a translation. The file
/// appears whole or not at all. Throws IoError.
void writeUsdaMesh(const std::string& path, const Mesh& mesh, const UsdaStage& stage);

/// Writes a sequence of meshes as one Mesh with time samples of all that it has: points, faces, normals, colours,
/// velocities, extent. The samples' text goes into files among the system's temporary ones, an attribute each, since
/// in the stage those of an attribute follow each other; no frame is kept in memory.
class UsdaMeshWriter {
 public:
  /// Throws IoError.
  UsdaMeshWriter(const std::string& path, const UsdaStage& stage);
  ~UsdaMeshWriter();

  /// Adds a frame; numbers ascend. `velocities`: per point, world units per second; empty: none are known.
  /// Throws IoError.
  void add(int number, const Mesh& mesh, const std::vector<openvdb::Vec3s>& velocities);
  /// Writes the file, whole or not at all. Throws IoError.
  void commit();

 private:
  struct Samples;

  std::string path_;
  UsdaStage stage_;
  ScratchFolder scratch_;
  std::vector<std::unique_ptr<Samples>> samples_;  ///< of each attribute
  std::optional<std::pair<int, int>> frames_;
  std::optional<Vec3d> origin_;  ///< of the first mesh that has points; it is taken out of all others, too
};

}  // namespace slicemorph
