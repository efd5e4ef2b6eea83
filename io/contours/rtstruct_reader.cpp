#include "io/contours/rtstruct_reader.h"

#include "io/image/dicom_elements.h"
#include "io/image/dicom_text.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

namespace slicemorph {

namespace {

// Millimetres. The first two are far below the usual distance between slices.
constexpr double kOffPlane = 0.25;   // points farther off their contour's plane are an error
constexpr double kSamePlane = 0.05;  // contours closer than this are on one plane
constexpr double kRounding = 0.01;   // coordinates in files are rounded to about this
constexpr size_t kHeadSize = 4096;   // bytes of a file in which its storage class is looked for
constexpr const char* kStructureSet = "1.2.840.10008.5.1.4.1.1.481.3";

constexpr DicomTag kNameCharacters = 0x00080005, kSopClass = 0x00080016, kRegions = 0x30060020,
                   kRegionNumber = 0x30060022, kRegionName = 0x30060026, kRegionContours = 0x30060039,
                   kContours = 0x30060040, kKind = 0x30060042, kPointCount = 0x30060046, kPoints = 0x30060050,
                   kObservations = 0x30060080, kReference = 0x30060084, kApproval = 0x300e0002;

struct Loop {
  std::vector<Vec3d> points;
  Vec3d middle{0, 0, 0}, area{0, 0, 0};  ///< mean of the points; area vector, along the normal (Newell)
};

std::vector<double> numbersOf(const std::string& text, const std::string& where) {
  std::vector<double> numbers;
  for (const char* at = text.c_str(); *at;) {
    char* end = nullptr;
    const double value = std::strtod(at, &end);
    while (*end == ' ') ++end;
    if (end == at || !std::isfinite(value) || (*end && *end != '\\'))
      throw IoError(where, "its data hold '" + std::string(at).substr(0, 20) + "', which is no coordinate");
    numbers.push_back(value);
    at = *end ? end + 1 : end;
  }
  return numbers;
}

Loop loopOf(const DicomElements& item, const std::string& where) {
  const std::vector<double> numbers = numbersOf(item.text(kPoints), where);
  const std::string count = item.text(kPointCount);
  if (numbers.size() % 3 != 0 || (!count.empty() && std::atol(count.c_str()) != long(numbers.size() / 3)))
    throw IoError(where, "has " + std::to_string(numbers.size()) + " coordinates where " +
                             (count.empty() ? std::string("three a point") : count + " points") +
                             " are announced");
  Loop loop;
  for (size_t n = 0; n < numbers.size(); n += 3)
    loop.points.emplace_back(numbers[n], numbers[n + 1], numbers[n + 2]);
  for (const Vec3d& p : loop.points) loop.middle += p / double(loop.points.size());
  for (size_t n = 0; n < loop.points.size(); ++n)
    loop.area +=
        0.5 * (loop.points[n] - loop.middle).cross(loop.points[(n + 1) % loop.points.size()] - loop.middle);
  return loop;
}

/// Largest distance of a point from the plane through the middle, millimetres.
double offPlane(const Loop& loop, const Vec3d& normal) {
  double most = 0;
  for (const Vec3d& p : loop.points) most = std::max(most, std::abs((p - loop.middle).dot(normal)));
  return most;
}

/// Makes unit normals of one plane equal: a normal that is nearly along an axis becomes that axis; of any
/// other the last component that is not nearly 0 becomes positive.
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

/// Whether contours of a type enclose an area. INTERPOLATED_PLANAR are what
/// planning systems make between drawn ones, as closed as those.
bool isClosed(const std::string& kind) {
  return kind == "CLOSED_PLANAR" || kind == "CLOSEDPLANAR_XOR" || kind == "INTERPOLATED_PLANAR";
}

/// Reads the contours of one region of interest into a set.
class RegionReader {
 public:
  RegionReader(ContourSet& set, Notes& notes) : where_(set.name), set_(set), notes_(notes) {}

  void read(const DicomElements& region) {
    std::vector<Loop> loops;
    int number = 0, few = 0, interpolated = 0;
    std::map<std::string, int> others;
    for (const DicomElements& item : region.items(kContours)) {
      const std::string where = where_ + ", contour " + std::to_string(++number);
      const std::string kind = item.text(kKind);
      if (!isClosed(kind)) {
        ++others[kind.empty() ? "(none)" : kind];
        continue;
      }
      interpolated += kind == "INTERPOLATED_PLANAR";
      Loop loop = loopOf(item, where);
      if (loop.points.size() < 3 || !(loop.area.length() > 0))
        ++few;
      else
        loops.push_back(std::move(loop));
    }
    for (const auto& [kind, count] : others)
      say(count, " contours of type " + kind + " left out: they enclose nothing");
    say(interpolated, " contours of type INTERPOLATED_PLANAR taken as closed ones");
    say(few, " contours of less than three points or without area left out");
    arrange(loops);
    if (set_.planes.empty())
      notes_.emplace_back("contours.none-closed", Severity::kWarning, where_,
                          "has no closed contour: left out");
  }

 private:
  void say(int count, const std::string& what) {
    if (count > 0)
      notes_.emplace_back("contours.left-out", Severity::kNote, where_, std::to_string(count) + what);
  }

