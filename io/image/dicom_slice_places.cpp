#include "io/image/dicom_slice_places.h"

#include "io/image/dicom_geometry.h"
#include "io/image/image_formats.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>

namespace slicemorph {
namespace {

constexpr double kApart = 1e-3;  // millimetres; positions in files are rounded to about this

std::string lengthOf(double millimetres) { return shortText(millimetres) + " mm"; }

/// The axes of the plane, sagittal, coronal or axial, that a line crosses most steeply; rows and columns as scanners write
/// them.
std::array<Vec3d, 2> planeAcross(const Vec3d& line) {
  const Vec3d size(std::abs(line[0]), std::abs(line[1]), std::abs(line[2]));
  if (size[2] >= size[0] && size[2] >= size[1]) return {Vec3d(1, 0, 0), Vec3d(0, 1, 0)};
  if (size[1] >= size[0]) return {Vec3d(1, 0, 0), Vec3d(0, 0, -1)};
  return {Vec3d(0, 1, 0), Vec3d(0, 0, -1)};
}

/// Places the slices of one volume, see placeDicomSlices().
class Placing {
 public:
  Placing(const std::string& path, const DicomSeries& series, std::vector<DicomSliceRef>& slices,
          const ImageOptions& options, Notes& notes)
      : path_(path),
        series_(series),
        slices_(slices),
        options_(options),
        notes_(notes),
        file_(series.files[slices[0].file]),
        first_(series.frameOf(slices[0])),
        why_(doubt()) {}

  SlicePlaces places() {
    if (!why_.empty()) checkInsisted();
    placePixels();
    tellAssumed();
    const double spacing = options_.spacing[2];
    places_.thickness = stated() > 0 ? stated() : spacing > 0 ? spacing : places_.step[0].length();
    if (slices_.size() == 1)
      places_.position.push_back(first_.position.value_or(Vec3d(0.0)));
    else if (why_.empty() || (spacing == 0 && areApart()))
      placeByPositions();
    else
      placeInOrder();
    return std::move(places_);
  }

 private:
  /// Why it is not certain where the slices lie; empty: it is.
  std::string doubt() const {
    if (!file_.uncertain.empty()) return file_.uncertain;
    if (slices_.size() == 1 || (first_.position && first_.axes)) return "";
    return std::string("its slices have no ") + (first_.position ? "directions" : "positions");
  }

  /// Throws InputError where nobody insists, or what is there is no slice.
  void checkInsisted() const {
    const std::string& named = file_.isWhole ? file_.path : path_;
    if (file_.notSplit) throw InputError(named, "cannot be read as slices: " + why_);
    if (options_.force) return;
    if (slices_.size() == 1)
      throw InputError(named, "where its slice lies is not certain: " + why_ +
                                  "; --force takes it as well as can be told");
    if (options_.spacing[2] > 0) return;
    throw InputError(named,
                     "where its slices lie is not certain: " + why_ +
                         "; --spacing X,Y,Z (millimetres) reads them in the file's order, one behind the "
                         "other, --force as well as can be told");
  }

  void warn(const std::string& text) {
    notes_.emplace_back(kGeometryForced, Severity::kWarning, "", "--force: " + text);
  }

  /// Directions and pixel size of the slices.
  void placePixels() {
    double pixel[2] = {options_.spacing[0], options_.spacing[1]};
    if (first_.pixel) {
      pixel[0] = (*first_.pixel)[0], pixel[1] = (*first_.pixel)[1];
    } else if (pixel[0] > 0) {
      notes_.emplace_back("image.spacing-given", Severity::kNote, "",
                          "states no pixel size: it is that of --spacing");
    } else if (options_.force) {
      pixel[0] = pixel[1] = 1;
      warn("states no pixel size: it is taken as 1 mm, so that no length is right");
    } else {
      throw InputError(
          file_.path,
          "states no pixel size (PixelSpacing); --spacing X,Y,Z (millimetres) sets it, --force takes 1 mm");
    }
    const std::array<Vec3d, 2> axes = directions();
    for (int d = 0; d < 2; ++d) places_.step[d] = axes[size_t(d)] * pixel[d];
    places_.normal = axes[0].cross(axes[1]).unit();
  }

  std::array<Vec3d, 2> directions() {
    const bool alone = slices_.size() == 1;
    if (first_.axes && (first_.position || !alone)) return *first_.axes;
    if (options_.force && first_.nearAxes) {
      warn(why_ + ": the nearest that are were taken");
      return *first_.nearAxes;
    }
    if (alone)
      notes_.emplace_back("image.positions-missing", Severity::kWarning, "",
                          std::string("states no ") + (first_.axes ? "position" : "directions") +
                              ": it lies at the origin, rows to the left, columns to the back");
    if (first_.axes) return *first_.axes;
    if (alone || !options_.force || !areApart()) return {Vec3d(1, 0, 0), Vec3d(0, 1, 0)};
    const std::array<Vec3d, 2> axes =
        planeAcross(*series_.frameOf(slices_.back()).position - *first_.position);
    warn(why_ + ": their rows and columns are taken as of " +
         (axes[0][1] > 0   ? "sagittal"
          : axes[1][2] < 0 ? "coronal"
                           : "axial") +
         " slices, which their positions cross most steeply");
    return axes;
  }

  void tellAssumed() {
    for (const DicomFile& each : series_.files)
      if (!each.assumed.empty()) {
        notes_.emplace_back("image.geometry-assumed", Severity::kWarning, "", each.assumed);
        break;
      }
    if (series_.turned == 0) return;
    const std::string differ =
        "the directions of its slices differ by up to " + shortText(series_.turned) + " degrees";
    if (series_.turned > kMostTurned)
      throw InputError(file_.isWhole ? file_.path : path_,
                       differ + ": they are no one stack, whose slices differ by " +
                           std::to_string(int(kMostTurned)) + " degrees at most");
    const std::string taken =
        differ + ": those of " + nameOfSlice(series_, slices_[0]) + " were taken for all";
    if (options_.force)
      warn(taken);
    else
      notes_.emplace_back("image.geometry-insisted", Severity::kWarning, "", taken);
  }

