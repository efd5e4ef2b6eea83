#pragma once

#include "io/points/gltf_positions.h"
#include "slicemorph/conventions.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// Extensions of files whose positions can be replaced: `.obj .ply .off .glb .csv .txt .pts .fcsv`.
const std::vector<std::string>& positionExtensions();
/// The same as a text.
std::string positionList();

/// A file of positions: the points of a mesh or curve (.obj, .ply, .off, .glb), the rows of a table (.csv with columns x, y and
/// z, or whose first three columns of numbers are these), landmarks (.fcsv of 3D Slicer; anything else: one point per
/// line, x y z and perhaps a label, headers of elastix point files are known). It can be written again with other
/// positions and everything else, in the same order, byte by byte as it was (of .glb: with the same meaning).
class PositionFile {
 public:
  /// Throws IoError where the file is missing, cut short or damaged, InputError where it holds no positions; both name
  /// the line.
  explicit PositionFile(const std::string& path);

  /// In the order of the file; world units. Of .fcsv files in RAS, in LPS.
  const std::vector<Vec3d>& positions() const { return positions_; }
  /// Whether the file has normals, which other positions make wrong.
  bool hasNormals() const { return normals_; }

  /// Writes the file with these positions, one per old one, whole or not at all: numbers of text with ten
  /// significant digits, binary ones in their own type. Throws InputError where the extension of `path` is not the
  /// file's own, IoError.
  void write(const std::string& path, const std::vector<Vec3d>& positions) const;

  /// Where a coordinate stands.
  struct Field {
    size_t at;      ///< byte
    size_t length;  ///< bytes; 4 or 8 where binary
    int axis;       ///< 0 to 2
  };

 private:
  friend class PositionScanner;
  std::string path_, bytes_;
  std::vector<Vec3d> positions_;
  std::shared_ptr<const GltfPositions> gltf_;  ///< of .glb, whose positions are not in `fields_`
  std::vector<Field> fields_;                  ///< three per position, in the order of the file
  bool binary_ = false, bigEndian_ = false, ras_ = false, normals_ = false;
};

}  // namespace slicemorph
