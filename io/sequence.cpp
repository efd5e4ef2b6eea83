#include "io/sequence.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"

#include <algorithm>
#include <filesystem>

namespace slicemorph {

std::vector<SequenceFile> findSequence(const std::string& pattern) {
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
  return files;
}

}  // namespace slicemorph
