#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// The files of a folder that share series UID, orientation, size and pixel spacing.
struct DicomSeries {
  std::string uid, modality, description;
  std::vector<std::string> files;  ///< sorted by name, not along the stack
};

/// The image series among the files of a folder, in the order of their UIDs; `notes`: which
/// files were skipped.
struct DicomFolder {
  std::vector<DicomSeries> series;
  Notes notes;
};
/// Throws IoError where the folder cannot be read, a DICOM file is damaged or there is no image.
DicomFolder scanDicomFolder(const std::string& folder);

/// Reads a series: slices in the order of their positions, values rescaled (CT: Hounsfield units), axes from
/// its direction cosines. Slices of a tilted gantry or with uneven gaps are resampled from their stored
/// positions (see straighten); notes report missing and duplicate slices. Throws IoError naming the file,
/// InputError where slices contradict each other, and what `check` throws.
ImageFile readDicomSeries(const std::string& folder, const DicomSeries& series, const SizeCheck& check);

/// Finds a series. `path`: a folder, of which `series` chooses by number (from 1) or UID; or one .dcm file,
/// which stands for the series that it belongs to. Throws InputError, which lists the series, where there are
/// several and none is chosen.
DicomSeries chooseDicomSeries(const std::string& path, const std::string& series, Notes& notes);

}  // namespace slicemorph
