#pragma once

#include "slicemorph/errors.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/memory.h"
#include "slicemorph/io/nothing.h"
#include "slicemorph/io/placing.h"
#include "slicemorph/io/vdb_reader.h"
#include "slicemorph/note.h"
#include "slicemorph/slicemorph.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// What the values of an image mean; kAuto: integers from 0 that mostly equal their neighbours are labels.
enum class ImageKind { kAuto, kGrey, kLabels };

struct LoadOptions {
  double voxelSize = 0;  ///< world units; 0: `resolution` for meshes, their own for VDBs
  int resolution = 0;    ///< voxels along the longest side, 8 to 4096; 0: 256 for meshes, their own for VDBs
  double shell = 0;  ///< world units: thickness of a mesh's shells that enclose nothing; 0: they are left out
  double iso = 0;    ///< the surface's value in a VDB grid or grey image; 0: found in fog and images
  std::vector<double> furtherIsos;  ///< of an image: surfaces that steer the map beside the one at `iso`
  bool isoGiven = false;            ///< `iso` holds even if it is 0
  /// Per input, if they differ: `iso`, then `furtherIsos`. See optionsOfInput.
  std::vector<std::vector<double>> isosByInput;
  ImageKind imageKind = ImageKind::kAuto;
  ImageOptions image;
  int fogResolution =
      0;  ///< most voxels along the longest side of the shape found in fog; 0: as many as the fog has
  /// Other VDB files of the same simulation: what is the same in all of them is no shape (gridCandidates).
  std::vector<std::string> besides;
  bool movingOnly = false;  ///< static grids are no shapes, also where there is nothing else
  MemoryLimit memory;
  Placing placing;       ///< after that of the input's own name
  bool density = false;  ///< the object keeps the density that its shape was found in, see Object::density
  bool matching =
      false;  ///< the shape is to be matched: what lies many times its size away is left out of it
};

/// The options with the iso values of one input (index from 0) set from `isosByInput`.
LoadOptions optionsOfInput(const LoadOptions& options, size_t input);

struct LoadedObject {
  Object object;
  bool halfFloat = false;               ///< the input grid was stored as half floats
  Notes notes;                          ///< what was repaired, chosen or converted, one sentence each
  bool fog = false;                     ///< the shape is that of a fog volume
  std::shared_ptr<const VdbFile> file;  ///< null for meshes
  static constexpr size_t kNoGrid = size_t(-1);
  size_t grid = 0;       ///< index in the file of the grid that the shape is taken from; kNoGrid: a
                         ///< file of a sequence that holds nothing lacks that grid
  std::string gridName;  ///< its name, without a number; empty: not from a VDB
  bool doubles = false;  ///< that grid holds doubles
  bool named = false;    ///< that grid was asked for by name
  /// The file holds nothing, and the shape stands for where something will be, or was: see asNothing().
  bool nothing = false;
  std::shared_ptr<const Image> image;  ///< null for meshes and VDBs
  ImageHeader imageHeader;             ///< of that image's file
  Placing placing;                     ///< what was done to all of it
  bool labels = false;                 ///< the image is a map of labels; the shape is that of all of them
  double iso = 0;                      ///< the surface's value in a grey image
  openvdb::Vec3SGrid::ConstPtr colors =
      nullptr;  ///< of the shape's surface, on its level set's active voxels; null: it has none
};

/// Reads one input as a level set: a mesh, a grid of a VDB, an image. The surface of a grey image is at
/// `iso`, else at its Otsu value [Ots79]; its voxel size is the smallest spacing, but at most 256 voxels go
/// along the longest side. Throws IoError (missing, unreadable, truncated, not of its format), InputError
/// (extension, grid name, voxel size), GeometryError (open, not orientable), NothingError, MemoryError (before it
/// takes the memory). Every error's note is about the file.
LoadedObject loadObject(const InputSpec& input, const LoadOptions& options = {});
LoadedObject loadObject(const std::string& text, const LoadOptions& options = {});

/// The name of the grid of a shape that is made from these: that of the first input that is a level set of a VDB, else
/// `surface`.
std::string surfaceNameOf(const std::vector<LoadedObject>& inputs);

/// A file of a sequence that holds nothing, beside `piece`, the nearest one that holds something: its shape is that of
/// the fog there, or a ball of two voxels inside the solid there, so that what is there can grow out of it; its grids
/// are the file's own. Throws IoError.
LoadedObject asNothing(const LoadedObject& piece, const InputSpec& file);

/// If all objects are label maps, gives each the surfaces of the labels that more than one of them has, of at
/// most 24 labels, those of the largest volume.
void addLabelSurfaces(std::vector<LoadedObject>& objects);

}  // namespace slicemorph
