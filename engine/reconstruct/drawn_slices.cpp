#include "engine/reconstruct/drawn_slices.h"

#include "engine/reconstruct/slice_runs.h"

#include <algorithm>
#include <numeric>

namespace slicemorph {

namespace {

/// Share of the smaller of two outlines that must lie over the other for one body.
constexpr double kOver = 0.25;
/// Share of a label's place that is background where it was not drawn; neighbours reach in by a little.
constexpr double kEmpty = 0.75;

bool haveCommon(const std::vector<int>& a,
                const std::vector<int>& b) {  // both ascending
  for (size_t i = 0, j = 0; i < a.size() && j < b.size();)
    if (a[i] == b[j])
      return true;
    else
      a[i] < b[j] ? ++i : ++j;
  return false;
}

bool inEqualSteps(const std::vector<int>& at) {
  for (size_t i = 2; i < at.size(); ++i)
    if (at[i] - at[i - 1] != at[1] - at[0]) return false;
  return true;
}

}  // namespace

void DrawnSlices::add(const LabelSlice& slice, int at) {
  std::vector<int> pixels(size_t(slice.layout.width) * size_t(slice.layout.height));
  std::map<int, std::vector<Run>> runs;
  visitRuns(slice, [&](int x, int y, int end, int value) {
    if (value == 0) return;
    runs[value].push_back({y, x, end});
    std::fill(pixels.begin() + std::ptrdiff_t(y) * slice.layout.width + x,
              pixels.begin() + std::ptrdiff_t(y) * slice.layout.width + end, value);
  });
  std::map<int, size_t> sizes;
  std::vector<int> present;
  for (const auto& [value, mask] : runs) {
    present.push_back(value);
    for (const Run& run : mask) sizes[value] += size_t(run.x1 - run.x0);
  }
  look(pixels, slice.layout.width, sizes, at);
  for (auto& [value, mask] : runs) {
    Label& label = labels_[value];
    label.at.push_back(at), label.last = std::move(mask), label.beside = present;
    label.skipped.clear();
  }
  at_.push_back(at);
}

void DrawnSlices::look(const std::vector<int>& pixels, int width, const std::map<int, size_t>& now, int at) {
  std::vector<int> present;
  for (const auto& one : now) present.push_back(one.first);
  for (auto& [value, label] : labels_) {
    const bool here = now.count(value) > 0;
    size_t whole = 0, same = 0;
    for (const Run& run : label.last) {
      const auto row = pixels.begin() + std::ptrdiff_t(run.y) * width;
      whole += size_t(run.x1 - run.x0);
      same += size_t(std::count(row + run.x0, row + run.x1, here ? value : 0));
    }
    if (!here) {
      label.pending.push_back(
          {at, double(same) >= kEmpty * double(whole), haveCommon(label.beside, present)});
      label.skipped.insert(label.skipped.end(), present.begin(), present.end());
      continue;
    }
    const bool body = double(same) >= kOver * double(std::min(whole, now.at(value)));
    label.consecutive |= label.at.back() == at_.back();
    if (body && at > label.at.back() + 1) bodies_.emplace_back(label.at.back(), at);
    std::sort(label.skipped.begin(), label.skipped.end());
    const bool common = haveCommon(label.skipped, present);
    for (Skip& skip : label.pending) skip.body = body, skip.shared |= common;
    label.skips.insert(label.skips.end(), label.pending.begin(), label.pending.end());
    label.pending.clear();
  }
}

bool DrawnSlices::goesOnOver(int empty) const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [&](const auto& body) { return body.first < empty && empty < body.second; });
}

std::vector<OwnSlices> DrawnSlices::ownSlices(const std::vector<int>& given) const {
  const bool regular = inEqualSteps(given);
  std::vector<OwnSlices> own;
  for (const auto& [value, label] : labels_) {
    if (label.skips.empty() || (regular && label.consecutive)) continue;
    int step = 0;
    for (const int at : label.at) step = std::gcd(step, at - label.at[0]);
    std::vector<int> unstated;
    for (const Skip& skip : label.skips) {
      const bool steps = label.at.size() > 2 && (!label.consecutive || (skip.at - label.at[0]) % step != 0);
      if (skip.body && skip.empty && (!skip.shared || steps)) unstated.push_back(skip.at);
    }
    if (unstated.empty()) continue;
    OwnSlices slices{value, {}};
    for (const int at : given)
      if (at >= label.at.front() && at <= label.at.back() &&
          !std::binary_search(unstated.begin(), unstated.end(), at))
        slices.at.push_back(at);
    own.push_back(std::move(slices));
  }
  return own;
}

}  // namespace slicemorph
