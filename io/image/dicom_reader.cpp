#include "io/image/dicom_reader.h"

#include "io/image/dicom_pixels.h"
#include "io/image/dicom_segmentation.h"
#include "io/image/straighten.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
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

/// What all slices of a volume share, and their places.
struct SlicePlaces {
  Vec3d step[2];                ///< world vectors from a pixel to the next along a row, down a column
  Vec3d normal;                 ///< unit
  double thickness = 1;         ///< of a single slice, millimetres
  std::vector<Vec3d> position;  ///< in the order of the volume's slices
};

/// Of a slice, within its folder.
std::string nameOf(const DicomSeries& series, const DicomSliceRef& ref) {
  const DicomFile& file = series.files[ref.file];
  const std::string name = std::filesystem::path(file.path).filename().string();
  const DicomFrame& frame = file.frames[ref.frame];
  return file.isWhole ? name + " frame " + std::to_string(frame.number + 1) : name;
}

[[noreturn]] void refuseGeometry(const std::string& path, const std::string& why) {
  throw InputError(
      path, "where its slices lie is not certain: " + why +
                "; --spacing X,Y,Z (millimetres) reads them in the file's order, one behind the other");
}

/// Directions and pixel size of the slices.
void placePixels(const std::string& path, const DicomFrame& first, bool alone, const Vec3d& spacing,
                 SlicePlaces& places, Notes& notes) {
  double pixel[2] = {spacing[0], spacing[1]};
  if (first.pixel) {
    pixel[0] = (*first.pixel)[0], pixel[1] = (*first.pixel)[1];
  } else if (spacing[0] == 0) {
    throw InputError(path, "states no pixel size (PixelSpacing); --spacing X,Y,Z (millimetres) sets it");
  } else {
    notes.emplace_back("image.spacing-given", Severity::kNote, "",
                       "states no pixel size: it is that of --spacing");
  }
  Vec3d axes[2] = {{1, 0, 0}, {0, 1, 0}};
  if (first.axes) axes[0] = (*first.axes)[0], axes[1] = (*first.axes)[1];
  if ((!first.axes || !first.position) && alone)
    notes.emplace_back("image.positions-missing", Severity::kWarning, "",
                       std::string("states no ") + (first.axes ? "position" : "directions") +
                           ": it lies at the origin, rows to the left, columns to the back");
  for (int d = 0; d < 2; ++d) places.step[d] = axes[d] * pixel[d];
  places.normal = axes[0].cross(axes[1]).unit();
}

/// Slices whose places are not known: in the order of their instance numbers, or of their frames.
void placeInOrder(const std::string& path, const std::string& why, const DicomSeries& series,
                  std::vector<DicomSliceRef>& slices, const Vec3d& spacing, SlicePlaces& places,
                  Notes& notes) {
  const auto key = [&](const DicomSliceRef& r) {
    return std::pair(series.files[r.file].instance, series.frameOf(r).number);
  };
  std::sort(slices.begin(), slices.end(),
            [&](const DicomSliceRef& a, const DicomSliceRef& b) { return key(a) < key(b); });
  for (size_t i = 1; i < slices.size(); ++i)
    if (key(slices[i]) == key(slices[i - 1]))
      throw InputError(path, "its slices have no positions, and " + nameOf(series, slices[i - 1]) + " and " +
                                 nameOf(series, slices[i]) +
                                 " have the same instance number: their order is not known");
  const Vec3d origin = series.frameOf(slices[0]).position.value_or(Vec3d(0.0));
  for (size_t k = 0; k < slices.size(); ++k)
    places.position.push_back(origin + double(k) * spacing[2] * places.normal);
  notes.emplace_back("image.geometry-insisted", Severity::kWarning, "",
                     why + ": they are " + inMillimetres(spacing[2]) +
                         " apart in the order of their numbers, as --spacing asks");
}

SlicePlaces placesOf(const std::string& path, const DicomSeries& series, std::vector<DicomSliceRef>& slices,
                     const Vec3d& spacing, Notes& notes) {
  const DicomFile& file = series.files[0];
  const DicomFrame& first = series.frameOf(slices[0]);
  const bool given = spacing[2] > 0;
  std::string why = file.uncertain;
  if (why.empty() && slices.size() > 1 && (!first.position || !first.axes))
    why = std::string("its slices have no ") + (first.position ? "directions" : "positions");
  if (!why.empty() && slices.size() == 1) throw InputError(file.path, "cannot be read as slices: " + why);
  if (!why.empty() && !given) refuseGeometry(file.isWhole ? file.path : path, why);
  SlicePlaces places;
  placePixels(file.path, first, slices.size() == 1, spacing, places, notes);
  for (const DicomFile& each : series.files)
    if (!each.assumed.empty()) {
      notes.emplace_back("image.geometry-assumed", Severity::kWarning, "", each.assumed);
      break;
    }
  places.thickness = first.between != 0    ? std::abs(first.between)
                     : first.thickness > 0 ? first.thickness
                     : given               ? spacing[2]
                                           : places.step[0].length();
  if (slices.size() == 1) {
    places.position.push_back(first.position.value_or(Vec3d(0.0)));
  } else if (why.empty()) {
    for (const DicomSliceRef& r : slices) places.position.push_back(*series.frameOf(r).position);
  } else {
    placeInOrder(path, why, series, slices, spacing, places, notes);
  }
  return places;
}

