#pragma once

#include <string>
#include <vector>

namespace slicemorph {

/// What kind of data a file holds.
enum class Contents {
  kUnknown,
  kMesh,        ///< a surface of polygons
  kGrids,       ///< level sets, fog volumes and other grids
  kImage,       ///< voxels on a lattice: scans, label maps, stacks of pictures
  kContours,    ///< closed curves on planes
  kSlices,      ///< oriented slices of grids
  kStructures,  ///< named structures on the slices of a scan; only written
};

/// A row of the table of formats (io/format.h), from which reading, writing, messages and help
/// texts are made.
struct Format;

/// A format as the table describes it.
struct FormatSummary {
  std::string name;  ///< as FileInfo names it: "obj", "vdb", "nifti"
  Contents contents = Contents::kUnknown;
  std::vector<std::string> reads;   ///< extensions, lower case, with the dot; none: it is only written
  std::vector<std::string> writes;  ///< extensions; none: it is only read
  std::string help;                 ///< one line
};

/// All formats, in the order in which they are tried.
std::vector<FormatSummary> knownFormats();

/// The formats of this kind that can be read, as messages and help texts list them: ".obj .ply .stl .off
/// .glb". Those that an extension alone does not describe are in words: "a DICOM folder".
std::string readableList(Contents contents, const std::string& between = " ");
/// The extensions that can be written.
std::string writableList(Contents contents, const std::string& between = " ");
/// The extensions of files of named structures that can be written: ".seg.dcm .rt.dcm .seg.nrrd".
std::string structureList(const std::string& between = " ");

}  // namespace slicemorph
