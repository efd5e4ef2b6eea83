#include "io/image/dicom_reader.h"

#include "engine/numerics/readable.h"
#include "io/image/dicom_geometry.h"
#include "io/image/dicom_pixels.h"
#include "io/image/dicom_segmentation.h"
#include "io/image/dicom_slice_places.h"
#include "io/image/dicom_times.h"
#include "io/image/image_formats.h"
#include "io/image/straighten.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace slicemorph {
namespace {

constexpr double kSameSlice = 1e-3;  // millimetres; positions are rounded to about this

std::string inMillimetres(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.4g mm", value);
  return digits;
}

/// One slice with its values.
struct DicomSlice {
  std::string name;
  Vec3d position{0, 0, 0};
  ImageValues values;
};

/// Drops doubles: slices at the same place with equal values, and with `force` others, too. Throws InputError where such
/// slices differ.
std::vector<DicomSlice> withoutDoubles(const std::string& path, std::vector<DicomSlice> slices,
                                       const Vec3d& normal, bool force, Notes& notes) {
  std::vector<DicomSlice> kept;
  size_t doubled = 0, other = 0;
  std::string example;
  for (DicomSlice& slice : slices) {
    const double along = slice.position.dot(normal);
    const bool same = !kept.empty() && std::abs(along - kept.back().position.dot(normal)) < kSameSlice;
    if (!same) {
      kept.push_back(std::move(slice));
    } else if (slice.values == kept.back().values) {
      if (++doubled <= 3)
        notes.emplace_back("image.slice-doubled", Severity::kNote, slice.name,
                           "is a double of " + kept.back().name + ": left out");
    } else if (force) {
      if (++other == 1) example = slice.name + " beside " + kept.back().name;
    } else {
      throw InputError(path, kept.back().name + " and " + slice.name + " lie at the same place (" +
                                 inMillimetres(along) +
                                 " along the stack) but differ, and nothing in them tells them apart: two "
                                 "acquisitions are mixed; put each in a folder of its own, or --force takes "
                                 "the first slice at each place");
    }
  }
  if (doubled > 3)
    notes.emplace_back("image.slice-doubled", Severity::kNote, "",
                       "and " + std::to_string(doubled - 3) + " more doubled slices");
  if (other > 0)
    notes.emplace_back(kGeometryForced, Severity::kWarning, "",
                       "--force: of slices at the same place that differ the first was taken, " +
                           std::to_string(other) + " left out (" + example + "): acquisitions may be mixed");
  return kept;
}

/// Throws InputError where more slices are missing than there are: what is between would be made up.
void checkMissing(const std::string& path, const std::vector<DicomSlice>& slices, const Vec3d& normal,
                  bool force, Notes& notes) {
  if (slices.size() < 3) return;
  std::vector<double> gaps;
  for (size_t i = 1; i < slices.size(); ++i)
    gaps.push_back((slices[i].position - slices[i - 1].position).dot(normal));
  const size_t widest = size_t(std::max_element(gaps.begin(), gaps.end()) - gaps.begin());
  const double length = (slices.back().position - slices[0].position).dot(normal), most = gaps[widest];
  std::nth_element(gaps.begin(), gaps.begin() + std::ptrdiff_t(gaps.size() / 2), gaps.end());
  const double missing = std::rint(length / gaps[gaps.size() / 2]) + 1 - double(slices.size());
  if (missing <= double(slices.size())) return;
  const std::string what = "more slices are missing than there are (" + slices[widest].name + " and " +
                           slices[widest + 1].name + " are " + inMillimetres(most) + " apart)";
  if (!force)
    throw InputError(path,
                     what +
                         ": these are several stacks; put each in a folder of its own, or --force makes up "
                         "what lies between");
  notes.emplace_back(kGeometryForced, Severity::kWarning, "",
                     "--force: " + what + ": what lies between is made up");
}

void noteOnValues(const DicomValues& values, Notes& notes) {
  if (values.padded == 0) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "%s voxels are outside of what was scanned (PixelPaddingValue %g): they have the least value of the "
      "others, %g",
      readableCount(double(values.padded)).c_str(), values.padding, values.least);
  notes.emplace_back("image.padding-filled", Severity::kNote, "", text);
}

