#pragma once

#include "slicemorph/io/structure_file.h"

#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// What every DICOM object of structures says of itself.
struct ObjectHead {
  const StructureSet& set;
  std::vector<std::string> names;  ///< of the structures, as DICOM can hold them
  std::string date, time;          ///< YYYYMMDD, HHMMSS
};

/// A binary segmentation: frames of one bit a pixel.
struct SegmentFrames {
  /// A frame's structure and plane, indices.
  std::vector<std::pair<size_t, size_t>> frames;
  std::string bits;  ///< of all frames, the first pixel is the lowest bit; no padding between frames
};

/// Closed outlines of the structures.
struct StructureOutline {
  size_t plane = 0;  ///< index
  std::vector<Vec3d> points;
};
using StructureOutlines = std::vector<std::vector<StructureOutline>>;  ///< by structure

/// Whole DICOM files. Of the plug-in with GDCM. Throw IoError.
std::string segmentationFile(const ObjectHead& head, const SegmentFrames& content);
std::string structureSetFile(const ObjectHead& head, const StructureOutlines& content);

/// Writes either, by the extension. As writeStructures.
Notes writeDicomStructures(const std::string& path, const StructureSet& set);

}  // namespace slicemorph
