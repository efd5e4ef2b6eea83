#include "io/image/dicom_geometry.h"
#include "io/image/dicom_times.h"

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
                   kIntercept = 0x00281052, kSlope = 0x00281053, kFrameContent = 0x00209111,
                   kStackId = 0x00209056, kTemporalIndex = 0x00209128, kFrameAcquisition = 0x00209156,
                   kDimensionValues = 0x00209157, kFrameTime = 0x00189074, kFrameReference = 0x00189151,
                   kTemporalGroup = 0x00209310, kTemporalOffset = 0x0020930d, kEchoGroup = 0x00189114,
                   kEffectiveEcho = 0x00189082, kDiffusion = 0x00189117, kB = 0x00189087,
                   kDirectionality = 0x00189075, kGradient = 0x00189076, kGradientVector = 0x00189089,
                   kCardiac = 0x00189118, kTriggerDelay = 0x00209153, kCardiacPercent = 0x00209241,
                   kBreath = 0x00209253, kBreathPercent = 0x00209248, kModifier = 0x00189115,
                   kInversions = 0x00189079, kSegmentGroup = 0x0062000a, kSegmentReference = 0x0062000b,
                   kUnassignedShared = 0x00209170, kUnassigned = 0x00209171, kFrameType = 0x00089007,
                   kComplex = 0x00089208, kDimensions = 0x00209222, kDimensionPointer = 0x00209165;
constexpr DicomTag kFrameTypes[] = {0x00189226, 0x00189329, 0x00189751, 0x00189504,
                                    0x00189807, 0x00209450, 0x00189806};  // of MR, CT, PET, XA, US, ...
// Of classic files.
constexpr DicomTag kEchoTime = 0x00180081, kEchoNumber = 0x00180086, kTemporalId = 0x00200100,
                   kTriggerTime = 0x00181060, kInversionTime = 0x00180082, kAcquisitionNumber = 0x00200012,
                   kAcquisitionTime = 0x00080032, kContentTime = 0x00080033, kFrameReferenceTime = 0x00541300,
                   kSiemensB = 0x0019100c, kSiemensDirection = 0x0019100e, kGeB = 0x00431039,
                   kGePart = 0x0043102f, kPhilipsB = 0x20011003;
constexpr DicomTag kTiming = 0x00189112, kRepetition = 0x00180080, kAcquisitionType = 0x00180023,
                   kSequences = 0x00180020, kAcquisitionDate = 0x00080022, kAcquisitionMoment = 0x0008002a;
// Outside of functional groups.
constexpr DicomTag kDoseScaling = 0x3004000e, kImagerSpacing = 0x00181164;

constexpr const char* kBadAxes =
    "its directions (ImageOrientationPatient) are no unit vectors at right angles";

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

std::string written(const std::vector<double>& values) {
  std::string text;
  for (double v : values) text += (text.empty() ? "" : " ") + shortText(v);
  return text;
}

void readGeometry(const Groups& groups, DicomFrame& frame) {
  const std::vector<double> at = groups.numbers(kPlanePosition, kPosition);
  frame.position = dicomPlace(at);
  const std::vector<double> axes = groups.numbers(kPlaneOrientation, kOrientation);
  frame.axes = dicomAxes(axes);
  frame.badAxes = !axes.empty() && !frame.axes;
  if (frame.badAxes) frame.nearAxes = nearestAxes(axes);
  frame.pixel = dicomPixel(groups.numbers(kPixelMeasures, kPixelSpacing));
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
  if (!b.empty()) frame.marks[kBValue] = shortText(b[0]);
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
  if (data.has(kFrameReferenceTime)) marks[kTime] = shortText(data.first(kFrameReferenceTime));
  const std::vector<double> index = groups.numbers(kFrameContent, kDimensionValues, "UL");
  for (size_t d : dimensions)
    if (d < index.size()) marks[kDimension] += (marks[kDimension].empty() ? "" : " ") + shortText(index[d]);
}

DicomTimes timesOf(const Groups& groups, const DicomElements& data) {
  DicomTimes times;
  const std::vector<double> offset = groups.numbers(kTemporalGroup, kTemporalOffset, "FD"),
                            reference = data.numbers(kFrameReferenceTime),
                            repetition = groups.numbers(kTiming, kRepetition);
  if (!offset.empty()) times.offset = offset[0];
  if (!reference.empty()) times.acquired = reference[0] / 1000;  // milliseconds
  for (DicomTag tag : {kFrameReference, kFrameTime, kAcquisitionMoment})
    if (!times.acquired) times.acquired = secondsOfDateTime(groups.text(kFrameContent, tag));
  if (!times.acquired)
    times.acquired = secondsOfDateTime(data.text(kAcquisitionDate), data.text(kAcquisitionTime));
  // Only echo planar imaging of slices is sure to take one repetition a volume: others take one or more a line.
  const std::string sequences = data.text(kSequences);
  const bool lines = data.text(kAcquisitionType) == "3D" ||
                     (!sequences.empty() && sequences.find("EP") == std::string::npos);
  if (!repetition.empty() && !lines) times.repetition = std::max(0.0, repetition[0] / 1000);
  return times;
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

/// Where an image has the distance of its pixels only at the detector, that, with a note.
void takeImagerSpacing(const DicomElements& data, DicomFile& file) {
  const std::optional<std::array<double, 2>> pixel = dicomPixel(data.numbers(kImagerSpacing));
  if (!pixel || file.frames[0].pixel) return;
  for (DicomFrame& frame : file.frames) frame.pixel = pixel;
  file.assume("its pixels' size is that at the detector (ImagerPixelSpacing), larger than in the body");
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
    frame.times = timesOf(groups, data);
    if (file.uncertain.empty() && file.frames.size() > 1 && (!frame.position || !frame.axes))
      file.uncertain =
          "frame " + std::to_string(k + 1) + " has no " + (frame.position ? "direction" : "position");
    if (frame.badAxes) file.uncertain = kBadAxes;
  }
}

}  // namespace

void readDicomFrames(const DicomElements& data, DicomFile& file) {
  file.frames.assign(size_t(file.pixels.frames), DicomFrame());
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
  file.frames[0].times = timesOf(groups, data);
  if (data.has(kDoseScaling))
    file.frames[0].slope = data.first(kDoseScaling, "DS", 1), file.frames[0].intercept = 0;
  takeImagerSpacing(data, file);
  if (file.frames.size() > 1) placeDicomFrames(data, file);
  if (file.frames[0].badAxes) file.uncertain = kBadAxes;
}

}  // namespace slicemorph
