#include "io/image/dicom_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr DicomTag kPosition = 0x00200032, kOrientation = 0x00200037, kBetween = 0x00180088,
                   kThickness = 0x00180050, kIncrement = 0x00280009, kGridOffsets = 0x3004000c,
                   kSliceLocations = 0x00182005, kDetectors = 0x00540022, kFrameTimes = 0x00181065,
                   kFrameTimeStep = 0x00181063;
// Of nuclear medicine (PS3.3 C.8.4.8).
constexpr DicomTag kSliceVector = 0x00540080, kSliceCount = 0x00540081, kTimeSlots = 0x00540070,
                   kTimeSlotCount = 0x00540071, kRrIntervals = 0x00540060, kRrIntervalCount = 0x00540061;
// What may stand in FrameIncrementPointer of frames that are slices, and tells no volumes apart: positions, locations,
// distances, and numbers or names of pages.
constexpr DicomTag kOfSlices[] = {kGridOffsets, kSliceLocations, kSliceVector, kPosition,  0x00201041,
                                  kBetween,     kThickness,      0x00200013,   0x00182001, 0x00182002};
/// A vector of nuclear medicine that has a number for every frame, and the mark that it becomes.
struct FrameVector {
  DicomTag tag;
  const char* name;
  DicomMark mark;
};
constexpr FrameVector kVolumeVectors[] = {
    {0x00540010, "energy window", kImageType}, {0x00540020, "detector", kImageType},
    {0x00540030, "phase", kImageType},         {kRrIntervals, "R-R interval", kImageType},
    {kTimeSlots, "time slot", kTemporal},      {0x00540100, "time slice", kTemporal}};

std::string tagText(DicomTag tag) {
  char text[16];
  std::snprintf(text, sizeof text, "(%04x,%04x)", unsigned(tag >> 16), unsigned(tag & 0xffff));
  return text;
}

/// The elements that the frames of a file follow.
std::vector<DicomTag> incrementsOf(const DicomElements& data) {
  std::vector<DicomTag> tags;
  for (double tag : data.numbers(kIncrement, "AT"))
    if (tag >= 0 && tag <= double(0xffffffff)) tags.push_back(DicomTag(tag));
  return tags;
}

bool holds(const std::vector<DicomTag>& tags, DicomTag tag) {
  return std::find(tags.begin(), tags.end(), tag) != tags.end();
}

/// Marks frames by a vector that has a number for each; returns whether these differ.
bool markBy(const FrameVector& vector, const std::vector<double>& numbers, DicomFile& file) {
  if (std::count(numbers.begin(), numbers.end(), numbers[0]) == std::ptrdiff_t(numbers.size())) return false;
  for (size_t k = 0; k < numbers.size(); ++k) {
    std::string& mark = file.frames[k].marks[vector.mark];
    if (vector.mark == kTemporal)
      mark = shortText(numbers[k]);
    else
      mark += std::string(mark.empty() ? "" : ", ") + vector.name + " " + shortText(numbers[k]);
  }
  return true;
}

/// Marks the volumes that the elements tell apart which a file's frames follow. Returns why that is not certain; empty
/// where it is.
std::string markVolumes(const DicomElements& data, const std::vector<DicomTag>& increments, DicomFile& file) {
  bool several = false;
  for (DicomTag tag : increments) {
    if (tag == kFrameTimes || tag == kFrameTimeStep)
      return "its frames follow each other in time, not in space";
    const auto vector = std::find_if(std::begin(kVolumeVectors), std::end(kVolumeVectors),
                                     [&](const FrameVector& v) { return v.tag == tag; });
    const bool tellsVolumes = vector != std::end(kVolumeVectors);
    if (!tellsVolumes && std::find(std::begin(kOfSlices), std::end(kOfSlices), tag) == std::end(kOfSlices))
      return "its frames follow an element that is not known to number slices (FrameIncrementPointer " +
             tagText(tag) + ")";
    if (!tellsVolumes && tag != kSliceVector) continue;
    const std::vector<double> numbers = data.numbers(tag, "US");
    if (numbers.size() != file.frames.size())
      return "it numbers " + std::to_string(numbers.size()) + " of its " +
             std::to_string(file.frames.size()) + " frames (" + (tellsVolumes ? vector->name : "slice") +
             ", " + tagText(tag) + ")";
    if (tellsVolumes && markBy(*vector, numbers, file)) several = true;
  }
  if (several && !holds(increments, kSliceVector))
    return "its frames are several volumes, and no SliceVector says which slice each is";
  return "";
}

