#include "io/image/dicom_segmentation.h"

#include "engine/numerics/readable.h"
#include "io/image/dicom_pixels.h"
#include "io/image/image_formats.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

namespace slicemorph {
namespace {

constexpr double kRounding = 1e-3;       // millimetres; positions in files are rounded to about this
constexpr double kMostPlanes = 1 << 20;  // damaged positions are farther apart
constexpr double kOffLattice = 0.02;     // of a gap: frames farther from a plane of the lattice are refused

std::string lengthText(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", value);
  return digits;
}

std::string nameOf(const DicomSeries& series, int number) {
  for (const DicomSegment& s : series.files[0].segments)
    if (s.number == number && !s.name.empty()) return "'" + s.name + "'";
  return std::to_string(number);
}

/// The lattice of the frames' planes, and each frame's plane on it.
struct Planes {
  ImageLattice lattice;
  std::vector<int> planeOf;
};

void checkFrames(const DicomFile& file) {
  if (!file.uncertain.empty())
    throw InputError(file.path, "is a segmentation whose geometry is not certain: " + file.uncertain);
  const DicomFrame& first = file.frames[0];
  if (!first.position || !first.axes || !first.pixel)
    throw InputError(file.path,
                     "is a segmentation without positions, directions or pixel sizes of its frames");
  for (size_t k = 0; k < file.frames.size(); ++k) {
    const DicomFrame& frame = file.frames[k];
    bool same = frame.position && frame.axes && frame.pixel;
    for (size_t d = 0; same && d < 2; ++d)
      same = ((*frame.axes)[d] - (*first.axes)[d]).length() < 1e-4 &&
             std::abs((*frame.pixel)[d] - (*first.pixel)[d]) < 1e-4;
    if (!same)
      throw InputError(file.path, "is a segmentation whose frames 1 and " + std::to_string(k + 1) +
                                      " have other directions or pixel sizes; only parallel ones are read");
  }
}

/// The distance of planes: the stated one where all frames lie on such planes, else the smallest between two.
double gapOf(const DicomFile& file, const std::vector<double>& along, bool force, Notes& notes) {
  std::vector<double> sorted = along;
  std::sort(sorted.begin(), sorted.end());
  double least = 0;
  for (size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    if (gap > kRounding && (least == 0 || gap < least)) least = gap;
  }
  const double stated = std::abs(file.frames[0].between), thickness = file.frames[0].thickness;
  const auto fits = [&](double gap) {
    return gap > kRounding && std::all_of(along.begin(), along.end(), [&](double a) {
             const double planes = (a - sorted[0]) / gap;
             return std::abs(planes - std::rint(planes)) < kOffLattice;
           });
  };
  if (stated > 0 && fits(stated)) return stated;
  if (least == 0) {
    const double gap = stated > 0 ? stated : thickness > 0 ? thickness : (*file.frames[0].pixel)[0];
    notes.emplace_back("image.one-slice", Severity::kWarning, "",
                       "it holds one plane, taken as " + lengthText(gap) + " mm thick");
    return gap;
  }
  if (!fits(least)) {
    const std::string what = "is a segmentation whose planes lie at no even distance (the nearest two are " +
                             lengthText(least) + " mm apart)";
    if (!force)
      throw InputError(file.path, what + "; --force puts each on the nearest of planes so far apart");
    notes.emplace_back(kGeometryForced, Severity::kWarning, "",
                       "--force: " + what + ": each is put on the nearest of planes so far apart");
    return least;
  }
  if (stated > 0)
    notes.emplace_back("image.spacing-contradicted", Severity::kWarning, "",
                       "it states " + lengthText(stated) + " mm between planes, and its planes lie every " +
                           lengthText(least) + " mm: taken as they lie");
  else if (thickness > 0 && std::abs(thickness - least) > kOffLattice * least)
    notes.emplace_back("image.spacing-assumed", Severity::kWarning, "",
                       "it states no distance between planes: taken is " + lengthText(least) +
                           " mm, the least between its frames; they are " + lengthText(thickness) +
                           " mm thick, so planes between them may be missing");
  return least;
}

Planes planesOf(const DicomFile& file, bool force, Notes& notes) {
  checkFrames(file);
  const DicomFrame& first = file.frames[0];
  const Vec3d x = (*first.axes)[0], y = (*first.axes)[1], normal = x.cross(y).unit();
  std::vector<double> along;
  for (const DicomFrame& frame : file.frames)
    along.push_back((*frame.position - *first.position).dot(normal));
  const double gap = gapOf(file, along, force, notes), lowest = *std::min_element(along.begin(), along.end());
  Planes planes;
  planes.lattice.origin = *first.position + lowest * normal;
  planes.lattice.step[0] = x * (*first.pixel)[0], planes.lattice.step[1] = y * (*first.pixel)[1];
  planes.lattice.step[2] = gap * normal;
  const double span = (*std::max_element(along.begin(), along.end()) - lowest) / gap;
  if (!(span < kMostPlanes))
    throw InputError(file.path, "is a segmentation whose frames lie " + lengthText(span) +
                                    " planes apart: their positions are damaged");
  int most = 0;
  double farthest = 0;
  for (size_t k = 0; k < along.size(); ++k) {
    const int plane = int(std::lround((along[k] - lowest) / gap));
    const Vec3d off = *file.frames[k].position - planes.lattice.origin - double(plane) * gap * normal;
    const bool beside =
        off.length() > kOffLattice * std::min({gap, (*first.pixel)[0], (*first.pixel)[1]}) + kRounding;
    if (beside && !force)
      throw InputError(file.path, "is a segmentation whose frame " + std::to_string(k + 1) + " lies " +
                                      lengthText(off.length()) +
                                      " mm beside the others' lattice; --force puts it there all the same");
    if (beside) farthest = std::max(farthest, off.length());
    planes.planeOf.push_back(plane);
    most = std::max(most, plane);
  }
  if (farthest > 0)
    notes.emplace_back(kGeometryForced, Severity::kWarning, "",
                       "--force: its frames lie up to " + lengthText(farthest) +
                           " mm beside one lattice: they are put on it all the same");
  planes.lattice.size = openvdb::Coord(file.columns, file.rows, most + 1);
  return planes;
}

/// Draws one frame; returns how many voxels another segment had, by that segment.
template <typename T, typename S>
std::map<int, size_t> draw(const std::vector<S>& frame, double from, T label, T* plane) {
  std::map<int, size_t> shared;
  for (size_t i = 0; i < frame.size(); ++i) {
    if (double(frame[i]) < from) continue;
    if (plane[i] != 0 && plane[i] != label) ++shared[int(plane[i])];
    plane[i] = std::max(plane[i], label);
  }
  return shared;
}

template <typename T>
std::vector<T> drawAll(const DicomFile& file, const Planes& planes, int segment,
                       const std::vector<ImageValues>& stored,
                       std::map<std::pair<int, int>, size_t>& overlaps) {
  std::vector<T> labels(planes.lattice.count());
  const size_t each = size_t(file.columns) * size_t(file.rows);
  for (size_t k = 0; k < stored.size(); ++k) {
    T* plane = labels.data() + size_t(planes.planeOf[k]) * each;
    const int label = file.frames[k].segment;
    if (!file.labelPixels && segment != 0 && label != segment) continue;
    // A fraction is inside from a half on.
    const double from = file.fullFraction > 0 ? file.fullFraction / 2 : 1;
    const auto shared = std::visit(
        [&](const auto& frame) {
          if (!file.labelPixels) return draw(frame, from, T(label), plane);
          for (size_t i = 0; i < each; ++i)
            if (segment == 0 || int(frame[i]) == segment) plane[i] = T(frame[i]);
          return std::map<int, size_t>();
        },
        stored[k]);
    for (const auto& [other, count] : shared) overlaps[std::minmax(other, label)] += count;
  }
  return labels;
}

void checkSegments(const DicomFile& file, int segment) {
  std::set<int> known;
  for (const DicomSegment& s : file.segments) known.insert(s.number);
  for (size_t k = 0; !file.labelPixels && k < file.frames.size(); ++k)
    if (const int n = file.frames[k].segment; n < 1 || n > 65535 || (!known.empty() && !known.count(n)))
      throw InputError(file.path, "is a segmentation whose frame " + std::to_string(k + 1) +
                                      " is of no segment that it describes (" + std::to_string(n) + ")");
  if (segment != 0 && !known.count(segment))
    throw InputError(file.path, "has no segment " + std::to_string(segment));
}

/// Throws InputError where pixels that are numbers of segments may be none of these (PS3.3 C.8.20.2).
void checkLabelPixels(const DicomFile& file) {
  const DicomPixels& p = file.pixels;
  if (!file.labelPixels || (p.bits <= 16 && !p.isSigned && p.kind == DicomPixels::kWhole)) return;
  throw InputError(file.path, "is a label map of " + std::to_string(p.bits) + " bits a pixel" +
                                  (p.kind != DicomPixels::kWhole ? ", floating point"
                                   : p.isSigned                  ? ", signed"
                                                                 : "") +
                                  "; only unsigned ones of 8 and 16 bits are read");
}

}  // namespace

std::string segmentsOf(const DicomSeries& series) {
  std::string text;
  for (const DicomSegment& s : series.files[0].segments)
    text += (text.empty() ? "" : ", ") + std::to_string(s.number) + " " + s.name;
  return text;
}

ImageFile readDicomSegmentation(const DicomSeries& series, int segment, bool force, const SizeCheck& check) {
  const DicomFile& source = series.files[0];
  checkSegments(source, segment);
  checkLabelPixels(source);
  ImageFile file;
  file.notes.emplace_back(kLabelsStated, Severity::kDetail, "",
                          "it is a segmentation: its values are labels");
  for (const DicomSegment& s : source.segments)
    if (segment == 0 || s.number == segment) file.header.labels.push_back({s.number, s.name, s.color});
  const Planes planes = planesOf(source, force, file.notes);
  int most = 0;
  for (const DicomFrame& frame : source.frames) most = std::max(most, frame.segment);
  if (source.labelPixels && source.pixels.bits > 8) most = 65535;
  const double drawn = double(source.frames.size()) * source.columns * source.rows * bytesOfPixel(source),
               unpacked = bytesUnpacked(source);
  check(planes.lattice.size,
        std::max(2 * unpacked, double(planes.lattice.count()) * (most > 255 ? 2 : 1) + drawn + unpacked));
  file.image.lattice = planes.lattice;
  const std::vector<ImageValues> stored = readStoredFrames(source);
  std::map<std::pair<int, int>, size_t> overlaps;
  if (most > 255)
    file.image.values = drawAll<std::uint16_t>(source, planes, segment, stored, overlaps);
  else
    file.image.values = drawAll<std::uint8_t>(source, planes, segment, stored, overlaps);
  if (source.fullFraction > 0)
    file.notes.emplace_back("image.fractions-cut", Severity::kNote, "",
                            "it holds fractions of " + lengthText(source.fullFraction) +
                                ": a voxel belongs to a segment from a half on");
  for (const auto& [pair, count] : overlaps)
    file.notes.emplace_back("image.segments-overlap", Severity::kWarning, "",
                            "segments " + std::to_string(pair.first) + " (" + nameOf(series, pair.first) +
                                ") and " + std::to_string(pair.second) + " (" + nameOf(series, pair.second) +
                                ") share " + readableCount(double(count)) + " voxels: the label map has " +
                                std::to_string(pair.second) + " there (:@" + std::to_string(pair.first) +
                                " behind the name reads one segment alone)");
  return file;
}

}  // namespace slicemorph
