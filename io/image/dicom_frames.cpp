#include "io/image/dicom_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

// Functional groups (PS3.3 C.7.6.16) and what stands in them; of classic files the same elements on the outside.
constexpr DicomTag kShared = 0x52009229, kPerFrame = 0x52009230;
constexpr DicomTag kPlanePosition = 0x00209113, kPosition = 0x00200032, kPlaneOrientation = 0x00209116,
                   kOrientation = 0x00200037, kPixelMeasures = 0x00289110, kPixelSpacing = 0x00280030,
                   kBetween = 0x00180088, kThickness = 0x00180050, kTransformation = 0x00289145,
                   kIntercept = 0x00281052, kSlope = 0x00281053, kModalityTable = 0x00283000,
                   kFrameContent = 0x00209111, kStackId = 0x00209056, kTemporalIndex = 0x00209128,
                   kFrameAcquisition = 0x00209156, kDimensionValues = 0x00209157, kFrameTime = 0x00189074,
                   kFrameReference = 0x00189151, kTemporalGroup = 0x00209310, kTemporalOffset = 0x0020930d,
                   kEchoGroup = 0x00189114, kEffectiveEcho = 0x00189082, kDiffusion = 0x00189117,
                   kB = 0x00189087, kDirectionality = 0x00189075, kGradient = 0x00189076,
                   kGradientVector = 0x00189089, kCardiac = 0x00189118, kTriggerDelay = 0x00209153,
                   kCardiacPercent = 0x00209241, kBreath = 0x00209253, kBreathPercent = 0x00209248,
                   kModifier = 0x00189115, kInversions = 0x00189079, kSegmentGroup = 0x0062000a,
                   kSegmentReference = 0x0062000b, kUnassignedShared = 0x00209170, kUnassigned = 0x00209171,
                   kFrameType = 0x00089007, kComplex = 0x00089208, kDimensions = 0x00209222,
                   kDimensionPointer = 0x00209165;
constexpr DicomTag kFrameTypes[] = {0x00189226, 0x00189329, 0x00189751, 0x00189504,
                                    0x00189807, 0x00209450, 0x00189806};  // of MR, CT, PET, XA, US, ...
// Of classic files.
constexpr DicomTag kEchoTime = 0x00180081, kEchoNumber = 0x00180086, kTemporalId = 0x00200100,
                   kTriggerTime = 0x00181060, kInversionTime = 0x00180082, kAcquisitionNumber = 0x00200012,
                   kAcquisitionTime = 0x00080032, kContentTime = 0x00080033, kFrameReferenceTime = 0x00541300,
                   kSiemensB = 0x0019100c, kSiemensDirection = 0x0019100e, kGeB = 0x00431039,
                   kGePart = 0x0043102f, kPhilipsB = 0x20011003;
// Of files of several frames without functional groups.
constexpr DicomTag kIncrement = 0x00280009, kGridOffsets = 0x3004000c, kDoseScaling = 0x3004000e,
                   kSliceLocations = 0x00182005, kDetectors = 0x00540022, kImagerSpacing = 0x00181164,
                   kFrameTimes = 0x00181065, kFrameTimeStep = 0x00181063;
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

constexpr const char* kBadAxes =
    "its directions (ImageOrientationPatient) are no unit vectors at right angles";
constexpr double kSkewed = 5e-3;   // directions in files have three decimals or more
constexpr double kFarthest = 1e9;  // millimetres; what damaged positions and sizes of pixels are beyond

/// A functional groups item, whose groups are parsed once.
class GroupItem {
 public:
  explicit GroupItem(DicomElements item) : item_(std::move(item)) {}
  const DicomElements& group(DicomTag tag) const {
    const auto found = parsed_.find(tag);
    return found != parsed_.end() ? found->second : parsed_.emplace(tag, item_.item(tag)).first->second;
  }

 private:
  DicomElements item_;
  mutable std::map<DicomTag, DicomElements> parsed_;
};

/// Looks elements up in a frame's own groups, then in those of all frames, then outside.
class Groups {
 public:
  Groups(const GroupItem& frame, const GroupItem& shared, const DicomElements& data)
      : frame_(frame), shared_(shared), data_(data) {}

