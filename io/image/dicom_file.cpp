#include "io/image/dicom_file.h"

#include "io/image/dicom_color.h"
#include "io/image/dicom_text.h"
#include "io/mapped_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace slicemorph {
namespace {

constexpr DicomTag kSopClass = 0x00080016, kSopInstance = 0x00080018, kModality = 0x00080060,
                   kDescription = 0x0008103e, kSeries = 0x0020000e, kFrameOfReference = 0x00200052,
                   kInstanceNumber = 0x00200013, kSamples = 0x00280002, kPhotometric = 0x00280004,
                   kFrameCount = 0x00280008, kRows = 0x00280010, kColumns = 0x00280011,
                   kBitsAllocated = 0x00280100, kBitsStored = 0x00280101, kHighBit = 0x00280102,
                   kSign = 0x00280103, kPadding = 0x00280120, kPaddingLimit = 0x00280121,
                   kFloatPixels = 0x7fe00008, kDoublePixels = 0x7fe00009, kPixels = 0x7fe00010,
                   kSegmentationType = 0x00620001, kSegments = 0x00620002, kSegmentNumber = 0x00620004,
                   kSegmentLabel = 0x00620005, kSegmentColor = 0x0062000d, kFullFraction = 0x0062000e,
                   kModalityTable = 0x00283000, kTableForm = 0x00283002, kTableData = 0x00283006,
                   kRescaleIntercept = 0x00281052, kRescaleSlope = 0x00281053, kCharacters = 0x00080005;
constexpr int kMostFrames = 1 << 20;    // far more than any scanner writes; damaged numbers are larger
constexpr double kLargestSide = 65535;  // of Rows and Columns, which have 16 bits (PS3.3 C.7.6.3.1)
constexpr size_t kLeastPacked = 8;  // bytes of a compressed frame: the head of its item (PS3.5 section A.4)

/// Stored values between which lies what is no measurement (PS3.3 C.7.5.1.1.2).
std::optional<std::pair<double, double>> paddingOf(const DicomElements& data, bool isSigned) {
  if (data.size(kPadding) < 2) return std::nullopt;
  // Written as US or as SS, whatever the pixels are.
  const auto stored = [&](DicomTag tag) {
    const auto bits = std::uint16_t(std::int64_t(data.first(tag, isSigned ? "SS" : "US")));
    return isSigned ? double(std::int16_t(bits)) : double(bits);
  };
  const double a = stored(kPadding), b = data.size(kPaddingLimit) >= 2 ? stored(kPaddingLimit) : a;
  return std::pair(std::min(a, b), std::max(a, b));
}

/// Throws DicomDamage where there are fewer bytes of pixels than the file's numbers need, or far more.
void checkPixelBytes(const DicomElements& data, double samples, const DicomFile& file) {
  const DicomPixels& p = file.pixels;
  const size_t stored = data.size(p.tag);
  if (p.frames > 1 && stored / (data.plainPixels() ? 1 : kLeastPacked) < size_t(p.frames))
    throw DicomDamage("it states " + std::to_string(p.frames) + " frames, and has " + std::to_string(stored) +
                      " bytes of pixels");
  if (!data.plainPixels()) return;
  // In floating point, where no product of damaged numbers wraps.
  const double needed = std::ceil(double(p.rows) * p.columns * p.frames * samples * p.bits / 8);
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", needed);
  // Of these, colours are stored at half the size.
  const bool halved = samples == 3 && data.text(kPhotometric).rfind("YBR_FULL_422", 0) == 0;
  if (!halved && double(stored) < needed)
    throw DicomDamage("it has " + std::to_string(stored) + " bytes of pixels, " + text + " are needed");
  if (double(stored) >= 2 * needed && needed > 1)
    throw DicomDamage("it has " + std::to_string(stored) +
                      " bytes of pixels, which are more frames than the " + std::to_string(p.frames) +
                      " that it states");
}

void readPixelFormat(const DicomElements& data, std::string_view bytes, DicomFile& file) {
  DicomPixels& p = file.pixels;
  p.columns = data.number(kColumns), p.rows = data.number(kRows);
  const double frames = data.first(kFrameCount, "IS", 1);
  if (!(frames >= 1 && frames <= kMostFrames))
    throw DicomDamage("its number of frames, " + data.text(kFrameCount) + ", makes no sense");
  p.frames = int(frames);
  p.bits = data.number(kBitsAllocated), p.bitsUsed = data.number(kBitsStored);
  p.highBit = data.number(kHighBit);
  p.isSigned = data.number(kSign) == 1;
  DicomTag tag = kPixels;
  if (data.has(kFloatPixels)) tag = kFloatPixels, p.kind = DicomPixels::kFloat, p.bits = 32;
  if (data.has(kDoublePixels)) tag = kDoublePixels, p.kind = DicomPixels::kDouble, p.bits = 64;
  if (!data.has(tag)) throw DicomDamage("it has no pixels");
  if (p.bits < 1 || p.bits > 64) throw DicomDamage(std::to_string(p.bits) + " bits a pixel make no sense");
  if (p.bitsUsed < 1 || p.bitsUsed > p.bits) p.bitsUsed = p.bits;
  if (p.highBit < p.bitsUsed - 1 || p.highBit >= p.bits) p.highBit = p.bitsUsed - 1;
  p.padding = paddingOf(data, p.isSigned);
  p.tag = tag;
  p.decode = !data.plainPixels() || !data.inFile() || data.bigEndian();
  if (!p.decode) p.at = std::uint64_t(data.bytes(tag).data() - bytes.data());
  const double samples = std::max(1.0, data.first(kSamples, "US", 1));
  checkPixelBytes(data, samples, file);
  if (samples != 1)
    file.foreign = "its pixels have " + std::to_string(std::int64_t(std::min(samples, kLargestSide))) +
                   " values, and only grey ones are read";
  else if (data.text(kPhotometric) == "PALETTE COLOR")
    file.foreign = "its pixels are colours of a palette, and only grey ones are read";
  else if (p.bits != 1 && p.bits != 8 && p.bits != 16 && p.bits != 32 && p.bits != 64)
    file.foreign =
        "its pixels take " + std::to_string(p.bits) + " bits each, and only 1, 8, 16, 32 and 64 are read";
  else if (p.bits == 1 && !data.plainPixels())
    file.foreign = "its pixels are single bits and compressed, which is not read";
}

/// The colour that a segment is to be shown in.
std::optional<std::array<std::uint8_t, 3>> colorOfLab(const DicomElements& segment) {
  const std::vector<double> stored = segment.numbers(kSegmentColor, "US");
  if (stored.size() != 3) return std::nullopt;
  return colorOfDicomLab(stored);
}

/// The table that gives stored values their meaning; none where the sequence is empty. Throws DicomDamage where it is no
/// such.
std::optional<DicomTable> tableOf(const DicomElements& data, bool isSigned) {
  const std::vector<DicomElements> items = data.items(kModalityTable);
  if (items.empty()) return std::nullopt;
  const DicomElements& item = items[0];
  // All three are US or SS as the pixels are, but only the second may be below 0 (PS3.3 C.11.1.1.1).
  const std::vector<double> form = item.numbers(kTableForm, isSigned ? "SS" : "US");
  if (form.size() != 3) throw DicomDamage("its table of values (ModalityLUTSequence) has no LUTDescriptor");
  const auto unsignedOf = [](double v) { return size_t(std::uint16_t(std::int64_t(v))); };
  const size_t count = unsignedOf(form[0]) == 0 ? 65536 : unsignedOf(form[0]), bits = unsignedOf(form[2]);
  const std::string_view bytes = item.bytes(kTableData);
  const bool narrow = bits <= 8 && bytes.size() == count + count % 2 && bytes.size() < 2 * count;
  if (bits < 1 || bits > 16 || (!narrow && bytes.size() < 2 * count))
    throw DicomDamage("its table of values (ModalityLUTSequence) has " + std::to_string(bytes.size()) +
                      " bytes for " + std::to_string(count) + " entries of " + std::to_string(bits) +
                      " bits");
  DicomTable table;
  table.first = form[1];
  const auto byteAt = [&](size_t i) { return unsigned(static_cast<unsigned char>(bytes[i])); };
  for (size_t i = 0; i < count; ++i)
    table.values.push_back(std::uint16_t(narrow             ? byteAt(i)
                                         : data.bigEndian() ? byteAt(2 * i) << 8 | byteAt(2 * i + 1)
                                                            : byteAt(2 * i) | byteAt(2 * i + 1) << 8));
  return table;
}

/// Of whole numbers alone: a table has an entry for each (PS3.3 C.11.1.1).
void readTable(const DicomElements& data, DicomFile& file) {
  if (file.kind != DicomFile::kSlices || file.pixels.kind != DicomPixels::kWhole) return;
  try {
    file.table = tableOf(data, file.pixels.isSigned);
  } catch (const DicomDamage& damage) {
    file.badTable = damage.what();
    file.statesRescale = data.size(kRescaleSlope) > 0 && data.size(kRescaleIntercept) > 0;
  }
}

void readSegments(const DicomElements& data, DicomFile& file) {
  file.kind = DicomFile::kSegmentation;
  file.isWhole = true;
  const std::string characters = data.text(kCharacters);
  for (const DicomElements& item : data.items(kSegments))
    file.segments.push_back({item.number(kSegmentNumber),
                             utf8OfDicom(item.text(kSegmentLabel), characters).text, colorOfLab(item)});
  if (data.text(kSegmentationType) == "FRACTIONAL")
    file.fullFraction = std::max(1.0, data.first(kFullFraction, "US", 255));
}

void read(const DicomElements& data, std::string_view bytes, DicomFile& file) {
  file.seriesUid = data.text(kSeries), file.instanceUid = data.text(kSopInstance);
  file.frameOfReference = data.text(kFrameOfReference);
  file.modality = data.text(kModality),
  file.description = utf8OfDicom(data.text(kDescription), data.text(kCharacters)).text;
  constexpr double kMostInstance = std::numeric_limits<int>::max();
  file.instance = int(std::clamp(data.first(kInstanceNumber, "IS"), -kMostInstance, kMostInstance));
  const std::string type = data.text(kImageTypeTag);
  file.localizer = type.find("LOCALIZER") != std::string::npos || type.find("SCOUT") != std::string::npos;
  const double columns = data.first(kColumns, "US"), rows = data.first(kRows, "US");
  if (columns > kLargestSide || rows > kLargestSide) {
    char text[80];
    std::snprintf(text, sizeof text, "its size, %.0f x %.0f pixels, makes no sense", columns, rows);
    throw DicomDamage(text);
  }
  file.columns = data.number(kColumns), file.rows = data.number(kRows);
  if (!file.damage.empty() || file.columns <= 0 || file.rows <= 0) return;
  readPixelFormat(data, bytes, file);
  if (!file.foreign.empty()) return;
  // Segmentation Storage, and Label Map Segmentation Storage, whose pixels are numbers of segments.
  const std::string sop = data.text(kSopClass);
  file.labelPixels = sop == "1.2.840.10008.5.1.4.1.1.66.7";
  if (sop == "1.2.840.10008.5.1.4.1.1.66.4" || file.labelPixels) readSegments(data, file);
  readTable(data, file);
  readDicomFrames(data, file);
  const bool mosaic = isMosaic(data);
  if (mosaic) splitMosaic(data, file);
  file.isWhole = file.isWhole || mosaic || file.frames.size() > 1;
}

}  // namespace

DicomFile readDicomFile(const std::string& path) {
  DicomFile file;
  file.path = path;
  const MappedFile mapped(path);
  const std::string_view bytes = mapped.bytes();
  const bool marked = bytes.size() >= 132 && bytes.compare(128, 4, "DICM") == 0;
  const DicomElements data = DicomElements::startOfFile(bytes, file.damage);
  try {
    read(data, bytes, file);
  } catch (const DicomDamage& damage) {
    file.damage = damage.what();
    file.frames.clear();
  }
  if (!marked && file.seriesUid.empty() && file.frames.empty()) file.isDicom = false;
  return file;
}

}  // namespace slicemorph
