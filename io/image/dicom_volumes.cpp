#include "io/image/dicom_volumes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

namespace slicemorph {
namespace {

using Refs = std::vector<DicomSliceRef>;

constexpr double kSamePlace = 1e-3;  // millimetres; positions are rounded to about this

/// Numbers by size, before other texts by their letters.
bool isLess(const std::string& a, const std::string& b) {
  char *endA = nullptr, *endB = nullptr;
  const double x = std::strtod(a.c_str(), &endA), y = std::strtod(b.c_str(), &endB);
  const bool isNumber = !a.empty() && !*endA, otherIsNumber = !b.empty() && !*endB;
  if (isNumber != otherIsNumber) return isNumber;
  if (isNumber && x != y) return x < y;
  return a < b;
}
struct Less {
  bool operator()(const std::string& a, const std::string& b) const { return isLess(a, b); }
};

std::string described(DicomMark mark, const std::string& value) {
  constexpr const char* kNames[kMarkCount] = {"image type",  "echo",    "b-value",        "time",
                                              "direction",   "phase",   "inversion time", "index",
                                              "acquisition", "acquired"};
  return value.empty() ? std::string("no ") + kNames[mark] : kNames[mark] + (" " + value);
}

/// Divides the slices of one series, see splitIntoVolumes().
class Splitter {
 public:
  explicit Splitter(const DicomSeries& series) : series_(series) {
    Refs all;
    for (size_t f = 0; f < series.files.size(); ++f)
      for (size_t k = 0; k < series.files[f].frames.size(); ++k) all.push_back({f, k});
    findPlaces(all);
    splitAlways(std::move(all), 0, {});
    sortLeaves();
  }

  std::vector<DicomVolume> volumes() {
    std::vector<DicomVolume> out;
    for (Leaf& leaf : leaves_) {
      DicomVolume volume;
      std::stable_sort(
          leaf.slices.begin(), leaf.slices.end(),
          [&](const DicomSliceRef& a, const DicomSliceRef& b) { return placeOf(a) < placeOf(b); });
      volume.slices = std::move(leaf.slices);
      for (const auto& [mark, value] : leaf.path) {
        volume.apart += volume.apart.empty() ? "" : ", ";
        volume.apart += mark == kMarkCount ? value : described(DicomMark(mark), value);
        volume.marks.push_back(mark);
        volume.byOrderOnly = volume.byOrderOnly || mark == kMarkCount;
      }
      out.push_back(std::move(volume));
    }
    return out;
  }

 private:
  using Path = std::vector<std::pair<int, std::string>>;  // marks with their values
  using Order = std::tuple<int, int, int, int>;           // instance, frame, row and column of the tile
  struct Leaf {
    Refs slices;
    Path path;
  };

  /// Orders volumes by the marks that tell them apart; directions have no order but that of the files.
  void sortLeaves() {
    std::vector<std::vector<Order>> firsts;
    for (const Leaf& leaf : leaves_) {
      firsts.emplace_back();
      for (size_t depth = 0; depth < leaf.path.size(); ++depth)
        firsts.back().push_back(firstUnder(leaf, depth));
    }
    const auto before = [&](size_t i, size_t j) {
      const Path &a = leaves_[i].path, &b = leaves_[j].path;
      for (size_t d = 0; d < std::min(a.size(), b.size()); ++d) {
        if (a[d].first != b[d].first) return a[d].first < b[d].first;
        if (a[d].second == b[d].second) continue;
        if (a[d].first == kDirection) return firsts[i][d] < firsts[j][d];
        return isLess(a[d].second, b[d].second);
      }
      return a.size() < b.size();
    };
    std::vector<size_t> order(leaves_.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), before);
    std::vector<Leaf> sorted;
    for (size_t i : order) sorted.push_back(std::move(leaves_[i]));
    leaves_ = std::move(sorted);
  }

  /// The first slice, in the order of the files, of all volumes that share a volume's marks down to one of them.
  Order firstUnder(const Leaf& leaf, size_t depth) const {
    Order first;
    bool any = false;
    for (const Leaf& other : leaves_) {
      const bool shares =
          other.path.size() > depth &&
          std::equal(other.path.begin(), other.path.begin() + std::ptrdiff_t(depth) + 1, leaf.path.begin());
      if (!shares) continue;
      for (const DicomSliceRef& r : other.slices)
        if (!any || orderOf(r) < first) first = orderOf(r), any = true;
    }
    return first;
  }
  Order orderOf(const DicomSliceRef& r) const {
    const DicomFrame& frame = series_.frameOf(r);
    return {series_.files[r.file].instance, frame.number, frame.tile[1], frame.tile[0]};
  }

  size_t placeOf(const DicomSliceRef& r) const { return place_[r.file][r.frame]; }
  const std::string& mark(const DicomSliceRef& r, int m) const { return series_.frameOf(r).marks[size_t(m)]; }

  /// Numbers the places along the normal.
  void findPlaces(const Refs& all) {
    for (const DicomFile& file : series_.files) place_.emplace_back(file.frames.size());
    const DicomFrame& first = series_.frameOf(all[0]);
    if (!first.position || !first.axes || !series_.files[0].uncertain.empty()) {
      for (size_t i = 0; i < all.size(); ++i) place_[all[i].file][all[i].frame] = i;
      return;
    }
    const Vec3d normal = (*first.axes)[0].cross((*first.axes)[1]).unit();
    std::vector<std::pair<double, size_t>> along;
    for (size_t i = 0; i < all.size(); ++i)
      along.emplace_back(series_.frameOf(all[i]).position->dot(normal), i);
    std::sort(along.begin(), along.end());
    size_t place = 0;
    for (size_t i = 0; i < along.size(); ++i) {
      if (i > 0 && along[i].first - along[i - 1].first > kSamePlace) ++place;
      const DicomSliceRef& r = all[along[i].second];
      place_[r.file][r.frame] = place;
    }
  }