  /// The group that holds `tag`; the data set itself for what stands outside of groups.
  const DicomElements& holding(DicomTag group, DicomTag tag) const {
    // Legacy Converted Enhanced images keep what has no group of its own in "unassigned" ones.
    for (const DicomElements* found : {&frame_.group(group), &shared_.group(group),
                                       &frame_.group(kUnassigned), &shared_.group(kUnassignedShared)})
      if (found->has(tag)) return *found;
    return data_;
  }
  bool hasInGroup(DicomTag group, DicomTag tag) const { return &holding(group, tag) != &data_; }
  std::vector<double> numbers(DicomTag group, DicomTag tag, const char* type = "DS") const {
    return holding(group, tag).numbers(tag, type);
  }
  std::string text(DicomTag group, DicomTag tag) const { return holding(group, tag).text(tag); }

 private:
  const GroupItem &frame_, &shared_;
  const DicomElements& data_;
};

std::string written(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}

std::string written(const std::vector<double>& values) {
  std::string text;
  for (double v : values) text += (text.empty() ? "" : " ") + written(v);
  return text;
}

std::optional<std::array<Vec3d, 2>> axesOf(const std::vector<double>& v) {
  if (v.size() != 6) return std::nullopt;
  const Vec3d x(v[0], v[1], v[2]), y(v[3], v[4], v[5]);
  const bool right = std::abs(x.length() - 1) < kSkewed && std::abs(y.length() - 1) < kSkewed &&
                     std::abs(x.dot(y)) < kSkewed;
  if (!right) return std::nullopt;
  return std::array<Vec3d, 2>{x, y};
}

std::optional<Vec3d> placeOf(const std::vector<double>& v) {
  const bool inReach =
      std::all_of(v.begin(), v.end(), [](double along) { return std::abs(along) < kFarthest; });
  if (v.size() != 3 || !inReach) return std::nullopt;
  return Vec3d(v[0], v[1], v[2]);
}

std::optional<std::array<double, 2>> pixelOf(const std::vector<double>& v) {
  const auto isSize = [](double pixel) { return pixel > 1 / kFarthest && pixel < kFarthest; };
  if (v.size() != 2 || !isSize(v[0]) || !isSize(v[1])) return std::nullopt;
  return std::array<double, 2>{v[1], v[0]};  // the file has the distance between rows first
}

void readGeometry(const Groups& groups, DicomFrame& frame) {
  const std::vector<double> at = groups.numbers(kPlanePosition, kPosition);
  frame.position = placeOf(at);
  const std::vector<double> axes = groups.numbers(kPlaneOrientation, kOrientation);
  frame.axes = axesOf(axes);
  frame.badAxes = !axes.empty() && !frame.axes;
  frame.pixel = pixelOf(groups.numbers(kPixelMeasures, kPixelSpacing));
  const auto length = [&](DicomTag tag) {
    const std::vector<double> v = groups.numbers(kPixelMeasures, tag);
    return v.empty() ? 0.0 : v[0];
  };
  frame.between = length(kBetween), frame.thickness = std::max(0.0, length(kThickness));
  const std::vector<double> slope = groups.numbers(kTransformation, kSlope),
                            intercept = groups.numbers(kTransformation, kIntercept);
  if (!slope.empty() && slope[0] != 0) frame.slope = slope[0];
  if (!intercept.empty()) frame.intercept = intercept[0];
  const std::vector<double> segment = groups.numbers(kSegmentGroup, kSegmentReference, "US");
  if (!segment.empty() && segment[0] >= 0 && segment[0] <= 65535) frame.segment = int(segment[0]);
}

std::string imageTypeOf(const Groups& groups, const DicomElements& data, bool ge) {
  std::string type;
  for (DicomTag group : kFrameTypes)
    if (type.empty()) type = groups.text(group, kFrameType);
  if (type.empty()) type = data.text(kImageTypeTag);
  const std::string part = groups.text(kFrameTypes[0], kComplex);
  if (!part.empty()) type += " " + part;
  if (ge && data.has(kGePart)) {
    constexpr const char* kParts[] = {"magnitude", "phase", "real", "imaginary"};
    const double raw = data.first(kGePart, "SS", -1);
    if (raw >= 0 && raw < 4) type += std::string(" ") + kParts[int(raw)];
  }
  const std::string stack = groups.text(kFrameContent, kStackId);
  return stack.empty() ? type : type + ", stack " + stack;
}

