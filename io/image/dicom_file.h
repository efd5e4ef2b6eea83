#pragma once

#include "io/image/dicom_elements.h"
#include "slicemorph/conventions.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// Elements that more than one part of the reader looks at.
constexpr DicomTag kImageTypeTag = 0x00080008, kManufacturerTag = 0x00080070;

/// What may tell the volumes of one series apart, see splitIntoVolumes().
enum DicomMark {
  kImageType,  ///< type of image or frame, part of a complex value, stack, energy window, detector, R-R interval
  kEcho,       ///< milliseconds
  kBValue,     ///< s/mm2
  kTemporal,   ///< index or offset of the time, or number of its slot
  kDirection,  ///< of the diffusion gradient
  kPhase,      ///< of the heart or breath: milliseconds after the trigger, or percent
  kInversion,  ///< milliseconds
  kDimension,  ///< any other index that the file's dimensions name
  kAcquisition,
  kTime,  ///< of the acquisition
  kMarkCount
};

/// When a slice was acquired; seconds.
struct DicomTimes {
  std::optional<double> offset;    ///< behind the first of the file's temporal positions
  std::optional<double> acquired;  ///< from a start that the slices of a series share
  double repetition = 0;           ///< RepetitionTime, where a volume takes one; 0: not known
};

/// One slice: a frame of a file, or a tile of one.
struct DicomFrame {
  int number = 0;                 ///< of the frame in its file, from 0
  int tile[2] = {0, 0};           ///< column and row of its first pixel in that frame
  std::optional<Vec3d> position;  ///< LPS millimetres: centre of the first pixel
  bool badAxes = false;           ///< directions are stated, but are no unit vectors at right angles
  std::optional<std::array<Vec3d, 2>> axes;      ///< unit directions along a row, and down a column
  std::optional<std::array<Vec3d, 2>> nearAxes;  ///< of bad ones the nearest that are such, if any
  std::optional<std::array<double, 2>> pixel;    ///< millimetres from pixel to pixel along these
  double between = 0, thickness = 0;             ///< millimetres as stated, of the slices; 0: not stated
  double slope = 1, intercept = 0;
  int segment = 0;  ///< of a segmentation
  std::array<std::string, kMarkCount> marks;
  DicomTimes times;
};

struct DicomSegment {
  int number = 0;
  std::string name;
  std::optional<std::array<std::uint8_t, 3>> color;  ///< as sRGB
};

/// A table that gives stored values their meaning (Modality LUT, PS3.3 C.11.1): that of `first` and of what is below it
/// is the first entry, that of what is behind the last one the last.
struct DicomTable {
  double first = 0;
  std::vector<std::uint16_t> values;
};

/// How the pixels of a file are stored.
struct DicomPixels {
  enum Kind { kWhole, kFloat, kDouble } kind = kWhole;
  int columns = 0, rows = 0, frames = 1;  ///< as stored
  int bits = 16, bitsUsed = 16, highBit = 15;
  bool isSigned = false;
  std::uint64_t at = 0;  ///< where they begin in the file
  DicomTag tag = 0;      ///< of their element
  bool decode = false;   ///< compressed, big endian or in a deflated file: read as a whole
  std::optional<std::pair<double, double>> padding;  ///< stored values, from and to, that are no measurement
};

/// What one file says of itself.
struct DicomFile {
  std::string path, seriesUid, instanceUid, frameOfReference, modality, description;
  enum Kind { kSlices, kSegmentation } kind = kSlices;
  DicomPixels pixels;
  int columns = 0, rows = 0;  ///< of a slice
  int instance = 0;
  bool localizer = false;
  bool isWhole = false;            ///< holds several slices: stands for itself, not for its series
  bool notSplit = false;           ///< its frames are pictures of several slices, which cannot be taken apart
  std::vector<DicomFrame> frames;  ///< none where it is no image
  std::vector<DicomSegment> segments;
  std::optional<DicomTable> table;  ///< takes the place of slopes and intercepts
  std::string badTable;             ///< why there is none though the file has one; empty: it is none of these
  bool statesRescale = false;       ///< slope and intercept stand beside the table
  bool labelPixels = false;         ///< of a segmentation: pixels are the segments' numbers
  double fullFraction = 0;  ///< of a segmentation by fractions: the value that is all; 0: it is binary
  std::string foreign;      ///< why it is no grey image, for a note; empty: it is one
  std::string uncertain;    ///< why its frames' places are not known; empty: they are, or there is one frame
  std::string assumed;      ///< what was assumed of them, for a note
  std::string damage;       ///< why it cannot be read; what was read before the damage is above
  std::string unreadable;   ///< of a file of a folder: why it could not be opened
  bool isDicom = true;

  void assume(const std::string& what) { assumed += (assumed.empty() ? "" : "; ") + what; }
};

/// Reads what stands before the pixels, and checks that these are all there. Throws IoError where the file cannot be
/// opened.
DicomFile readDicomFile(const std::string& path);

/// The frames of an image file without pixels: geometry, rescaling and marks of each (PS3.3 C.7.6.2, C.7.6.16). Sets
/// `uncertain` and `assumed`.
void readDicomFrames(const DicomElements& data, DicomFile& file);

/// Whether a file is a mosaic of Siemens: all slices of a volume as tiles of one picture.
bool isMosaic(const DicomElements& data);
/// Makes the one frame of a mosaic its tiles, by Siemens' private header; or sets `uncertain`.
void splitMosaic(const DicomElements& data, DicomFile& file);

}  // namespace slicemorph
