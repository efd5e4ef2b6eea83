#include "io/sequence.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>

namespace slicemorph {
namespace {

constexpr size_t kMostNumbers = 1000000;

/// Reads a whole number of at most nine digits, which may have a minus, from `at` on, and moves behind it; none where
/// there is no such number.
std::optional<int> readNumber(const std::string& text, size_t& at) {
  const size_t begin = at, digits = at + (at < text.size() && text[at] == '-');
  at = std::min(text.find_first_not_of("0123456789", digits), text.size());
  if (at == digits || at - digits > 9) return std::nullopt;
  return std::atoi(text.substr(begin, at - begin).c_str());
}

/// Adds the numbers of `10`, `10-40`, `10-40x2` or `10-40:2`; false where the text is none of these.
bool addRun(const std::string& text, std::set<int>& numbers) {
  size_t at = 0;
  const std::optional<int> first = readNumber(text, at);
  std::optional<int> last = first, step = 1;
  const bool isRun = at < text.size() && text[at] == '-';
  if (isRun) last = readNumber(text, ++at);
  if (isRun && at < text.size() && (text[at] == 'x' || text[at] == ':')) step = readNumber(text, ++at);
  if (!first || !last || !step || *last < *first || *step < 1 || at != text.size()) return false;
  if (size_t(*last - *first) / size_t(*step) >= kMostNumbers) return false;
  for (long n = *first; n <= *last; n += *step) numbers.insert(int(n));
  return numbers.size() <= kMostNumbers;
}

std::vector<SequenceFile> onlyOf(const std::vector<SequenceFile>& files, const std::string& pattern,
                                 const std::string& range) {
  std::vector<SequenceFile> kept;
  std::vector<int> missing;
  for (int number : numbersOfRange(range)) {
    const auto found = std::lower_bound(files.begin(), files.end(), number,
                                        [](const SequenceFile& file, int n) { return file.number < n; });
    if (found != files.end() && found->number == number)
      kept.push_back(*found);
    else
      missing.push_back(number);
  }
  if (!missing.empty())
    throw IoError(pattern + "@" + range, (missing.size() == 1 ? "frame " : "frames ") +
                                             listOfNumbers(missing) + (missing.size() == 1 ? " is" : " are") +
                                             " missing; there are " + std::to_string(files.front().number) +
                                             " to " + std::to_string(files.back().number));
  return kept;
}

}  // namespace

std::vector<int> numbersOfRange(const std::string& text) {
  std::set<int> numbers;
  std::istringstream runs(text);
  for (std::string run; std::getline(runs, run, ',');)
    if (!addRun(run, numbers)) return {};
  if (!text.empty() && text.back() == ',') return {};
  return {numbers.begin(), numbers.end()};
}

std::string listOfNumbers(const std::vector<int>& numbers) {
  constexpr int kMostRuns = 8;
  std::string list;
  int runs = 0;
  for (size_t i = 0; i < numbers.size(); ++runs) {
    size_t end = i;
    while (end + 1 < numbers.size() && numbers[end + 1] == numbers[end] + 1) ++end;
    if (runs == kMostRuns) return list + " ...";
    list +=
        (i ? ", " : "") + std::to_string(numbers[i]) + (end > i ? "-" + std::to_string(numbers[end]) : "");
    i = end + 1;
  }
  return list;
}

std::vector<int> missingNumbers(const std::vector<SequenceFile>& files) {
  int step = 0;
  for (size_t i = 1; i < files.size(); ++i) step = std::gcd(step, files[i].number - files[i - 1].number);
  std::vector<int> missing;
  for (size_t i = 1; i < files.size(); ++i)
    for (int n = files[i - 1].number + step; n < files[i].number && missing.size() < kMostNumbers; n += step)
      missing.push_back(n);
  return missing;
}

std::vector<SequenceFile> findSequence(const std::string& pattern, const std::string& range) {
  namespace fs = std::filesystem;
  const fs::path parent = fs::path(pattern).parent_path();
  const std::string name = fs::path(pattern).filename().string();
  const size_t last = name.find_last_of('#');
  const size_t first = last == std::string::npos ? 0 : name.find_last_not_of('#', last) + 1;
  const std::string before = name.substr(0, first),
                    after = last == std::string::npos ? "" : name.substr(last + 1);
  std::vector<SequenceFile> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(parent.empty() ? fs::path(".") : parent, error)) {
    const std::string file = entry.path().filename().string();
    if (file.size() <= before.size() + after.size() || file.compare(0, before.size(), before) != 0 ||
        file.compare(file.size() - after.size(), after.size(), after) != 0)
      continue;
    const std::string digits = file.substr(before.size(), file.size() - before.size() - after.size());
    if (digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos) continue;
    const int number = std::stoi(digits);
    const std::string path = (parent / file).string();
    if (OutputName(pattern).path(number) == path) files.push_back({number, path});
  }
  if (files.empty()) throw IoError(pattern, "no such files");
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  if (!range.empty()) return onlyOf(files, pattern, range);
  return files;
}

}  // namespace slicemorph