/// Drops doubles: slices at the same place with equal values. Throws InputError where such slices differ.
std::vector<DicomSlice> withoutDoubles(const std::string& path, std::vector<DicomSlice> slices,
                                       const Vec3d& normal, Notes& notes) {
  std::vector<DicomSlice> kept;
  size_t doubled = 0;
  for (DicomSlice& slice : slices) {
    const double along = slice.position.dot(normal);
    const bool same = !kept.empty() && std::abs(along - kept.back().position.dot(normal)) < kSameSlice;
    if (!same) {
      kept.push_back(std::move(slice));
    } else if (slice.values == kept.back().values) {
      if (++doubled <= 3)
        notes.emplace_back("image.slice-doubled", Severity::kNote, slice.name,
                           "is a double of " + kept.back().name + ": left out");
    } else {
      throw InputError(path, kept.back().name + " and " + slice.name + " lie at the same place (" +
                                 inMillimetres(along) +
                                 " along the stack) but differ, and nothing in them tells them apart: two "
                                 "acquisitions are mixed; put each in a folder of its own");
    }
  }
  if (doubled > 3)
    notes.emplace_back("image.slice-doubled", Severity::kNote, "",
                       "and " + std::to_string(doubled - 3) + " more doubled slices");
  return kept;
}

/// Throws InputError where more slices are missing than there are: what is between would be made up.
void checkMissing(const std::string& path, const std::vector<DicomSlice>& slices, const Vec3d& normal) {
  if (slices.size() < 3) return;
  std::vector<double> gaps;
  for (size_t i = 1; i < slices.size(); ++i)
    gaps.push_back((slices[i].position - slices[i - 1].position).dot(normal));
  const size_t widest = size_t(std::max_element(gaps.begin(), gaps.end()) - gaps.begin());
  const double length = (slices.back().position - slices[0].position).dot(normal), most = gaps[widest];
  std::nth_element(gaps.begin(), gaps.begin() + std::ptrdiff_t(gaps.size() / 2), gaps.end());
  const double missing = std::rint(length / gaps[gaps.size() / 2]) + 1 - double(slices.size());
  if (missing <= double(slices.size())) return;
  throw InputError(path, "more slices are missing than there are (" + slices[widest].name + " and " +
                             slices[widest + 1].name + " are " + inMillimetres(most) +
                             " apart): these are several stacks; put each in a folder of its own");
}

void noteOnValues(const DicomValues& values, Notes& notes) {
  if (values.padded == 0) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "%zu voxels are outside of what was scanned (PixelPaddingValue %g): they have the least value of the "
      "others, %g",
      values.padded, values.padding, values.least);
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

ImageFile readSlices(const std::string& path, const DicomSeries& series, const DicomVolume& volume,
                     const Vec3d& spacing, const SizeCheck& check) {
  ImageFile file;
  std::vector<DicomSliceRef> order = volume.slices;
  const SlicePlaces places = placesOf(path, series, order, spacing, file.notes);
  const DicomFile& first = series.files[order[0].file];
  check({first.columns, first.rows, int(order.size())},
        bytesWhileRead(series, order, double(first.columns) * first.rows * double(order.size())));
  DicomValues values = readDicomValues(series, order);
  noteOnValues(values, file.notes);
  if (volume.byOrderOnly)
    file.notes.emplace_back(
        "image.volumes-by-order", Severity::kWarning, "",
        "its slices lie several times at each place, and nothing but their order tells the volumes apart");
  std::vector<DicomSlice> slices;
  for (size_t k = 0; k < order.size(); ++k)
    slices.push_back({nameOf(series, order[k]), places.position[k], std::move(values.slices[k])});
  slices = withoutDoubles(path, std::move(slices), places.normal, file.notes);
  checkMissing(path, slices, places.normal);
  SliceStackInput stack;
  for (int d = 0; d < 2; ++d) stack.step[d] = places.step[d];
  stack.size[0] = first.columns, stack.size[1] = first.rows;
  for (DicomSlice& slice : slices) {
    stack.position.push_back(slice.position);
    stack.names.push_back(slice.name);
    stack.values.push_back(std::move(slice.values));
  }
  straighten(std::move(stack), check, file);
  if (slices.size() == 1) {
    file.image.lattice.step[2] = places.normal * places.thickness;
    file.notes.emplace_back("image.one-slice", Severity::kWarning, "", "it holds one slice");
  }
  return file;
}

}  // namespace

ImageFile readDicomVolume(const std::string& path, const DicomChoice& choice, const Vec3d& spacing,
                          const SizeCheck& check) {
  const DicomSeries& series = choice.series;
  const bool segmentation = series.isSegmentation();
  ImageFile file = segmentation ? readDicomSegmentation(series, int(choice.volume), check)
                                : readSlices(path, series, series.volumes[choice.volume], spacing, check);
  file.format = segmentation ? "DICOM segmentation" : "DICOM series";
  file.about = series.modality + (series.description.empty() ? "" : " '" + series.description + "'");
  if (segmentation) file.about += ", segments " + segmentsOf(series);
  const std::string apart = segmentation ? "" : series.volumes[choice.volume].apart;
  if (!apart.empty()) file.about += ", " + apart;
  return file;
}

}  // namespace slicemorph
