#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/note.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What a file holds and how loadObject would read it: plain data for `slicemorph info`.
namespace slicemorph {

struct MeshInfo {
  size_t points = 0, faces = 0;  ///< as stored; a face may have any number of corners
  size_t shells = 0;             ///< connected parts, exact duplicate points welded
  size_t boundaryEdges = 0, boundaryLoops = 0, nonManifoldEdges = 0;
  bool closed = false;                     ///< every edge has exactly two faces
  Vec3d boxMin{0, 0, 0}, boxMax{0, 0, 0};  ///< world units
  std::string colors;       ///< what has colours: "points", "faces", "materials"; empty: nothing
  double signedVolume = 0;  ///< world units cubed, of the faces as stored; meaningful for closed meshes
  Notes notes;              ///< what repair does on reading, one sentence each
  std::string problem;      ///< why the mesh would be refused; empty: it is accepted
};

struct GridInfo {
  std::string name;       ///< as `file.vdb:name` selects it: `density[1]` where a name comes more than once
  std::string type;       ///< OpenVDB's value type: "float", "half"-saved grids too, "vec3s", "int32" ...
  std::string gridClass;  ///< "level set", "fog volume", "staggered", "unknown"
  std::uint64_t activeVoxels = 0;  ///< counted for scalars, else as the file states it, 0 where it does not
  Vec3d voxelSize{0, 0, 0};        ///< world units
  bool rotated = false;            ///< rotated, sheared or mirrored: axes not parallel to the world's
  bool uniform = true;             ///< all three voxel sides are equal
  Vec3d boxMin{0, 0, 0}, boxMax{0, 0, 0};  ///< active voxels, world units; equal where the grid is empty
  bool halfFloat = false;
  bool scalar = false;                              ///< background, minimum and maximum below mean something
  double background = 0, minimum = 0, maximum = 0;  ///< minimum and maximum over the active values
  std::string reading;  ///< how it is read: "level set, as it is", "fog volume, surface at 0.5", ...
  std::string problem;  ///< why it cannot be read as a shape; empty: it can
};

struct VdbInfo {
  unsigned fileVersion = 0;     ///< of the file format, for example 224
  std::string libraryVersion;   ///< of the OpenVDB that wrote it, for example "10.0"
  std::vector<GridInfo> grids;  ///< in the order of the file
  std::string chosen;           ///< the grid read when none is named; empty: none can be
  std::string why;              ///< what made it the chosen one of several, part of a sentence
};

/// One image of a file or a folder.
struct ImageInfo {
  std::string name;           ///< as an input selects it, for example `folder:2`
  std::string format, about;  ///< "NIfTI" ...; what the file says of itself
  /// Of its values as read: "uint8", "int16", "uint16", "int32", "float", "double"; empty: it is refused.
  std::string type;
  openvdb::Coord size{0, 0, 0};
  Vec3d spacing{0, 0, 0}, origin{0, 0, 0};  ///< LPS millimetres; origin: centre of the first voxel
  Vec3d axes[3];                            ///< unit directions of i, j, k
  int volumes = 1;                          ///< times or components in the file
  bool placed = true;               ///< it is known where it lies; else spacing, origin and axes mean nothing
  bool looked = true;               ///< values were read; else minimum, maximum and labels mean nothing
  double minimum = 0, maximum = 0;  ///< of the finite values
  size_t labels = 0;                ///< of a label map; 0: grey values
  Notes notes;
  std::string reading;  ///< how it is read as a shape
};

/// One structure of a file of contours.
struct StructureInfo {
  int number = 0;  ///< of a region of interest, or a label
  std::string name;
  size_t planes = 0, contours = 0;  ///< planes with contours
  double gap = 0, gapMin = 0,
         gapMax = 0;             ///< between neighbouring planes, world units: usual, least, most; 0: none
  std::optional<double> volume;  ///< world units cubed, of the slabs around parallel planes; none of others
  Vec3d boxMin{0, 0, 0}, boxMax{0, 0, 0};  ///< of the points, world units
};

struct FileInfo {
  Contents contents = Contents::kMesh;    ///< mesh, grids, image or contours
  std::string path;                       ///< without a `:grid` suffix
  std::string format;                     ///< "obj", "ply", "stl", "off", "glb", "vdb", "nifti" ...
  std::uint64_t bytes = 0;                ///< file size
  MeshInfo mesh;                          ///< of meshes
  std::vector<ImageInfo> images;          ///< of images: the series of a folder, else one
  std::vector<StructureInfo> structures;  ///< of contours
  Notes notes;                            ///< of contours: what was left out or repaired
  VdbInfo vdb;  ///< of grids; of one grid only where the path names one (`file.vdb:grid`)
};

/// Describes a file without voxelising it. One unreadable grid does not hide the others: its `problem` says
/// why. Throws IoError and InputError as loadObject does where the file as a whole cannot be read.
FileInfo describeFile(const InputSpec& input, const ImageOptions& options = {});

}  // namespace slicemorph
