#pragma once

#include "io/image/dicom_volumes.h"
#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// The image series of a folder or a file, in the order of their UIDs; `notes`: which files were left out.
struct DicomFolder {
  std::vector<DicomSeries> series;
  Notes notes;
  /// Damaged files by the UID of their series, files that could not be opened by none.
  std::vector<std::pair<std::string, Note>> damaged;
};
/// `path`: a folder; or a file, which stands for itself where it holds several slices, else for its folder.
/// Unreadable and foreign files are left out. Throws IoError where the folder cannot be read or holds no image.
///
/// `force`: slices of one series whose directions differ a little are one stack.
DicomFolder scanDicom(const std::string& path, bool force = false);

/// Whether a file holds several slices, and so stands for itself.
bool holdsDicomVolumes(const std::string& path);

/// A volume of a series. Of a segmentation `volume` is the number of a segment, 0: all of them.
struct DicomChoice {
  DicomSeries series;
  size_t volume = 0;
};
/// Finds a volume. `selection`: SERIES, SERIES@VOLUME or @VOLUME, by numbers (from 1) or the series' UID. Localizers
/// beside one other series are passed over. Throws InputError, which lists what there is, where there are several and
/// none is chosen, and IoError for a damaged file of the series, where this was not chosen.
DicomChoice chooseDicomVolume(const std::string& path, const std::string& selection, bool force,
                              Notes& notes);

/// Reads a volume: slices in the order of their positions, values rescaled (CT: Hounsfield units), axes from
/// its direction cosines. Slices of a tilted gantry or with uneven gaps are resampled from their stored
/// positions (see straighten); notes report missing and duplicate slices. The options' spacing and `force`
/// serve where the file's own places are not certain. Throws IoError naming the file, InputError where slices contradict
/// each other or their places are not certain, and what `check` throws.
ImageFile readDicomVolume(const std::string& path, const DicomChoice& choice, const ImageOptions& options,
                          const SizeCheck& check);

/// The same without values, of slices' headers alone: whether slices at one place are doubles is not looked at, and the type
/// of values is what their bits may need.
ImageFile readDicomHead(const std::string& path, const DicomChoice& choice, const ImageOptions& options);

}  // namespace slicemorph
