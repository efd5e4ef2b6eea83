#include "slicemorph/io/memory.h"

#include "engine/numerics/readable.h"

#include <sys/resource.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

namespace slicemorph {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// The number after `key` in a file of lines `key number`, or `key: number`; infinity where there is none.
double numberIn(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  for (std::string word; file >> word;) {
    if (word == key || word == key + ":") {
      double value = 0;
      return file >> value ? value : kNoLimit;
    }
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return kNoLimit;
}

/// The file's only number; infinity for "max" and where there is no file.
double numberOf(const std::string& path) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? value : kNoLimit;
}

/// Files of one version of control groups.
struct GroupFiles {
  std::string folder, limit, used, cache;  ///< cache: in memory.stat, pages that are given back when needed
};

/// What a control group and those around it leave. `group`: its path, as in /proc/self/cgroup.
double leftInGroups(const GroupFiles& files, std::string group) {
  double left = kNoLimit;
  while (true) {
    const std::string folder = files.folder + (group == "/" ? "" : group);
    const double limit = numberOf(folder + "/" + files.limit), used = numberOf(folder + "/" + files.used);
    const double cache = numberIn(folder + "/memory.stat", files.cache);
    if (std::isfinite(limit) && std::isfinite(used))
      left = std::min(left, limit - used + (std::isfinite(cache) ? cache : 0));
    if (group.empty() || group == "/") return left;
    group.resize(group.find_last_of('/'));
  }
}

double leftInGroups(const std::string& root) {
  std::ifstream list(root + "/proc/self/cgroup");
  double left = kNoLimit;
  for (std::string line; std::getline(list, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string kinds = line.substr(first + 1, second - first - 1), group = line.substr(second + 1);
    const std::string top = root + "/sys/fs/cgroup";
    if (group.empty() || group[0] != '/') continue;
    if (kinds.empty())  // version 2
      left = std::min(left, leftInGroups({top, "memory.max", "memory.current", "inactive_file"}, group));
    else if (("," + kinds + ",").find(",memory,") != std::string::npos)
      left = std::min(left, leftInGroups({top + "/memory", "memory.limit_in_bytes", "memory.usage_in_bytes",
                                          "total_inactive_file"},
                                         group));
  }
  return left;
}

/// What the process's own limit of a kind leaves.
double leftOf(int kind, const std::string& root, const char* used) {
  rlimit limit{};
  if (::getrlimit(__rlimit_resource_t(kind), &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  const double kilobytes = numberIn(root + "/proc/self/status", used);
  return double(limit.rlim_cur) - (std::isfinite(kilobytes) ? 1024 * kilobytes : 0);
}

}  // namespace

double freeMemory(const std::string& root) {
  const double available = 1024 * numberIn(root + "/proc/meminfo", "MemAvailable");
  const double left = std::min({available, leftInGroups(root), leftOf(RLIMIT_AS, root, "VmSize"),
                                leftOf(RLIMIT_DATA, root, "VmData")});
  return std::max(left, 0.0);
}

double takenMemory() {
  const double kilobytes = numberIn("/proc/self/status", "VmRSS");
  return std::isfinite(kilobytes) ? 1024 * kilobytes : 0;
}

std::string describeBytes(double bytes) { return readableBytes(bytes); }

double parseBytes(const std::string& option, const std::string& text, double free) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  std::string unit;
  for (; *end; ++end)
    if (*end != ' ') unit += char(std::toupper(*end));
  if (unit.size() == 3 && unit.compare(1, 2, "IB") == 0) unit.resize(1);
  if (unit.size() == 2 && unit[1] == 'B') unit.resize(1);
  const size_t power = std::string("KMGT").find(unit);
  const bool known = unit.size() == 1 && (unit == "%" || power != std::string::npos);
  const bool digits = !text.empty() && std::isdigit(static_cast<unsigned char>(text[0]));
  if (!digits || !known || !(number > 0) || !std::isfinite(number))
    throw InputError(option + " " + text +
                     ": expected a size with its unit, as 4G or 500M, or a share of what is "
                     "free, as 60%");
  return unit == "%" ? number / 100 * free : number * std::pow(1024.0, double(power + 1));
}

double MemoryLimit::left() const { return bytes > 0 ? std::max(bytes - takenMemory(), 0.0) : kNoLimit; }

void MemoryLimit::require(double needed, const std::string& about, const std::string& what,
                          const std::string& advice) const {
  if (!(needed > left())) return;
  throw MemoryError(about, what + " would take about " + describeBytes(needed) + " of memory, and of " +
                               describeBytes(bytes) + " that may be taken (--memory) " +
                               describeBytes(left()) + " are left: " + advice);
}

void MemoryLimit::enforce() const {
  rlimit limit{};
  if (bytes <= 0 || ::getrlimit(RLIMIT_DATA, &limit) != 0) return;
  // What was reserved before and is not used, as the stacks of threads, does not count.
  const double reserved = 1024 * numberIn("/proc/self/status", "VmData") - takenMemory();
  const double all = bytes + (std::isfinite(reserved) ? std::max(reserved, 0.0) : 0);
  if (limit.rlim_cur != RLIM_INFINITY && double(limit.rlim_cur) <= all) return;
  if (limit.rlim_max != RLIM_INFINITY && double(limit.rlim_max) <= all) return;
  if (!(all < 9e18)) return;
  limit.rlim_cur = rlim_t(all);
  ::setrlimit(RLIMIT_DATA, &limit);
}

}  // namespace slicemorph
