#include "io/contours/csl_reader.h"

#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

namespace slicemorph {

namespace {

/// Largest distance of a point from its plane, as a share of the diagonal of all points' box: coordinates are
/// written with few digits.
constexpr double kOffPlaneShare = 5e-4;
constexpr long kMostLabels = 100000;  // more are taken for damage

struct Component {
  int label = 0, parent = -1;  ///< the component that this one is a hole in
  std::vector<long> points;
};

struct StoredPlane {
  Vec3d normal{0, 0, 1};
  double offset = 0;  ///< the plane is normal . p + offset = 0
  std::vector<Vec3d> points;
  std::vector<Component> components;
};

class CslParser {
 public:
  explicit CslParser(const std::string& path) : path_(path) {
    text_ = readWholeFile(path);
    if (text_.compare(0, 4, "CSLC") != 0) throw IoError(path, "is no CSL file: it does not begin with CSLC");
    at_ = 4;
  }

  std::vector<StoredPlane> planes() {
    const long count = whole("the number of planes", 1, long(text_.size()));
    whole("the number of labels", 1, kMostLabels);
    std::vector<StoredPlane> planes;
    for (long i = 0; i < count; ++i) {
      plane_ = ", plane " + std::to_string(i + 1);
      planes.push_back(plane());
    }
    if (!word().empty()) fail("there is more after the last plane");
    if (endsInLine() && lastPointRepeats(planes.back()))
      fail("the file ends inside its last number: it was cut short");
    return planes;
  }

  bool endsInLine() const { return text_.back() != '\n'; }

 private:
  /// Whether the last number of the file occurs twice in its plane: a point's number that lost its last
  /// digits is that of another point, which some contour already has.
  static bool lastPointRepeats(const StoredPlane& plane) {
    if (plane.components.empty() || plane.components.back().points.empty()) return false;
    const long last = plane.components.back().points.back();
    long uses = 0;
    for (const Component& c : plane.components) uses += std::count(c.points.begin(), c.points.end(), last);
    return uses > 1;
  }

  [[noreturn]] void fail(const std::string& why) const { throw IoError(path_ + plane_, why); }

  std::string word() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    const size_t start = at_;
    while (at_ < text_.size() && !std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return text_.substr(start, at_ - start);
  }
  std::string required(const char* what) {
    std::string w = word();
    if (w.empty()) fail(std::string("the file ends before ") + what);
    return w;
  }
  long toWhole(const std::string& w, const char* what, long least, long most) const {
    char* end = nullptr;
    errno = 0;
    const long value = std::strtol(w.c_str(), &end, 10);
    if (end == w.c_str() || *end || errno || value < least || value > most)
      fail(std::string(what) + " is '" + w.substr(0, 40) + "', not a whole number from " +
           std::to_string(least) + " to " + std::to_string(most));
    return value;
  }
  long whole(const char* what, long least, long most) { return toWhole(required(what), what, least, most); }
  double number(const char* what) {
    const std::string w = required(what);
    char* end = nullptr;
    const double value = std::strtod(w.c_str(), &end);
    if (end == w.c_str() || *end || !std::isfinite(value))
      fail(std::string(what) + " is '" + w.substr(0, 40) + "', not a finite number");
    return value;
  }

