#include "io/rtstruct_reader.h"

#include "engine/errors.h"

#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

namespace slicemorph {

namespace {

constexpr double kOffPlane = 0.25;       // millimetres: points farther off their contour's plane are an error
constexpr double kSamePlane = 0.05;      // millimetres: contours closer than this are on one plane
constexpr double kRounding = 0.01;       // millimetres: what files round coordinates to
constexpr const char* kStructureSet = "1.2.840.10008.5.1.4.1.1.481.3";

const gdcm::Tag kSopClass(0x0008, 0x0016), kRegions(0x3006, 0x0020), kRegionNumber(0x3006, 0x0022),
    kRegionName(0x3006, 0x0026), kRegionContours(0x3006, 0x0039), kContours(0x3006, 0x0040), kKind(0x3006, 0x0042),
    kPointCount(0x3006, 0x0046), kPoints(0x3006, 0x0050), kObservations(0x3006, 0x0080), kReference(0x3006, 0x0084),
    kApproval(0x300e, 0x0002);

std::string textOf(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  if (!set.FindDataElement(tag)) return "";
  const gdcm::ByteValue* bytes = set.GetDataElement(tag).GetByteValue();
  if (!bytes || bytes->GetLength() == 0) return "";
  std::string text(bytes->GetPointer(), size_t(bytes->GetLength()));
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
  return text;
}

/// The items of a sequence; none where it is absent.
std::vector<gdcm::DataSet> itemsOf(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  std::vector<gdcm::DataSet> items;
  if (!set.FindDataElement(tag)) return items;
  const gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = set.GetDataElement(tag).GetValueAsSQ();
  if (!sequence) return items;
  for (size_t i = 1; i <= sequence->GetNumberOfItems(); ++i) items.push_back(sequence->GetItem(i).GetNestedDataSet());
  return items;
}

struct Loop {
  std::vector<Vec3d> points;
  Vec3d middle{0, 0, 0}, area{0, 0, 0};  ///< area: along the normal (Newell)
};

std::vector<double> numbersOf(const std::string& text, const std::string& where) {
  std::vector<double> numbers;
  for (const char* at = text.c_str(); *at;) {
    char* end = nullptr;
    const double value = std::strtod(at, &end);
    while (*end == ' ') ++end;
    if (end == at || !std::isfinite(value) || (*end && *end != '\\'))
      throw IoError(where + ": its data hold '" + std::string(at).substr(0, 20) + "', which is no coordinate");
    numbers.push_back(value);
    at = *end ? end + 1 : end;
  }
  return numbers;
}

Loop loopOf(const gdcm::DataSet& item, const std::string& where) {
  const std::vector<double> numbers = numbersOf(textOf(item, kPoints), where);
  const std::string count = textOf(item, kPointCount);
  if (numbers.size() % 3 != 0 || (!count.empty() && std::atol(count.c_str()) != long(numbers.size() / 3)))
    throw IoError(where + ": has " + std::to_string(numbers.size()) + " coordinates where " +
                  (count.empty() ? std::string("three a point") : count + " points") + " are announced");
  Loop loop;
  for (size_t n = 0; n < numbers.size(); n += 3) loop.points.emplace_back(numbers[n], numbers[n + 1], numbers[n + 2]);
  for (const Vec3d& p : loop.points) loop.middle += p / double(loop.points.size());
  for (size_t n = 0; n < loop.points.size(); ++n)
    loop.area += 0.5 * (loop.points[n] - loop.middle).cross(loop.points[(n + 1) % loop.points.size()] - loop.middle);
  return loop;
}

double offPlane(const Loop& loop, const Vec3d& normal) {
  double most = 0;
  for (const Vec3d& p : loop.points) most = std::max(most, std::abs((p - loop.middle).dot(normal)));
  return most;
}

/// The first axis that a normal has a share of is positive, and an axis of the patient is exact where it is meant.
Vec3d tidy(Vec3d normal) {
  for (int a = 0; a < 3; ++a)
    if (std::abs(normal[a]) > 1 - 1e-6) {
      Vec3d axis(0.0);
      axis[a] = 1;
      return axis;
    }
  for (int a = 2; a >= 0; --a)
    if (std::abs(normal[a]) > 1e-3) return normal[a] < 0 ? -normal : normal;
  return normal;
}

/// One region of interest.
class RegionReader {
 public:
  RegionReader(const std::string& path, ContourSet& set, std::vector<std::string>& notes)
      : where_(path + ", " + set.name), set_(set), notes_(notes) {}

  void read(const gdcm::DataSet& region) {
    std::vector<Loop> loops;
    int number = 0, few = 0;
    std::map<std::string, int> others;
    for (const gdcm::DataSet& item : itemsOf(region, kContours)) {
      const std::string where = where_ + ", contour " + std::to_string(++number);
      const std::string kind = textOf(item, kKind);
      if (kind != "CLOSED_PLANAR" && kind != "CLOSEDPLANAR_XOR") {
        ++others[kind.empty() ? "no type" : kind];
        continue;
      }
      Loop loop = loopOf(item, where);
      if (loop.points.size() < 3 || !(loop.area.length() > 0)) ++few;
      else loops.push_back(std::move(loop));
    }
    for (const auto& [kind, count] : others) say(count, " contours of type " + kind + " left out: they enclose nothing");
    say(few, " contours of less than three points or without area left out");
    arrange(loops);
    if (set_.planes.empty()) notes_.push_back(where_ + ": has no closed contour");
  }

