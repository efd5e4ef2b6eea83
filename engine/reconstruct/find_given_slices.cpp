#include "engine/reconstruct/label_slices.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace slicemorph {

namespace {

void checkWhole(double value, int i, int j, int k) {
  if (std::floor(value) == value && std::abs(value) < 2147483648.0) return;
  throw InputError("labels must be whole numbers, got " + std::to_string(value) + " at voxel (" +
                   std::to_string(i) + ", " + std::to_string(j) + ", " + std::to_string(k) + ")");
}

std::vector<int> indices(const std::vector<char>& flags) {
  std::vector<int> at;
  for (size_t i = 0; i < flags.size(); ++i)
    if (flags[i]) at.push_back(int(i));
  return at;
}

/// The greatest common divisor of all distances between labelled slices; 0: fewer than two slices.
int rhythmOf(const std::vector<int>& at) {
  int step = 0;
  for (size_t i = 1; i < at.size(); ++i)
    for (int a = at[i] - at[0], b = step;; a = step) {
      while (b) std::swap(a, b), b %= a;
      step = a;
      break;
    }
  return step;
}

std::vector<int> regular(const std::vector<int>& at, int every) {
  std::vector<int> given;
  for (int s = at.front(); s <= at.back(); s += every) given.push_back(s);
  return given;
}

}  // namespace

LabelledSlices::LabelledSlices(const openvdb::Coord& size) : size_(size) {
  for (int d = 0; d < 3; ++d) found_[d].assign(size_t(size[d]), 0);
}

void LabelledSlices::add(const ImageValues& slab) {
  std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const T* row = values.data();
        const size_t each = size_t(size_[0]) * size_t(size_[1]);
        for (const int after = added_ + int(values.size() / each); added_ < after; ++added_)
          for (int j = 0; j < size_[1]; ++j, row += size_[0]) {
            if constexpr (std::is_floating_point_v<T>)
              for (int i = 0; i < size_[0]; ++i) checkWhole(double(row[i]), i, j, added_);
            const T* end = row + size_[0];
            const T* first = std::find_if(row, end, [](T v) { return v != 0; });
            if (first == end) continue;
            found_[1][size_t(j)] = found_[2][size_t(added_)] = 1;
            char* column = found_[0].data() + (first - row);
            for (const T* value = first; value < end; ++value, ++column) *column |= char(*value != 0);
          }
      },
      slab);
}

GivenSlices findGivenSlices(const LabelledSlices& slices, int axis, int every) {
  if (axis < -1 || axis > 2) throw InputError("axis must be 0, 1 or 2, got " + std::to_string(axis));
  if (every < 0 || every == 1)
    throw InputError("the step from one given slice to the next must be 2 or more, got " +
                     std::to_string(every));
  if (indices(slices.along(0)).empty()) throw InputError("nothing is labelled in the map");
  GivenSlices best;
  int rhythm = every ? 0 : 1, missing = 0;
  bool single = true;
  for (int d = 0; d < 3; ++d) {
    if (axis >= 0 && d != axis) continue;
    const std::vector<int> at = indices(slices.along(d));
    if (at.size() < 2) continue;
    single = false;
    const int step = rhythmOf(at);
    if (every && step % every == 0 && step >= rhythm) rhythm = step, best = {d, regular(at, every)};
    if (!every && step > rhythm) rhythm = step, best = {d, regular(at, step)};
  }
  if (!best.at.empty()) return best;
  if (every)
    throw InputError("labelled slices do not lie " + std::to_string(every) + " apart" +
                     (axis >= 0 ? " along axis " + std::to_string(axis) : std::string(" along any axis")));
  for (int d = 0; d < 3; ++d) {
    const std::vector<int> at = indices(slices.along(d));
    if ((axis >= 0 && d != axis) || at.size() < 2) continue;
    const int empty = at.back() - at.front() + 1 - int(at.size());
    if (empty > missing) missing = empty, best = {d, at};
  }
  if (single)
    throw InputError("only one slice is labelled; at least two are needed to interpolate between them");
  if (!missing) throw InputError("no slice is missing between the labelled ones: the map is dense already");
  return best;
}

}  // namespace slicemorph