/// Why frames of nuclear medicine are not certain to be slices of the volumes that they are marked as; empty: they are.
std::string doubtOfNuclear(const DicomElements& data, const std::vector<DicomTag>& increments,
                           const DicomFile& file) {
  const std::string type = data.text(kImageTypeTag);
  if (type.find("RECON") == std::string::npos)
    return "its frames are views of nuclear medicine ('" + type + "'), no slices";
  const bool gated = type.find("GATED") != std::string::npos || data.first(kTimeSlotCount, "US") > 1;
  if (gated && !holds(increments, kTimeSlots))
    return "it is gated, and FrameIncrementPointer names no time slots of its frames (TimeSlotVector)";
  if (data.first(kRrIntervalCount, "US") > 1 && !holds(increments, kRrIntervals))
    return "it has several R-R intervals, and FrameIncrementPointer does not name them (RRIntervalVector)";
  const double slices = data.first(kSliceCount, "US");
  if (slices > 0 && slices != double(file.frames.size()) && !holds(increments, kSliceVector))
    return "it states " + shortText(slices) + " slices, and has " + std::to_string(file.frames.size()) +
           " frames";
  return "";
}

/// Where frames lie along the normal of the first, from that; or why it is not certain.
struct FrameOffsets {
  std::vector<double> along;  ///< millimetres
  std::string uncertain, assumed;
};

/// GridFrameOffsetVector is relative where it begins with 0. Else it holds the z of transverse planes, if it begins with
/// that of the position (PS3.3 C.8.8.3.2).
FrameOffsets gridOffsetsOf(const DicomElements& data, const Vec3d& position, const Vec3d& normal,
                           size_t count) {
  constexpr double kSameZ = 1e-3;  // millimetres; positions are rounded to about this
  constexpr double kTransverse =
      1 - 1e-6;  // cosine of 0.08 degrees: directions may be rounded to three decimals
  FrameOffsets out;
  out.along = data.numbers(kGridOffsets);
  if (out.along.size() != count) {
    out.uncertain = "it has " + std::to_string(out.along.size()) + " offsets (GridFrameOffsetVector) for " +
                    std::to_string(count) + " frames";
    return out;
  }
  const double first = out.along[0];
  if (first != 0 && !(std::abs(first - position[2]) < kSameZ && normal[2] > kTransverse))
    out.uncertain = "its GridFrameOffsetVector begins with " + shortText(first) +
                    ", and only from 0, or on transverse planes from the z of its position (" +
                    shortText(position[2]) + "), it says where they lie";
  for (double& v : out.along) v -= first;
  return out;
}

/// `first`: a frame with position and directions.
FrameOffsets offsetsOfFrames(const DicomElements& data, const DicomFrame& first,
                             const std::vector<DicomTag>& increments, const DicomFile& file) {
  const size_t count = file.frames.size();
  const Vec3d normal = (*first.axes)[0].cross((*first.axes)[1]).unit();
  if (data.size(kGridOffsets) > 0) return gridOffsetsOf(data, *first.position, normal, count);
  FrameOffsets out;
  if (data.size(kSliceLocations) > 0) {
    out.uncertain =
        "SliceLocationVector says how far apart its frames are, but not in which direction they follow";
    return out;
  }
  // Negative distances mean the other direction in nuclear medicine (PS3.3 C.8.4.15).
  const double between = file.modality == "NM" ? first.between : std::abs(first.between);
  const double gap = between != 0 ? between : first.thickness;
  if (gap == 0) {
    out.uncertain =
        "it has one position for all its frames, and neither SpacingBetweenSlices nor SliceThickness";
    return out;
  }
  const std::vector<double> slices =
      holds(increments, kSliceVector) ? data.numbers(kSliceVector, "US") : std::vector<double>();
  for (size_t k = 0; k < count; ++k) out.along.push_back((slices.empty() ? double(k) : slices[k] - 1) * gap);
  out.assumed = "it has one position for all its frames: they are taken to follow each other every " +
                shortText(std::abs(gap)) + " mm (" +
                (first.between != 0 ? "SpacingBetweenSlices" : "SliceThickness") +
                (gap > 0 ? ") along" : ") against") + " the normal of the first";
  return out;
}

}  // namespace

void placeDicomFrames(const DicomElements& data, DicomFile& file) {
  DicomFrame& first = file.frames[0];
  const DicomElements detector = data.item(kDetectors);
  if (!first.axes) first.axes = dicomAxes(detector.numbers(kOrientation));
  if (!first.position) first.position = dicomPlace(detector.numbers(kPosition));
  for (size_t k = 1; k < file.frames.size(); ++k) {
    file.frames[k] = first;
    file.frames[k].number = int(k);
  }
  const std::vector<DicomTag> increments = incrementsOf(data);
  file.uncertain = markVolumes(data, increments, file);
  if (file.uncertain.empty() && file.modality == "NM")
    file.uncertain = doubtOfNuclear(data, increments, file);
  if (file.uncertain.empty() && (!first.position || !first.axes))
    file.uncertain = "its frames have no positions or directions";
  if (!file.uncertain.empty()) return;
  const FrameOffsets offsets = offsetsOfFrames(data, first, increments, file);
  file.uncertain = offsets.uncertain;
  if (!file.uncertain.empty()) return;
  if (!offsets.assumed.empty()) file.assume(offsets.assumed);
  const Vec3d normal = (*first.axes)[0].cross((*first.axes)[1]).unit(), from = *first.position;
  for (size_t k = 0; k < file.frames.size(); ++k) file.frames[k].position = from + offsets.along[k] * normal;
}

}  // namespace slicemorph