  /// Millimetres from slice to slice as stated; 0: not stated.
  double stated() const { return first_.between != 0 ? std::abs(first_.between) : first_.thickness; }

  /// Whether all slices have positions, and these differ, though the rest is not certain.
  bool areApart() const {
    const bool all = std::all_of(slices_.begin(), slices_.end(), [&](const DicomSliceRef& r) {
      return series_.frameOf(r).position.has_value();
    });
    const bool axesOnly = file_.uncertain.empty() || first_.nearAxes;
    return all && axesOnly &&
           (*series_.frameOf(slices_.back()).position - *first_.position).length() > kApart;
  }

  void placeByPositions() {
    if (!why_.empty())
      std::stable_sort(slices_.begin(), slices_.end(), [&](const DicomSliceRef& a, const DicomSliceRef& b) {
        return series_.frameOf(a).position->dot(places_.normal) <
               series_.frameOf(b).position->dot(places_.normal);
      });
    for (const DicomSliceRef& r : slices_) places_.position.push_back(*series_.frameOf(r).position);
  }

  /// Slices in the order of their instance numbers, or of their frames. Throws InputError where these do not tell it, and
  /// nobody insists on the order of the files.
  void sortByNumbers() {
    const auto key = [&](const DicomSliceRef& r) {
      return std::pair(series_.files[r.file].instance, series_.frameOf(r).number);
    };
    std::stable_sort(slices_.begin(), slices_.end(),
                     [&](const DicomSliceRef& a, const DicomSliceRef& b) { return key(a) < key(b); });
    for (size_t i = 1; i < slices_.size(); ++i) {
      if (key(slices_[i]) != key(slices_[i - 1])) continue;
      const std::string both = nameOfSlice(series_, slices_[i - 1]) + " and " +
                               nameOfSlice(series_, slices_[i]) + " have the same instance number: ";
      if (!options_.force)
        throw InputError(path_, "its slices have no positions, and " + both +
                                    "their order is not known; --force takes that of their names");
      warn(both + "taken in the order of their names");
      return;
    }
  }

  /// The usual distance along the normal from a slice with a position to the next one, and the place of the first; of
  /// slices in their order. None where fewer than two that follow each other have positions that differ.
  std::optional<std::pair<double, Vec3d>> placesToldOfSome() const {
    std::vector<double> gaps;
    std::optional<Vec3d> before, origin;
    for (size_t k = 0; k < slices_.size(); ++k) {
      const std::optional<Vec3d>& at = series_.frameOf(slices_[k]).position;
      if (at && before && k > 0) gaps.push_back((*at - *before).dot(places_.normal));
      before = at;
    }
    if (gaps.empty()) return std::nullopt;
    std::nth_element(gaps.begin(), gaps.begin() + std::ptrdiff_t(gaps.size() / 2), gaps.end());
    const double gap = gaps[gaps.size() / 2];
    if (std::abs(gap) < kApart) return std::nullopt;
    for (size_t k = slices_.size(); k-- > 0;)
      if (const std::optional<Vec3d>& at = series_.frameOf(slices_[k]).position)
        origin = *at - double(k) * gap * places_.normal;
    return std::pair(gap, *origin);
  }

  /// One behind the other, where places are not known.
  void placeInOrder() {
    sortByNumbers();
    double gap = options_.spacing[2];
    Vec3d origin = series_.frameOf(slices_[0]).position.value_or(Vec3d(0.0));
    std::string from = "as --spacing asks";
    if (gap == 0) {
      if (const auto told = placesToldOfSome())
        gap = told->first, origin = told->second, from = "as those are that have positions";
      else if (stated() > 0)
        gap = stated(), from = first_.between != 0 ? "its SpacingBetweenSlices" : "its SliceThickness";
      else
        gap = places_.step[0].length(), from = "the width of a pixel, as nothing says it";
    }
    for (size_t k = 0; k < slices_.size(); ++k)
      places_.position.push_back(origin + double(k) * gap * places_.normal);
    if (gap < 0)
      std::reverse(slices_.begin(), slices_.end()),
          std::reverse(places_.position.begin(), places_.position.end());
    const std::string how =
        why_ + ": they are " + lengthOf(std::abs(gap)) + " apart in the order of their numbers, " + from;
    if (options_.spacing[2] > 0)
      notes_.emplace_back("image.geometry-insisted", Severity::kWarning, "", how);
    else
      warn(how);
  }

  const std::string& path_;
  const DicomSeries& series_;
  std::vector<DicomSliceRef>& slices_;
  const ImageOptions& options_;
  Notes& notes_;
  const DicomFile& file_;
  const DicomFrame first_;
  const std::string why_;
  SlicePlaces places_;
};

}  // namespace

std::string nameOfSlice(const DicomSeries& series, const DicomSliceRef& ref) {
  const DicomFile& file = series.files[ref.file];
  const std::string name = std::filesystem::path(file.path).filename().string();
  const DicomFrame& frame = file.frames[ref.frame];
  return file.isWhole ? name + " frame " + std::to_string(frame.number + 1) : name;
}

SlicePlaces placeDicomSlices(const std::string& path, const DicomSeries& series,
                             std::vector<DicomSliceRef>& slices, const ImageOptions& options, Notes& notes) {
  return Placing(path, series, slices, options, notes).places();
}

}  // namespace slicemorph