  /// The slices at each place, copies of one instance counted once.
  std::map<size_t, Refs> byPlace(const Refs& slices) const {
    std::map<size_t, Refs> places;
    std::set<std::tuple<std::string, int, int, int>> seen;
    for (const DicomSliceRef& r : slices) {
      const DicomFile& file = series_.files[r.file];
      const DicomFrame& frame = series_.frameOf(r);
      const std::string& id = file.instanceUid.empty() ? file.path : file.instanceUid;
      if (seen.emplace(id, frame.number, frame.tile[0], frame.tile[1]).second)
        places[placeOf(r)].push_back(r);
    }
    return places;
  }
  size_t mostAtOnePlace(const Refs& slices) const {
    size_t most = 0;
    for (const auto& [place, here] : byPlace(slices)) most = std::max(most, here.size());
    return most;
  }
  std::map<std::string, Refs, Less> byMark(const Refs& slices, int m) const {
    std::map<std::string, Refs, Less> parts;
    for (const DicomSliceRef& r : slices) parts[mark(r, m)].push_back(r);
    return parts;
  }

  void splitAlways(Refs slices, int m, const Path& path) {
    if (m > kTemporal) return splitPlaces(std::move(slices), 0, path);
    std::map<std::string, Refs, Less> parts = byMark(slices, m);
    // What differs from slice to slice is no volume's, though its order may tell volumes apart.
    const bool perSlice = parts.size() == slices.size() && byPlace(slices).size() > 1;
    if (parts.size() == 1 || perSlice) return splitAlways(std::move(slices), m + 1, path);
    for (auto& [value, part] : parts) {
      Path next = path;
      next.emplace_back(m, value);
      splitAlways(std::move(part), m + 1, next);
    }
  }

  /// Divides slices of which several lie at one place.
  void splitPlaces(Refs slices, int m, const Path& path) {
    const size_t most = mostAtOnePlace(slices);
    if (most <= 1) return leaf(std::move(slices), path);
    for (; m < kMarkCount; ++m) {
      std::map<std::string, Refs, Less> parts = byMark(slices, m);
      if (parts.size() == 1) continue;
      const bool fewer = std::all_of(parts.begin(), parts.end(),
                                     [&](const auto& p) { return mostAtOnePlace(p.second) < most; });
      if (parts.size() <= most && fewer) {
        for (auto& [value, part] : parts) {
          Path next = path;
          next.emplace_back(m, value);
          splitPlaces(std::move(part), m + 1, next);
        }
        return;
      }
      // Each slice has its own: the first at each place are one volume, the second another.
      if (splitByRank(slices, most, m, path)) return;
    }
    if (!splitByRank(slices, most, kMarkCount, path)) leaf(std::move(slices), path);
  }

  /// The first slices at all places are one volume, the second another, in the order of a mark or (kMarkCount) of the
  /// files. False where places have unlike numbers of slices and volumes do not follow each other in that order.
  bool splitByRank(const Refs& slices, size_t most, int m, const Path& path) {
    const auto before = [&](const DicomSliceRef& a, const DicomSliceRef& b) {
      return m < kMarkCount ? isLess(mark(a, m), mark(b, m)) : orderOf(a) < orderOf(b);
    };
    std::vector<Refs> volumes(most);
    bool even = true;
    for (auto& [place, here] : byPlace(slices)) {
      even = even && here.size() == most;
      Refs sorted = here;
      std::sort(sorted.begin(), sorted.end(), before);
      for (size_t i = 0; i < sorted.size(); ++i) {
        if (i > 0 && !before(sorted[i - 1], sorted[i])) return false;
        volumes[i].push_back(sorted[i]);
      }
    }
    for (size_t v = 1; !even && v < most; ++v) {
      const auto last = std::max_element(volumes[v - 1].begin(), volumes[v - 1].end(), before);
      const auto first = std::min_element(volumes[v].begin(), volumes[v].end(), before);
      if (!before(*last, *first)) return false;
    }
    for (size_t v = 0; v < most; ++v) {
      Path next = path;
      next.emplace_back(
          m, m < kMarkCount
                 ? mark(*std::min_element(volumes[v].begin(), volumes[v].end(), before), m)
                 : std::to_string(v + 1) + " of " + std::to_string(most) + " in the order of the files");
      leaf(std::move(volumes[v]), next);
    }
    return true;
  }

  void leaf(Refs slices, const Path& path) { leaves_.push_back({std::move(slices), path}); }

  const DicomSeries& series_;
  std::vector<std::vector<size_t>> place_;  // of each file's frames
  std::vector<Leaf> leaves_;
};

}  // namespace

size_t DicomSeries::slices() const {
  size_t count = 0;
  for (const DicomFile& file : files) count += file.frames.size();
  return count;
}

std::vector<DicomVolume> splitIntoVolumes(const DicomSeries& series) { return Splitter(series).volumes(); }

}  // namespace slicemorph
