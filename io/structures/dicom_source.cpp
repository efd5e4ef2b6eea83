#include "io/format.h"
#include "io/image/dicom_elements.h"
#include "io/image/dicom_text.h"
#include "io/image/image_formats.h"
#include "io/image/itk_library.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/structure_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <tuple>
#include <utility>

namespace slicemorph {
namespace {

constexpr DicomTag kSourceClass = 0x00080016, kSourceInstance = 0x00080018, kSourceCharacters = 0x00080005,
                   kSourceStudy = 0x0020000d, kSourceSeries = 0x0020000e,
                   kSourceFrameOfReference = 0x00200052;
/// Of the patient and the study (DICOM PS3.3 C.7.1.1, C.7.2.1, C.7.2.2), and the position reference indicator.
constexpr DicomTag kKeptTexts[] = {0x00100010, 0x00100020, 0x00100030, 0x00100040, 0x00080020,
                                   0x00080030, 0x00080050, 0x00080090, 0x00081030, 0x00200010,
                                   0x00101010, 0x00101020, 0x00101030, 0x00201040};
// Slices whose directions differ by less are parallel (0.08 degrees); closer ones are at one place, millimetres.
constexpr double kParallelSlices = 1 - 1e-6, kOnePlace = 1e-3;

/// The place of a slice, which a file holds alone or as a whole frame.
ImagePlane planeOfFrame(const DicomFile& file, const DicomFrame& frame) {
  ImagePlane plane;
  plane.size[0] = file.columns, plane.size[1] = file.rows;
  if (file.columns != file.pixels.columns || file.rows != file.pixels.rows)
    throw InputError("--source",
                     file.path +
                         " is a mosaic: structures cannot refer to its slices, which are parts of a "
                         "picture; use a series with a picture a slice");
  if (!frame.position || !frame.axes || !frame.pixel)
    throw InputError("--source",
                     file.path +
                         " does not say where its pixels lie; use a series with positions, directions "
                         "and pixel spacing");
  plane.origin = *frame.position;
  for (int d = 0; d < 2; ++d) plane.step[d] = (*frame.axes)[size_t(d)] * (*frame.pixel)[size_t(d)];
  if (file.isWhole || file.pixels.frames > 1) plane.frame = frame.number + 1;
  return plane;
}

/// Takes from a file what belongs to the whole series, where it is the first. Returns the class and UID of its image.
std::pair<std::string, std::string> readSourceFile(const std::string& path, DicomSource& source, bool& lost) {
  const std::string bytes = readWholeFile(path);
  try {
    const DicomElements file = DicomElements::ofFile(bytes);
    if (source.planes.empty()) {
      const std::string characters = file.text(kSourceCharacters);
      for (const DicomTag tag : kKeptTexts)
        if (file.has(tag)) {
          const DicomText text = utf8OfDicom(file.text(tag), characters);
          source.texts[tag] = text.text, lost |= text.lost;
        }
      source.study = file.text(kSourceStudy), source.series = file.text(kSourceSeries);
      source.frameOfReference = file.text(kSourceFrameOfReference);
    } else if (file.text(kSourceFrameOfReference) != source.frameOfReference) {
      throw InputError("--source", path + " has another frame of reference than the series' other files");
    }
    return {file.text(kSourceClass), file.text(kSourceInstance)};
  } catch (const DicomDamage& damage) {
    throw IoError(path, damage.what());
  }
}

/// Gives all planes the directions of the first, with a warning: of slices that --force takes as one stack, see
/// seriesOfFiles().
void straightenPlanes(const std::string& input, double turned, DicomSource& source) {
  for (ImagePlane& plane : source.planes)
    for (int d = 0; d < 2; ++d) plane.step[d] = source.planes[0].step[d];
  std::ostringstream text;
  text << "--force: the directions of its slices differ by up to " << turned
       << " degrees: those of the first were taken for all";
  source.notes.emplace_back(kGeometryForced, Severity::kWarning, input, text.str());
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

DicomSource readDicomSource(const std::string& input, bool force) {
  const InputSpec spec = parseInput(input);
  if (!spec.format || spec.format->name != "dicom")
    throw InputError("--source",
                     input + " is no DICOM series; give a folder, folder:2, folder:UID or one of its files");
  DicomSource source;
  const DicomChoice choice = itkReaders().chooseVolume(spec.path, spec.selection, force, source.notes);
  const DicomSeries& series = choice.series;
  if (series.isSegmentation())
    throw InputError("--source", input + " is a segmentation; give the series of images that it belongs to");
  bool lost = false;
  std::map<size_t, std::pair<std::string, std::string>> images;  // class and UID of the image in each file
  for (const DicomSliceRef& slice : series.volumes[choice.volume].slices) {
    const DicomFile& file = series.files[slice.file];
    const auto [image, isNew] = images.try_emplace(slice.file);
    if (isNew) image->second = readSourceFile(file.path, source, lost);
    source.planes.push_back(planeOfFrame(file, series.frameOf(slice)));
    std::tie(source.planes.back().sopClass, source.planes.back().sopInstance) = image->second;
  }
  if (source.frameOfReference.empty() || source.study.empty())
    throw InputError(
        "--source",
        input + " has no frame of reference or no study UID, which the structures would refer to");
  if (lost)
    source.notes.emplace_back(
        "structures.letters-lost", Severity::kWarning, input,
        "its texts are not in the character set that it names, or in one that is not known here: letters "
        "that cannot be told became question marks");
  if (force && series.turned > 0 && series.turned <= kMostTurned)
    straightenPlanes(input, series.turned, source);
  arrangePlanes(input, source);
  return source;
}

}  // namespace slicemorph
