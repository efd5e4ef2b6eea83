#include "targets.h"

#include "io/contours/contour_reader.h"
#include "io/contours/csl_reader.h"
#include "io/contours/rtstruct_reader.h"
#include "io/exr/exr_slice_reader.h"
#include "io/format.h"
#include "io/image/image_formats.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/picture_texture.h"
#include "io/paths.h"
#include "io/points/position_file.h"
#include "io/scratch_folder.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/file_info.h"
#include "slicemorph/io/formats.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/memory.h"
#include "slicemorph/io/vdb_reader.h"
#include "tools/job/guidance_file.h"
#include "tools/job/job_file.h"
#include "tools/job/landmarks.h"
#include "tools/job/plan_file.h"
#include "tools/job/plane_file.h"

#include <filesystem>
#include <fstream>

namespace slicemorph::fuzz {
namespace {

void readMeshFile(const std::string& path, std::string_view bytes) {
  formatToRead(path)->readMesh(path, bytes);
}

void readTexture(const std::string&, std::string_view bytes) {
  try {
    textureOfPicture(bytes, {});
  } catch (const PictureProblem&) {
  }
}

MemoryLimit limit() {
  MemoryLimit memory;
  memory.bytes = takenMemory() + kMemory;
  return memory;
}

ImageOptions limited() {
  ImageOptions options;
  options.spacing = {1, 1, 1};
  options.memory = limit();
  return options;
}

void readVolume(const std::string& path, std::string_view) { readImage(parseInput(path), limited()); }

/// Every volume that the file lists, and what insists on one that is uncertain.
void readVolumes(const std::string& path, std::string_view) {
  visitImages(parseInput(path), limited(), 1e6, [](ImageFile) {});
  ImageOptions forced = limited();
  forced.force = true;
  readImage(parseInput(path), forced);
}

void readVdbGrids(const std::string& path, std::string_view) {
  const VdbFile file(path);
  file.compression();
  for (size_t i = 0; i < file.entries().size(); ++i) {
    try {
      if (file.readHeader(i)) file.read(i);
    } catch (const Error&) {  // one that cannot be read does not affect the others
    }
  }
}

void readSlices(const std::string& path, std::string_view) { readSliceExrs(parseInput(path), {}, limit()); }

void readOutlines(const std::string& path, std::string_view) { readContours(path); }

void readJob(const std::string& path, std::string_view bytes) {
  const JobFile file(path, std::string(bytes));
  const std::vector<std::string> inputs = {"a.vdb", "b.vdb"};
  readGuidance(file, inputs);
  readKeys(file, inputs);
}

/// Reads positions and writes the file again with them.
void readPositions(const std::string& path, std::string_view) {
  const PositionFile file(path);
  file.write(std::filesystem::path(path).replace_filename("written" + extensionOf(path)).string(),
             file.positions());
}

void readPointLandmarks(const std::string& path, std::string_view) {
  readLandmarks("--landmarks", path + "," + path, 2);
}

void readPlaneList(const std::string& path, std::string_view) { readPlanes(path); }
void readPlan(const std::string& path, std::string_view) { readPlanFile(path); }
void describe(const std::string& path, std::string_view) { describeFile(parseInput(path), limited()); }

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> table = {
      {"obj", ".obj", readMeshFile},
      {"ply", ".ply", readMeshFile},
      {"stl", ".stl", readMeshFile},
      {"off", ".off", readMeshFile},
      {"glb", ".glb", readMeshFile},
      {"texture", ".png", readTexture},
      {"vdb", ".vdb", readVdbGrids},
      {"exr-slices", ".exr", readSlices},
      {"tiff", ".tif", readVolume},
      {"dicom", ".dcm", readVolumes},
      {"rtstruct", ".dcm", readOutlines},
      {"csl", ".csl", readOutlines},
      {"nifti", ".nii", readVolume},
      {"analyze", ".hdr", readVolume},
      {"nrrd", ".nrrd", readVolume},
      {"metaimage", ".mha", readVolume},
      {"job", ".toml", readJob},
      {"positions-csv", ".csv", readPositions},
      {"positions-ply", ".ply", readPositions},
      {"positions-glb", ".glb", readPositions},
      {"landmarks", ".fcsv", readPointLandmarks},
      {"planes", ".txt", readPlaneList},
      {"plan", ".plan", readPlan},
      {"info-vdb", ".vdb", describe},
  };
  return table;
}

const Target* targetNamed(std::string_view name) {
  for (const Target& target : targets())
    if (name == target.name) return &target;
  return nullptr;
}

void run(const Target& target, std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.file("input" + std::string(target.extension));
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  try {
    target.read(path, bytes);
  } catch (const Error&) {
  }
}

}  // namespace slicemorph::fuzz