/// Bytes a voxel takes while a volume is put together: in its slice and in the whole.
double bytesOfVoxel(const DicomSeries& series, const std::vector<DicomSliceRef>& slices) {
  const DicomPixels& pixels = series.files[slices[0].file].pixels;
  const int stored = bytesOfPixel(series.files[slices[0].file]);
  const bool whole = std::all_of(slices.begin(), slices.end(), [&](const DicomSliceRef& r) {
    const DicomFrame& f = series.frameOf(r);
    return f.slope == std::rint(f.slope) && f.intercept == std::rint(f.intercept);
  });
  const int read = whole && pixels.kind == DicomPixels::kWhole ? stored : std::max(stored, 4);
  return 2 * read;
}

/// Bytes taken while `voxels` voxels are read, at most.
double bytesWhileRead(const DicomSeries& series, const std::vector<DicomSliceRef>& slices, double voxels) {
  std::set<size_t> files;
  for (const DicomSliceRef& r : slices) files.insert(r.file);
  double unpacked = 0;
  for (size_t f : files) unpacked += bytesUnpacked(series.files[f]);
  return std::max(2 * unpacked, unpacked + voxels * bytesOfVoxel(series, slices));
}

/// Where a file's table of values cannot be used, tells by what the values become such instead. Throws InputError where
/// nothing says it and nobody insists.
void checkTables(const DicomSeries& series, const std::vector<DicomSliceRef>& slices, bool force,
                 Notes& notes) {
  for (const DicomSliceRef& r : slices) {
    const DicomFile& file = series.files[r.file];
    if (file.badTable.empty()) continue;
    if (!file.statesRescale && !force)
      throw InputError(file.path, file.badTable + "; --force takes the stored values as they are");
    notes.emplace_back("image.table-damaged", Severity::kWarning, nameOfSlice(series, r),
                       (file.statesRescale ? "" : "--force: ") + file.badTable + ": " +
                           (file.statesRescale ? "RescaleSlope and RescaleIntercept are taken instead"
                                               : "the stored values are taken as they are"));
    return;
  }
}

void noteOrder(const DicomVolume& volume, Notes& notes) {
  if (volume.byOrderOnly)
    notes.emplace_back(
        "image.volumes-by-order", Severity::kWarning, "",
        "its slices lie several times at each place, and nothing but their order tells the volumes apart");
}

SliceStackInput stackOf(const DicomFile& first, const SlicePlaces& places, std::vector<DicomSlice> slices) {
  SliceStackInput stack;
  for (int d = 0; d < 2; ++d) stack.step[d] = places.step[d];
  stack.size[0] = first.columns, stack.size[1] = first.rows;
  for (DicomSlice& slice : slices) {
    stack.position.push_back(slice.position);
    stack.names.push_back(slice.name);
    stack.values.push_back(std::move(slice.values));
  }
  return stack;
}

void placeOneSlice(const SlicePlaces& places, ImageFile& file) {
  file.image.lattice.step[2] = places.normal * places.thickness;
  file.notes.emplace_back("image.one-slice", Severity::kWarning, "", "it holds one slice");
}

