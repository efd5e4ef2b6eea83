#pragma once

#include "slicemorph/io/image_file.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// One stack of slices of a folder: of one series UID, orientation, size and pixel spacing.
struct DicomSeries {
  std::string uid, modality, description;
  std::vector<std::string> files;  ///< as the folder lists them, not in the order of space
};

/// The image series among the files of a folder, in the order of their UIDs; `notes`: what was passed over.
struct DicomFolder {
  std::vector<DicomSeries> series;
  Notes notes;
};
DicomFolder scanDicomFolder(const std::string& folder);

/// Reads a series: slices ordered by their positions, values rescaled (CT: Hounsfield units), axes as its
/// direction cosines say. A tilted gantry is straightened and uneven gaps are filled by resampling every
/// slice from where it truly lies; notes tell of missing and doubled slices. Throws IoError naming the file,
/// InputError where slices contradict each other.
ImageFile readDicomSeries(const std::string& folder, const DicomSeries& series);

/// A folder, or `folder:N` with `series` N (from 1) or a UID; or one .dcm file, which stands for the series
/// it belongs to. Throws InputError listing the series where there are several and none is chosen.
DicomSeries chooseDicomSeries(const std::string& path, const std::string& series, Notes& notes);

}  // namespace slicemorph
