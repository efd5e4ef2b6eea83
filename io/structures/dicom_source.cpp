#include "io/format.h"
#include "io/image/dicom_elements.h"
#include "io/image/itk_library.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/structure_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace slicemorph {
namespace {

constexpr DicomTag kSourceClass = 0x00080016, kSourceInstance = 0x00080018, kSourceCharacters = 0x00080005,
                   kSourceStudy = 0x0020000d, kSourceSeries = 0x0020000e,
                   kSourceFrameOfReference = 0x00200052, kSourcePosition = 0x00200032,
                   kSourceOrientation = 0x00200037, kSourceSpacing = 0x00280030, kSourceRows = 0x00280010,
                   kSourceColumns = 0x00280011, kSharedGroups = 0x52009229, kFrameGroups = 0x52009230,
                   kPlanePosition = 0x00209113, kPlaneOrientation = 0x00209116, kPixelMeasures = 0x00289110;
/// Of the patient and the study (DICOM PS3.3 C.7.1.1, C.7.2.1, C.7.2.2), and the position reference indicator.
constexpr DicomTag kKeptTexts[] = {0x00100010, 0x00100020, 0x00100030, 0x00100040, 0x00080020,
                                   0x00080030, 0x00080050, 0x00080090, 0x00081030, 0x00200010,
                                   0x00101010, 0x00101020, 0x00101030, 0x00201040};
// Slices whose directions differ by less are parallel (0.08 degrees); closer ones are at one place, millimetres.
constexpr double kParallelSlices = 1 - 1e-6, kOnePlace = 1e-3;

std::vector<double> numbersIn(const std::string& text) {
  std::vector<double> numbers;
  for (const char* at = text.c_str(); *at;) {
    char* end = nullptr;
    numbers.push_back(std::strtod(at, &end));
    if (end == at) return {};
    while (*end == ' ' || *end == '\\') ++end;
    at = end;
  }
  return numbers;
}

std::string utf8OfLatin1(const std::string& text) {
  std::string result;
  for (const unsigned char c : text) {
    if (c < 0x80) {
      result += char(c);
    } else {
      result += char(0xc0 | c >> 6);
      result += char(0x80 | (c & 0x3f));
    }
  }
  return result;
}

/// A text as UTF-8. Where that cannot be told, other letters than ASCII's become question marks.
std::string utf8(const std::string& text, const std::string& characters, bool& lost) {
  if (std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x80 && c != 0x1b; }))
    return text;
  if (characters == "ISO_IR 192") return text;
  if (characters.empty() || characters == "ISO_IR 100") return utf8OfLatin1(text);
  lost = true;
  std::string result = text;
  for (char& c : result)
    if (static_cast<unsigned char>(c) >= 0x80 || c == 0x1b) c = '?';
  return result;
}

/// What places a frame: the innermost of its own groups, those shared by all frames and the file that has it.
class FrameTexts {
 public:
  FrameTexts(const DicomElements& file, const DicomElements* shared, const DicomElements* own)
      : file_(file), shared_(shared), own_(own) {}
  std::vector<double> numbers(DicomTag group, DicomTag tag) const {
    for (const DicomElements* groups : {own_, shared_}) {
      if (!groups) continue;
      const std::vector<DicomElements> items = groups->items(group);
      if (!items.empty() && items[0].has(tag)) return numbersIn(items[0].text(tag));
    }
    return numbersIn(file_.text(tag));
  }

 private:
  const DicomElements& file_;
  const DicomElements *shared_, *own_;
};

ImagePlane sourcePlane(const std::string& path, const DicomElements& file, const FrameTexts& texts) {
  const std::vector<double> position = texts.numbers(kPlanePosition, kSourcePosition),
                            direction = texts.numbers(kPlaneOrientation, kSourceOrientation),
                            spacing = texts.numbers(kPixelMeasures, kSourceSpacing);
  ImagePlane plane;
  plane.size[0] = file.number(kSourceColumns), plane.size[1] = file.number(kSourceRows);
  if (position.size() != 3 || direction.size() != 6 || spacing.size() != 2 || !(spacing[0] > 0) ||
      !(spacing[1] > 0) || plane.size[0] < 1 || plane.size[1] < 1)
    throw InputError("--source",
                     path +
                         " does not say where its pixels lie; use a series with positions, directions "
                         "and pixel spacing");
  plane.origin = {position[0], position[1], position[2]};
  // The first number of the spacing is that between rows.
  plane.step[0] = Vec3d(direction[0], direction[1], direction[2]) * spacing[1];
  plane.step[1] = Vec3d(direction[3], direction[4], direction[5]) * spacing[0];
  plane.sopClass = file.text(kSourceClass), plane.sopInstance = file.text(kSourceInstance);
  return plane;
}