ImageFile readSlices(const std::string& path, const DicomSeries& series, const DicomVolume& volume,
                     const ImageOptions& options, const SizeCheck& check) {
  ImageFile file;
  std::vector<DicomSliceRef> order = volume.slices;
  const SlicePlaces places = placeDicomSlices(path, series, order, options, file.notes);
  checkTables(series, order, options.force, file.notes);
  const DicomFile& first = series.files[order[0].file];
  check({first.columns, first.rows, int(order.size())},
        bytesWhileRead(series, order, double(first.columns) * first.rows * double(order.size())));
  DicomValues values = readDicomValues(series, order);
  noteOnValues(values, file.notes);
  noteOrder(volume, file.notes);
  std::vector<DicomSlice> slices;
  for (size_t k = 0; k < order.size(); ++k)
    slices.push_back({nameOfSlice(series, order[k]), places.position[k], std::move(values.slices[k])});
  slices = withoutDoubles(path, std::move(slices), places.normal, options.force, file.notes);
  checkMissing(path, slices, places.normal, options.force, file.notes);
  const bool one = slices.size() == 1;
  straighten(stackOf(first, places, std::move(slices)), check, file);
  if (one) placeOneSlice(places, file);
  return file;
}

/// The same of headers alone.
ImageFile headOfSlices(const std::string& path, const DicomSeries& series, const DicomVolume& volume,
                       const ImageOptions& options) {
  ImageFile file;
  std::vector<DicomSliceRef> order = volume.slices;
  const SlicePlaces places = placeDicomSlices(path, series, order, options, file.notes);
  checkTables(series, order, options.force, file.notes);
  noteOrder(volume, file.notes);
  std::vector<DicomSlice> slices;
  for (size_t k = 0; k < order.size(); ++k) {
    const bool same = !slices.empty() &&
                      std::abs((places.position[k] - slices.back().position).dot(places.normal)) < kSameSlice;
    if (!same) slices.push_back({nameOfSlice(series, order[k]), places.position[k], {}});
  }
  if (slices.size() < order.size())
    file.notes.emplace_back(
        "image.slice-doubled", Severity::kNote, "",
        std::to_string(order.size() - slices.size()) +
            " of its slices lie where others do: whether they are doubles was not looked at");
  checkMissing(path, slices, places.normal, options.force, file.notes);
  const bool one = slices.size() == 1;
  layOut(stackOf(series.files[order[0].file], places, std::move(slices)), file);
  if (one) placeOneSlice(places, file);
  file.image.values = noDicomValues(series, order);
  file.notes.emplace_back(kHeaderOnly, Severity::kDetail, "", "its headers alone were read");
  return file;
}

/// What a series says of itself.
void describeSeries(const DicomChoice& choice, ImageFile& file) {
  const DicomSeries& series = choice.series;
  const bool segmentation = series.isSegmentation();
  file.format = segmentation ? "DICOM segmentation" : "DICOM series";
  file.about = series.modality + (series.description.empty() ? "" : " '" + series.description + "'");
  if (segmentation) file.about += ", segments " + segmentsOf(series);
  const std::string apart = segmentation ? "" : series.volumes[choice.volume].apart;
  if (!apart.empty()) file.about += ", " + apart;
  if (segmentation) return;
  const DicomTimeStep step = timeStepOf(series);
  file.header.timeStep = step.seconds, file.header.inSeconds = true;
  if (step.byRepetition)
    file.notes.emplace_back(kTimeByRepetition, Severity::kDetail, "",
                            "its volumes are taken to follow each other by RepetitionTime, " +
                                shortText(step.seconds) + " s: their temporal positions have no times");
}

}  // namespace

ImageFile readDicomVolume(const std::string& path, const DicomChoice& choice, const ImageOptions& options,
                          const SizeCheck& check) {
  const DicomSeries& series = choice.series;
  ImageFile file = series.isSegmentation()
                       ? readDicomSegmentation(series, int(choice.volume), options.force, check)
                       : readSlices(path, series, series.volumes[choice.volume], options, check);
  describeSeries(choice, file);
  return file;
}

ImageFile readDicomHead(const std::string& path, const DicomChoice& choice, const ImageOptions& options) {
  ImageFile file = headOfSlices(path, choice.series, choice.series.volumes[choice.volume], options);
  describeSeries(choice, file);
  return file;
}

}  // namespace slicemorph