void readDiffusion(const Groups& groups, const DicomElements& data, const std::string& maker,
                   DicomFrame& frame) {
  std::vector<double> b = groups.numbers(kDiffusion, kB, "FD");
  const bool siemens = maker.find("SIEMENS") != std::string::npos;
  if (b.empty() && siemens) b = data.numbers(kSiemensB, "IS");
  if (b.empty() && maker.rfind("GE", 0) == 0) {
    b = data.numbers(kGeB, "IS");
    if (!b.empty()) b[0] = std::fmod(b[0], 1e9);  // GE adds 1e9 to b values of several directions
  }
  if (b.empty() && maker.find("PHILIPS") != std::string::npos) b = data.numbers(kPhilipsB, "FL");
  if (!b.empty()) frame.marks[kBValue] = written(b[0]);
  const DicomElements& group = groups.holding(kDiffusion, kDirectionality);
  std::vector<double> gradient = group.item(kGradient).numbers(kGradientVector, "FD");
  if (gradient.empty()) gradient = data.numbers(kGradientVector, "FD");
  if (gradient.empty() && siemens) gradient = data.numbers(kSiemensDirection, "FD");
  frame.marks[kDirection] = gradient.empty() ? group.text(kDirectionality) : written(gradient);
}

std::string firstOf(std::initializer_list<std::vector<double>> choices) {
  for (const std::vector<double>& numbers : choices)
    if (!numbers.empty()) return written(numbers);
  return "";
}

void readMarks(const Groups& groups, const DicomElements& data, const std::vector<size_t>& dimensions,
               DicomFrame& frame) {
  std::string maker = data.text(kManufacturerTag);
  for (char& c : maker) c = char(std::toupper(static_cast<unsigned char>(c)));
  auto& marks = frame.marks;
  marks[kImageType] = imageTypeOf(groups, data, maker.rfind("GE", 0) == 0);
  marks[kEcho] = firstOf({groups.numbers(kEchoGroup, kEffectiveEcho, "FD"),
                          groups.numbers(kEchoGroup, kEchoTime), data.numbers(kEchoNumber, "IS")});
  readDiffusion(groups, data, maker, frame);
  marks[kTemporal] = firstOf({groups.numbers(kFrameContent, kTemporalIndex, "UL"),
                              groups.numbers(kTemporalGroup, kTemporalOffset, "FD"),
                              groups.numbers(kFrameContent, kTemporalId, "IS")});
  marks[kPhase] =
      firstOf({groups.numbers(kCardiac, kTriggerDelay, "FD"), groups.numbers(kCardiac, kCardiacPercent, "FL"),
               groups.numbers(kBreath, kBreathPercent, "FL"), groups.numbers(kCardiac, kTriggerTime)});
  marks[kInversion] =
      firstOf({groups.numbers(kModifier, kInversions, "FD"), groups.numbers(kModifier, kInversionTime)});
  marks[kAcquisition] = firstOf({groups.numbers(kFrameContent, kFrameAcquisition, "US"),
                                 groups.numbers(kFrameContent, kAcquisitionNumber, "IS")});
  for (DicomTag tag : {kFrameReference, kFrameTime, kAcquisitionTime, kContentTime})
    if (marks[kTime].empty()) marks[kTime] = groups.text(kFrameContent, tag);
  if (data.has(kFrameReferenceTime)) marks[kTime] = written(data.first(kFrameReferenceTime));
  const std::vector<double> index = groups.numbers(kFrameContent, kDimensionValues, "UL");
  for (size_t d : dimensions)
    if (d < index.size()) marks[kDimension] += (marks[kDimension].empty() ? "" : " ") + written(index[d]);
}

/// Indices of the file's dimensions but for those of space and of segments.
std::vector<size_t> otherDimensions(const DicomElements& data) {
  std::vector<size_t> others;
  size_t index = 0;
  for (const DicomElements& item : data.items(kDimensions)) {
    const auto pointer = DicomTag(item.first(kDimensionPointer, "AT"));
    const bool space = pointer == kPosition || pointer == 0x00209057 || pointer == kStackId ||
                       pointer == kOrientation || pointer == kSegmentReference;
    if (!space) others.push_back(index);
    ++index;
  }
  return others;
}

