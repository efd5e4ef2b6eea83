#pragma once

#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/note.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

struct StoredMesh;
struct ImageFile;
struct ImageOptions;
struct ImageSlices;
struct VdbOutput;
struct Voxels;
struct VoxelHead;
struct ContourFile;
struct StructureSet;

/// Whether a file or folder is of a format, by its name or its content. It need not exist.
using Recogniser = bool (*)(const std::string& path);
/// `bytes`: the whole file. Throws IoError naming `path` where it is cut short or damaged.
using MeshReader = StoredMesh (*)(const std::string& path, std::string_view bytes);
/// Writes a file whole or not at all. Throws IoError.
using MeshWriter = void (*)(const std::string& path, const Mesh& mesh, MeshSpace space);
/// Writes a file whole or not at all. Throws InputError for a grid that the format cannot hold, and IoError.
using GridWriter = void (*)(const std::string& path, const openvdb::GridCPtrVec& grids,
                            const VdbOutput& options);
using ImageReader = ImageFile (*)(const InputSpec& input, const ImageOptions& options);
using ImageVisitor = std::function<void(ImageFile image)>;
/// Hands out all images that an input may mean where it selects none, one after the other; those of more than
/// `mostVoxels` without values where headers alone tell of them.
using ImageLister = void (*)(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                             const ImageVisitor& visit);
/// Nothing where a file cannot be read slice by slice.
using SliceOpener = std::optional<ImageSlices> (*)(const InputSpec& input, const ImageOptions& options);
/// What a file of voxels begins with. Throws InputError where the format cannot hold them.
using VoxelHeader = VoxelHead (*)(const std::string& path, const Voxels& voxels);
using ContourReader = ContourFile (*)(const std::string& path);
/// As writeStructures.
using StructureWriter = Notes (*)(const std::string& path, const StructureSet& set);

/// A row of the table of formats. Functions that are null are not supported.
struct Format {
  std::string name;
  Contents contents = Contents::kUnknown;
  std::vector<std::string> reads, writes;  ///< extensions, lower case, with the dot
  std::string help;                        ///< one line
  std::string listed;                      ///< shown instead of `reads` in lists of readable formats
  Recogniser recognise = nullptr;          ///< null: by the extensions in `reads`
  MeshReader readMesh = nullptr;
  MeshWriter writeMesh = nullptr;
  GridWriter writeGrids = nullptr;
  ImageReader readImage = nullptr;
  ImageLister listImages = nullptr;  ///< null: there is one image, that of readImage
  SliceOpener openSlices = nullptr;
  VoxelHeader voxelHead = nullptr;
  ContourReader readContours = nullptr;
  StructureWriter writeStructures = nullptr;  ///< of formats that hold named structures
};

/// The table of formats; a path is of the first row that recognises it.
const std::vector<Format>& formats();

/// The format of a path to read or write; null where none is known.
const Format* formatToRead(const std::string& path);
const Format* formatToWrite(const std::string& path);

/// Throws IoError where there is no such file, else InputError, which lists the formats that can be read.
[[noreturn]] void refuseAsShape(const InputSpec& input);

}  // namespace slicemorph