void addPlanes(const std::string& path, const DicomElements& file, std::vector<ImagePlane>& planes) {
  const std::vector<DicomElements> shared = file.items(kSharedGroups), frames = file.items(kFrameGroups);
  const DicomElements* common = shared.empty() ? nullptr : &shared[0];
  if (frames.empty()) {
    planes.push_back(sourcePlane(path, file, {file, common, nullptr}));
    return;
  }
  for (size_t f = 0; f < frames.size(); ++f) {
    planes.push_back(sourcePlane(path, file, {file, common, &frames[f]}));
    planes.back().frame = int(f) + 1;
  }
}

/// Sorts the planes along their normal; of several at one place the first is kept.
void arrangePlanes(const std::string& input, DicomSource& source) {
  std::vector<ImagePlane>& planes = source.planes;
  const Vec3d normal = planes[0].normal();
  for (const ImagePlane& p : planes)
    if (p.normal().dot(normal) < kParallelSlices ||
        p.step[0].unit().dot(planes[0].step[0].unit()) < kParallelSlices || p.size[0] != planes[0].size[0] ||
        p.size[1] != planes[0].size[1])
      throw InputError("--source",
                       input + ": its slices are not parallel or of several sizes; choose one series of it");
  const auto along = [&](const ImagePlane& p) { return p.origin.dot(normal); };
  std::stable_sort(planes.begin(), planes.end(),
                   [&](const ImagePlane& a, const ImagePlane& b) { return along(a) < along(b); });
  const size_t all = planes.size();
  planes.erase(
      std::unique(planes.begin(), planes.end(),
                  [&](const ImagePlane& a, const ImagePlane& b) { return along(b) - along(a) < kOnePlace; }),
      planes.end());
  if (planes.size() < all)
    source.notes.emplace_back("structures.images-at-one-place", Severity::kNote, input,
                              "has several images at one place: only the first of each of the " +
                                  std::to_string(planes.size()) + " places is referred to");
}

}  // namespace

DicomSource readDicomSource(const std::string& input) {
  const InputSpec spec = parseInput(input);
  if (!spec.format || spec.format->name != "dicom")
    throw InputError("--source",
                     input + " is no DICOM series; give a folder, folder:2, folder:UID or one of its files");
  DicomSource source;
  const DicomSeries series = itkReaders().chooseSeries(spec.path, spec.selection, source.notes);
  bool lost = false;
  for (const std::string& path : series.files) {
    const std::string bytes = readWholeFile(path);
    try {
      const DicomElements file = DicomElements::ofFile(bytes);
      if (source.planes.empty()) {
        const std::string characters = file.text(kSourceCharacters);
        for (const DicomTag tag : kKeptTexts)
          if (file.has(tag)) source.texts[tag] = utf8(file.text(tag), characters, lost);
        source.study = file.text(kSourceStudy), source.series = file.text(kSourceSeries);
        source.frameOfReference = file.text(kSourceFrameOfReference);
      } else if (file.text(kSourceFrameOfReference) != source.frameOfReference) {
        throw InputError("--source", path + " has another frame of reference than the series' other files");
      }
      addPlanes(path, file, source.planes);
    } catch (const DicomDamage& damage) {
      throw IoError(path, damage.what());
    }
  }
  if (source.frameOfReference.empty() || source.study.empty())
    throw InputError(
        "--source",
        input + " has no frame of reference or no study UID, which the structures would refer to");
  if (lost)
    source.notes.emplace_back(
        "structures.letters-lost", Severity::kWarning, input,
        "its texts are in a character set that is not known here: letters other than A to Z "
        "became question marks");
  arrangePlanes(input, source);
  return source;
}

}  // namespace slicemorph
