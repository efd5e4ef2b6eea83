#pragma once

#include "io/image/dicom_file.h"

namespace slicemorph {

/// A slice of a series: index of its file there, and of its frame in that.
struct DicomSliceRef {
  size_t file = 0, frame = 0;
};

/// Slices that are one volume, each place once but for doubles, in order along their normal.
struct DicomVolume {
  std::vector<DicomSliceRef> slices;
  std::string apart;         ///< what tells it from the others of its series; empty: there is one
  std::vector<int> marks;    ///< the same: DicomMark, or kMarkCount for the order in the files
  bool byOrderOnly = false;  ///< nothing but the order in the files does
};

/// The slices of one series UID that share size, directions and pixel spacing; of files that are not known to be slices,
/// or segmentations, one file.
struct DicomSeries {
  std::string uid, modality, description;
  std::vector<DicomFile> files;  ///< sorted by name; of each only its frames that belong here
  std::vector<DicomVolume> volumes;
  bool localizer = false;
  double turned = 0;  ///< degrees by which directions of slices differ from those of the first, at most

  const DicomFrame& frameOf(const DicomSliceRef& ref) const { return files[ref.file].frames[ref.frame]; }
  bool isSegmentation() const { return files[0].kind == DicomFile::kSegmentation; }
  size_t slices() const;
};

/// Sorts images (without damaged and foreign ones) into series, in the order of their UIDs, and these into volumes.
/// `force`: slices whose directions differ by no more than kMostTurned degrees are one stack.
std::vector<DicomSeries> seriesOfFiles(std::vector<DicomFile> files, bool force);

/// Degrees: far below the angle between planes that a scanner takes on purpose, above what a moved couch or rounding does.
constexpr double kMostTurned = 5;
/// Whether two stacks differ in nothing but such a turn.
bool differInTurn(const DicomSeries& a, const DicomSeries& b);

/// Divides the slices of a series into volumes: by image type, echo, b-value and time always; where slices still share
/// a place, by what else differs there, at last by their order alone where each place has as many. What cannot be
/// divided so stays together.
std::vector<DicomVolume> splitIntoVolumes(const DicomSeries& series);

}  // namespace slicemorph
