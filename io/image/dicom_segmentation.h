#pragma once

#include "io/image/dicom_volumes.h"
#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Reads a DICOM segmentation (PS3.3 A.51) as a label map: each segment's number is its label, on the planes of its
/// frames; planes without a frame are empty. `segment`: only this one; 0: all, where a voxel of several gets the
/// highest number, with a warning. `force`: frames beside the planes' lattice are put on its nearest plane. Fractions count from a half. Throws IoError, InputError where the planes are on no
/// lattice or there is no such segment, and what `check` throws.
ImageFile readDicomSegmentation(const DicomSeries& series, int segment, bool force, const SizeCheck& check);

/// "1 Liver, 2 Spleen".
std::string segmentsOf(const DicomSeries& series);

}  // namespace slicemorph
