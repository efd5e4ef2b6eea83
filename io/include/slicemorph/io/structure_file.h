#pragma once

#include "slicemorph/image.h"
#include "slicemorph/note.h"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// Segmentations and structure sets as files: named, coloured structures on the slices of a scan.
namespace slicemorph {

/// A slice: the centre of its pixel (i, j) is at origin + i step[0] + j step[1], LPS millimetres.
struct ImagePlane {
  Vec3d origin{0, 0, 0};
  Vec3d step[2] = {{1, 0, 0}, {0, 1, 0}};  ///< along a row, along a column
  int size[2] = {0, 0};                    ///< columns, rows
  std::string sopClass, sopInstance;       ///< UIDs of the DICOM image that lies here; empty: none
  int frame = 0;                           ///< of that image, from 1; 0: it has one alone

  size_t count() const { return size_t(size[0]) * size_t(size[1]); }
  Vec3d at(double i, double j) const { return origin + i * step[0] + j * step[1]; }
  Vec3d normal() const { return step[0].cross(step[1]).unit(); }
};

/// The DICOM series that structures belong to.
struct DicomSource {
  std::map<std::uint32_t, std::string> texts;   ///< of patient and study by tag (0xGGGGEEEE), UTF-8
  std::string study, series, frameOfReference;  ///< UIDs
  std::vector<ImagePlane> planes;               ///< in order along their normal, all of one size
  Notes notes;
};

/// Reads what a series says of itself, without its pixels. `input`: as readImage takes DICOM: a folder, `folder:2`,
/// `folder:UID`, one file. Throws IoError, and InputError where it is no DICOM series, has no frame of reference, or
/// slices that are not parallel or of several sizes. `force`: as of ImageOptions; slices of small turns get the first's
/// directions.
DicomSource readDicomSource(const std::string& input, bool force = false);

/// One structure of a file.
struct StructureShape {
  int number = 1;
  std::string name;
  std::array<std::uint8_t, 3> color{};  ///< sRGB
  /// At a plane's pixels, row by row: negative inside, 0 on the outline. Empty: nothing of it lies there.
  std::function<std::vector<float>(const ImagePlane&)> onPlane;
  /// Size of what it shows, millimetres: outlines are traced on pixels that are at most so large, down to a quarter of the
  /// plane's; 0: on the plane's own.
  double detail = 0;
};

struct StructureSet {
  std::string input;               ///< what it was made of, for descriptions
  std::vector<ImagePlane> planes;  ///< parallel, of one size, in order along their normal
  std::vector<StructureShape> structures;
  std::optional<DicomSource> source;
};

/// The planes of a lattice along k, in order along their normal.
std::vector<ImagePlane> planesOf(const ImageLattice& lattice);

/// The usual distance between neighbouring planes, millimetres; 1 of one plane.
double gapOf(const std::vector<ImagePlane>& planes);

/// A colour for a structure by its number: neighbouring numbers get colours that are far apart.
std::array<std::uint8_t, 3> colorOfStructure(int number);

/// Whether an output holds structures by its name: `.seg.dcm`, `.rt.dcm`, `.seg.nrrd`.
bool isStructureOutput(const std::string& path);

/// Writes structures whole or not at all: as DICOM segmentation (binary, one frame for each slice of a segment), as
/// DICOM RT structure set (outlines on the planes, holes joined to them by a cut of no width), or as a NRRD segmentation
/// of 3D Slicer. DICOM objects belong to the source's patient, study and frame of reference and name its images, else
/// they have their own. Their date and time are now, or those of SOURCE_DATE_EPOCH, with which the same content is the
/// same bytes. Returns what the format could not hold. Throws InputError where no plane holds anything of any structure, or
/// the format cannot hold the planes; IoError.
Notes writeStructures(const std::string& path, const StructureSet& set);

}  // namespace slicemorph