  /// Groups the contours by plane, and sorts the planes along the normal of the largest contour. That
  /// normal is taken for every contour that it fits as well as the contour's own, which is inaccurate
  /// for small contours.
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
        throw IoError(where_, "a contour near (" + positionOf(loops[i].middle) +
                                  ") is not flat: a point lies " + std::to_string(off) +
                                  " mm off its plane, more than " + std::to_string(kOffPlane));
      moved += off > kRounding;
      add(loops[i], normal);
    }
    say(moved,
        " contours not quite flat: points moved onto their plane by up "
        "to 0.25 mm");
    std::stable_sort(set_.planes.begin(), set_.planes.end(),
                     [&](const PlaneContours& a, const PlaneContours& b) {
                       return a.origin.dot(usual) < b.origin.dot(usual);
                     });
  }
  static std::string positionOf(const Vec3d& p) {
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
  Notes& notes_;
};

std::vector<ContourSet> regionsOf(const std::string& path, const DicomElements& all) {
  std::vector<ContourSet> sets;
  const std::string characters = all.text(kNameCharacters);
  for (const DicomElements& item : all.items(kRegions)) {
    ContourSet set;
    set.label = std::atoi(item.text(kRegionNumber).c_str());
    set.name = utf8OfDicom(item.text(kRegionName), characters).text;
    if (set.name.empty()) set.name = "ROI " + std::to_string(set.label);
    sets.push_back(std::move(set));
  }
  if (sets.empty()) throw IoError(path, "the structure set names no region of interest");
  return sets;
}

ContourFile contoursOf(const std::string& path, const DicomElements& all) {
  if (all.text(kSopClass) != kStructureSet)
    throw IoError(path, "is DICOM, but no RT structure set (its SOP class is '" + all.text(kSopClass) + "')");
  if (!all.has(kRegionContours) || !all.has(kObservations))
    throw IoError(path,
                  "the file ends before its contours and observations "
                  "do: it was cut short");
  ContourFile file;
  // The status is optional (PS3.3 A.19.3), and what was not approved yet is usual.
  if (all.text(kApproval) == "REJECTED")
    file.notes.emplace_back("contours.rejected", Severity::kWarning, "",
                            "its approval status is REJECTED: somebody found it not fit for use");
  else if (all.text(kApproval) == "UNAPPROVED")
    file.notes.emplace_back("contours.unapproved", Severity::kDetail, "",
                            "its approval status is UNAPPROVED");
  file.sets = regionsOf(path, all);
  std::set<int> listed;  // numbers of regions that have a list of contours
  for (const DicomElements& item : all.items(kRegionContours)) {
    const int number = std::atoi(item.text(kReference).c_str());
    listed.insert(number);
    const auto set = std::find_if(file.sets.begin(), file.sets.end(),
                                  [&](const ContourSet& s) { return s.label == number; });
    if (set == file.sets.end()) {
      file.notes.emplace_back(
          "contours.left-out", Severity::kNote, "",
          "contours of region " + std::to_string(number) + ", which is not named, left out");
      continue;
    }
    try {
      RegionReader(*set, file.notes).read(item);
    } catch (const IoError& error) {  // the file's other regions are none the worse for it
      set->planes.clear();
      file.refused.push_back({set->label, set->name, error.what()});
    }
  }
  const auto empty = [](const ContourSet& s) { return s.planes.empty(); };
  for (const ContourSet& set : file.sets)
    if (listed.count(set.label) == 0)
      file.notes.emplace_back("contours.left-out", Severity::kNote, set.name, "has no contours: left out");
  if (!std::all_of(file.sets.begin(), file.sets.end(), empty)) return file;
  if (!file.refused.empty()) throw IoError(path, file.refused[0].why);
  std::string why = "no region has a closed contour";
  for (const Note& note : file.notes) why += "; " + note.sentence();
  throw IoError(path, why);
}

bool isStructureSetFile(const std::filesystem::path& path) {
  // Only the head of the file, which names the storage class, so that damaged files are recognised too.
  std::ifstream file(path, std::ios::binary);
  std::string head(kHeadSize, '\0');
  file.read(head.data(), kHeadSize);
  head.resize(size_t(file.gcount()));
  const bool preamble = head.size() >= 132 && head.compare(128, 4, "DICM") == 0;
  const auto beginsWith = [&](std::string_view group) { return head.compare(0, group.size(), group) == 0; };
  using namespace std::string_view_literals;
  if (!preamble && !beginsWith("\x08\0"sv) && !beginsWith("\x02\0"sv)) return false;
  const size_t at = head.find(kStructureSet);
  return at != std::string::npos &&
         (at + std::strlen(kStructureSet) >= head.size() ||
          !std::isdigit(static_cast<unsigned char>(head[at + std::strlen(kStructureSet)])));
}

/// The structure set in a folder that holds nothing else; empty where it holds
/// anything else, or is none.
std::string structureSetIn(const std::string& folder) {
  std::error_code error;
  std::string found;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file(error) || name[0] == '.' || name == "DICOMDIR") continue;
    if (!found.empty() || !isStructureSetFile(entry.path())) return "";
    found = entry.path().string();
  }
  return found;
}

}  // namespace

bool isRtStructureSet(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) return isStructureSetFile(path);
  return std::filesystem::is_directory(path, error) && !structureSetIn(path).empty();
}

ContourFile readRtStructureSet(const std::string& input) {
  const std::string only = structureSetIn(input), path = only.empty() ? input : only;
  const std::string bytes = readWholeFile(path);
  try {
    return contoursOf(path, DicomElements::ofFile(bytes));
  } catch (const DicomDamage& damage) {
    throw IoError(path, damage.what());
  }
}

}  // namespace slicemorph
