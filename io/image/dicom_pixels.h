#pragma once

#include "io/image/dicom_volumes.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// The values of slices, in the order asked for, of one number type.
struct DicomValues {
  std::vector<ImageValues> slices;
  size_t padded =
      0;  ///< pixels that are no measurement (PixelPaddingValue): they have the least value of the others
  double padding = 0;  ///< their stored value
  double least = 0;    ///< what they have now
};

/// Bytes that a pixel takes as it is stored.
int bytesOfPixel(const DicomFile& file);
/// Bytes that a file's pixels take while slices are read from it: of all its frames, whichever are wanted, where it is
/// unpacked as a whole, and about as many more while it is; 0 of others.
double bytesUnpacked(const DicomFile& file);

/// Reads slices and rescales each by its own slope and intercept, or by its file's table. Whole numbers stay such where all slopes and
/// intercepts are. MONOCHROME1 says how to show values, not what they are: nothing is inverted. Throws IoError.
DicomValues readDicomValues(const DicomSeries& series, const std::vector<DicomSliceRef>& slices);

/// None, of the type that slices' values would have if they took all that their bits can hold.
ImageValues noDicomValues(const DicomSeries& series, const std::vector<DicomSliceRef>& slices);

/// The stored values of some frames of a file, without rescaling: 0 and 1 where a pixel is a bit. Throws IoError.
std::vector<ImageValues> readStoredFrames(const DicomFile& file);

}  // namespace slicemorph