void assume(const std::string& what, DicomFile& file) {
  file.assumed += (file.assumed.empty() ? "" : "; ") + what;
}

/// Where an image has the distance of its pixels only at the detector, that, with a note.
void takeImagerSpacing(const DicomElements& data, DicomFile& file) {
  const std::optional<std::array<double, 2>> pixel = pixelOf(data.numbers(kImagerSpacing));
  if (!pixel || file.frames[0].pixel) return;
  for (DicomFrame& frame : file.frames) frame.pixel = pixel;
  assume("its pixels' size is that at the detector (ImagerPixelSpacing), larger than in the body", file);
}

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
      mark = written(numbers[k]);
    else
      mark += std::string(mark.empty() ? "" : ", ") + vector.name + " " + written(numbers[k]);
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
    return "it states " + written(slices) + " slices, and has " + std::to_string(file.frames.size()) +
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
    out.uncertain = "its GridFrameOffsetVector begins with " + written(first) +
                    ", and only from 0, or on transverse planes from the z of its position (" +
                    written(position[2]) + "), it says where they lie";
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
                written(std::abs(gap)) + " mm (" +
                (first.between != 0 ? "SpacingBetweenSlices" : "SliceThickness") +
                (gap > 0 ? ") along" : ") against") + " the normal of the first";
  return out;
}

/// Frames of a file that has one position at most: dose grids, secondary captures, nuclear medicine, films.
void placeFrames(const DicomElements& data, DicomFile& file) {
  DicomFrame& first = file.frames[0];
  const DicomElements detector = data.item(kDetectors);
  if (!first.axes) first.axes = axesOf(detector.numbers(kOrientation));
  if (!first.position) first.position = placeOf(detector.numbers(kPosition));
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
  if (!offsets.assumed.empty()) assume(offsets.assumed, file);
  const Vec3d normal = (*first.axes)[0].cross((*first.axes)[1]).unit(), from = *first.position;
  for (size_t k = 0; k < file.frames.size(); ++k) file.frames[k].position = from + offsets.along[k] * normal;
}

void readFunctionalGroups(const DicomElements& data, const std::vector<DicomElements>& perFrame,
                          DicomFile& file) {
  const GroupItem shared(data.item(kShared));
  const std::vector<size_t> dimensions = otherDimensions(data);
  for (size_t k = 0; k < file.frames.size(); ++k) {
    const GroupItem own(perFrame[k]);
    const Groups groups(own, shared, data);
    DicomFrame& frame = file.frames[k];
    frame.number = int(k);
    readGeometry(groups, frame);
    // A position outside of the groups is none of each frame's.
    if (file.frames.size() > 1 && !groups.hasInGroup(kPlanePosition, kPosition)) frame.position.reset();
    readMarks(groups, data, dimensions, frame);
    if (file.uncertain.empty() && file.frames.size() > 1 && (!frame.position || !frame.axes))
      file.uncertain =
          "frame " + std::to_string(k + 1) + " has no " + (frame.position ? "direction" : "position");
    if (frame.badAxes) file.uncertain = kBadAxes;
  }
}

}  // namespace

void readDicomFrames(const DicomElements& data, DicomFile& file) {
  file.frames.assign(size_t(file.pixels.frames), DicomFrame());
  if (data.has(kModalityTable))
    assume("its values are as stored: the table that gives them a meaning (Modality LUT) is not applied",
           file);
  const std::vector<DicomElements> perFrame = data.items(kPerFrame);
  if (!perFrame.empty() || data.has(kShared)) {
    if (perFrame.size() != file.frames.size())
      throw DicomDamage("it has " + std::to_string(file.frames.size()) +
                        " frames, and functional groups of " + std::to_string(perFrame.size()));
    readFunctionalGroups(data, perFrame, file);
    return;
  }
  const GroupItem none{DicomElements()};
  const Groups groups(none, none, data);
  readGeometry(groups, file.frames[0]);
  readMarks(groups, data, {}, file.frames[0]);
  if (data.has(kDoseScaling))
    file.frames[0].slope = data.first(kDoseScaling, "DS", 1), file.frames[0].intercept = 0;
  takeImagerSpacing(data, file);
  if (file.frames.size() > 1) placeFrames(data, file);
  if (file.frames[0].badAxes) file.uncertain = kBadAxes;
}

}  // namespace slicemorph