 private:
  void say(int count, const std::string& what) {
    if (count > 0) notes_.push_back(where_ + ": " + std::to_string(count) + what);
  }

  /// Groups the contours by plane, in order along each normal. Most regions have one normal: that of the largest
  /// contour is taken wherever it fits, since small contours do not tell theirs well.
  void arrange(const std::vector<Loop>& loops) {
    if (loops.empty()) return;
    const Loop& largest = *std::max_element(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) {
      return a.area.lengthSqr() < b.area.lengthSqr();
    });
    const Vec3d usual = tidy(largest.area.unit());
    int moved = 0;
    for (size_t i = 0; i < loops.size(); ++i) {
      const Vec3d own = tidy(loops[i].area.unit());
      const bool fits = offPlane(loops[i], usual) <= std::max(kRounding, offPlane(loops[i], own));
      const Vec3d normal = fits ? usual : own;
      const double off = offPlane(loops[i], normal);
      if (off > kOffPlane)
        throw IoError(where_ + ": a contour near (" + placeOf(loops[i].middle) + ") is not flat: a point lies " +
                      std::to_string(off) + " mm off its plane, more than " + std::to_string(kOffPlane));
      moved += off > kRounding;
      add(loops[i], normal);
    }
    say(moved, " contours not quite flat: points moved onto their plane by up to 0.25 mm");
    std::stable_sort(set_.planes.begin(), set_.planes.end(), [&](const PlaneContours& a, const PlaneContours& b) {
      return a.origin.dot(usual) < b.origin.dot(usual);
    });
  }
  static std::string placeOf(const Vec3d& p) {
    return std::to_string(p[0]) + ", " + std::to_string(p[1]) + ", " + std::to_string(p[2]);
  }
  void add(const Loop& loop, const Vec3d& normal) {
    auto plane = std::find_if(set_.planes.begin(), set_.planes.end(), [&](const PlaneContours& p) {
      return p.normal.dot(normal) > 1 - 1e-9 && std::abs(p.height(loop.middle)) < kSamePlane;
    });
    if (plane == set_.planes.end()) {
      set_.planes.push_back(planeAt(loop.middle.dot(normal) * normal, normal));
      plane = set_.planes.end() - 1;
    }
    std::vector<Vec2d> points;
    for (const Vec3d& p : loop.points) points.push_back(plane->toPlane(p));
    plane->loops.push_back(std::move(points));
  }

  std::string where_;
  ContourSet& set_;
  std::vector<std::string>& notes_;
};

/// Reads the file; throws IoError where it is none, or is cut short.
void load(const std::string& path, gdcm::Reader& reader) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw IoError(path + " is a folder");
  if (!std::filesystem::exists(path, error)) throw IoError(path + ": cannot be opened: no such file");
  reader.SetFileName(path.c_str());
  bool good = false;
  try {
    good = reader.Read();
  } catch (const std::exception& e) {
    throw IoError(path + ": cannot be read as DICOM: " + e.what());
  }
  if (!good) throw IoError(path + ": cannot be read as DICOM: it is of another kind, damaged or cut short");
}

std::vector<ContourSet> regionsOf(const std::string& path, const gdcm::DataSet& all) {
  std::vector<ContourSet> sets;
  for (const gdcm::DataSet& item : itemsOf(all, kRegions)) {
    ContourSet set;
    set.label = std::atoi(textOf(item, kRegionNumber).c_str());
    set.name = textOf(item, kRegionName);
    if (set.name.empty()) set.name = "ROI " + std::to_string(set.label);
    sets.push_back(std::move(set));
  }
  if (sets.empty()) throw IoError(path + ": the structure set names no region of interest");
  return sets;
}

}  // namespace

bool isRtStructureSet(const std::string& path) {
  gdcm::Reader reader;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  reader.SetFileName(path.c_str());
  try {
    // Only the head of the file: the rest may be damaged, which the reader then says.
    if (!reader.ReadUpToTag(gdcm::Tag(0x0008, 0x0018))) return false;
    return textOf(reader.GetFile().GetDataSet(), kSopClass) == kStructureSet;
  } catch (const std::exception&) {
    return false;
  }
}

ContourFile readRtStructureSet(const std::string& path) {
  gdcm::Reader reader;
  load(path, reader);
  const gdcm::DataSet& all = reader.GetFile().GetDataSet();
  if (textOf(all, kSopClass) != kStructureSet)
    throw IoError(path + " is DICOM, but no RT structure set (its SOP class is '" + textOf(all, kSopClass) + "')");
  if (!all.FindDataElement(kRegionContours) || !all.FindDataElement(kObservations))
    throw IoError(path + ": the file ends before its contours and observations do: it was cut short");
  ContourFile file;
  if (!all.FindDataElement(kApproval))
    file.notes.push_back(path + ": has no approval status, as a file has that was cut short");
  file.sets = regionsOf(path, all);
  for (const gdcm::DataSet& item : itemsOf(all, kRegionContours)) {
    const int number = std::atoi(textOf(item, kReference).c_str());
    const auto set = std::find_if(file.sets.begin(), file.sets.end(), [&](const ContourSet& s) { return s.label == number; });
    if (set == file.sets.end()) {
      file.notes.push_back(path + ": contours of region " + std::to_string(number) + ", which is not named, left out");
      continue;
    }
    RegionReader(path, *set, file.notes).read(item);
  }
  const auto empty = [](const ContourSet& s) { return s.planes.empty(); };
  if (std::all_of(file.sets.begin(), file.sets.end(), empty)) throw IoError(path + ": no region has a closed contour");
  return file;
}

}  // namespace slicemorph
