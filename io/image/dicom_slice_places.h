#pragma once

#include "io/image/dicom_volumes.h"
#include "slicemorph/io/image_file.h"

#include <string>
#include <vector>

namespace slicemorph {

/// What all slices of a volume share, and their places, LPS millimetres.
struct SlicePlaces {
  Vec3d step[2];                ///< from a pixel to the next along a row, down a column
  Vec3d normal;                 ///< unit
  double thickness = 1;         ///< of a single slice, millimetres
  std::vector<Vec3d> position;  ///< in the order of the volume's slices
};

/// A slice by its file, within its folder, and its frame.
std::string nameOfSlice(const DicomSeries& series, const DicomSliceRef& ref);

/// Places the slices of a volume, and sorts them along their normal where what they say of that is not certain: then by
/// --spacing one behind the other, or with --force as well as can be told, both with a warning. Throws InputError where
/// neither is given, and for pictures of several slices that cannot be taken apart.
SlicePlaces placeDicomSlices(const std::string& path, const DicomSeries& series,
                             std::vector<DicomSliceRef>& slices, const ImageOptions& options, Notes& notes);

}  // namespace slicemorph