  StoredPlane plane() {
    StoredPlane plane;
    whole("the plane's number", -1000000000, 1000000000);
    const long points = whole("the number of points", 0, long(text_.size()));
    const long components = whole("the number of contours", 0, long(text_.size()));
    Vec3d n;
    for (int a = 0; a < 3; ++a) n[a] = number("the plane's equation");
    const double d = number("the plane's equation"), length = n.length();
    if (!(length > 0) || !std::isfinite(1 / length)) fail("its normal is zero");
    plane.normal = n / length;
    plane.offset = d / length;
    for (long i = 0; i < points; ++i) {
      Vec3d p;
      for (int a = 0; a < 3; ++a) p[a] = number("a point");
      plane.points.push_back(p);
    }
    for (long i = 0; i < components; ++i) plane.components.push_back(component(i, points));
    return plane;
  }
  Component component(long index, long points) {
    Component c;
    std::string size = required("a contour");
    const size_t hole = size.find('h');
    if (hole != std::string::npos) {
      c.parent = int(toWhole(size.substr(hole + 1), "the contour that a hole is in", 0, index - 1));
      size.resize(hole);
    }
    const long count = toWhole(size, "a contour's number of points", 0, long(text_.size()));
    c.label = int(whole("a contour's label", 0, kMostLabels));
    for (long i = 0; i < count; ++i) c.points.push_back(whole("a point's number", 0, points - 1));
    return c;
  }

  std::string path_, text_, plane_;
  size_t at_ = 0;
};

void checkPlanes(const std::string& path, const std::vector<StoredPlane>& planes) {
  openvdb::BBoxd box;
  for (const StoredPlane& plane : planes)
    for (const Vec3d& p : plane.points) box.expand(p);
  if (box.empty()) throw IoError(path, "no plane has a contour");
  const double allowed = kOffPlaneShare * box.extents().length();
  for (size_t i = 0; i < planes.size(); ++i)
    for (const Vec3d& p : planes[i].points) {
      const double off = std::abs(planes[i].normal.dot(p) + planes[i].offset);
      if (off > allowed)
        throw IoError(path + ", plane " + std::to_string(i + 1),
                      "a point lies " + std::to_string(off) + " off its plane; at most " +
                          std::to_string(allowed) + " is taken for rounding");
    }
}

/// An empty PlaneContours whose origin is the mean of the points, moved onto the plane.
PlaneContours frameOf(const StoredPlane& plane) {
  Vec3d middle(0.0);
  for (const Vec3d& p : plane.points) middle += p / double(plane.points.size());
  return planeAt(middle - (plane.normal.dot(middle) + plane.offset) * plane.normal, plane.normal);
}

/// Whether a component is part of the boundary of a label's region: it has that label, or is a hole in a
/// component that has it.
bool bounds(const StoredPlane& plane, const Component& c, int label) {
  return c.label == label || (c.parent >= 0 && plane.components[c.parent].label == label);
}

/// The contours of one label on all planes. A hole whose own label is that of the component around it
/// is taken once.
ContourSet setOf(const std::vector<StoredPlane>& planes, int label, Notes& notes) {
  ContourSet set;
  set.label = label;
  set.name = "label" + std::to_string(label);
  int small = 0;
  for (const StoredPlane& plane : planes) {
    PlaneContours contours = frameOf(plane);
    for (const Component& c : plane.components) {
      if (!bounds(plane, c, label)) continue;
      if (c.points.size() < 3) {
        ++small;
        continue;
      }
      std::vector<Vec2d> loop;
      for (long n : c.points) loop.push_back(contours.toPlane(plane.points[n]));
      contours.loops.push_back(std::move(loop));
    }
    set.planes.push_back(std::move(contours));
  }
  if (small > 0)
    notes.emplace_back("contours.small-left-out", Severity::kNote, set.name,
                       std::to_string(small) + " contours of less than three points left out");
  return set;
}

}  // namespace

ContourFile readCsl(const std::string& path) {
  CslParser parser(path);
  const std::vector<StoredPlane> planes = parser.planes();
  checkPlanes(path, planes);
  std::set<int> labels;
  for (const StoredPlane& plane : planes)
    for (const Component& c : plane.components)
      if (c.parent < 0) labels.insert(c.label);
  ContourFile file;
  if (parser.endsInLine())
    file.notes.emplace_back("contours.maybe-cut-short", Severity::kWarning, "",
                            "the last line has no end; the file may have been cut short");
  for (int label : labels) file.sets.push_back(setOf(planes, label, file.notes));
  if (file.sets.empty()) throw IoError(path, "no plane has a contour");
  return file;
}

}  // namespace slicemorph
