#include "slicemorph/io/memory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// A machine's files in a folder of their own.
class Memory : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("slicemorph_memory_" + std::to_string(getpid()));
    write("proc/meminfo", "MemTotal: 16000 kB\nMemFree: 100 kB\nMemAvailable: 8000 kB\n");
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
  }
  double free() const { return freeMemory(root_.string()); }

  fs::path root_;
};

constexpr double kKilo = 1024;

TEST_F(Memory, IsWhatTheMachineHas) { EXPECT_EQ(free(), 8000 * kKilo); }

TEST_F(Memory, IsLimitedByGroupsOfVersionTwo) {
  write("proc/self/cgroup", "0::/jobs/one\n");
  write("sys/fs/cgroup/jobs/one/memory.max", "max\n");
  write("sys/fs/cgroup/jobs/one/memory.current", "1024000\n");
  EXPECT_EQ(free(), 8000 * kKilo);
  // The limit of a group around it counts, and what it caches is given back when it is needed.
  write("sys/fs/cgroup/jobs/memory.max", "4096000\n");
  write("sys/fs/cgroup/jobs/memory.current", "2048000\n");
  EXPECT_EQ(free(), 2048000);
  write("sys/fs/cgroup/jobs/memory.stat", "anon 5\ninactive_file 1024000\n");
  EXPECT_EQ(free(), 3072000);
}

TEST_F(Memory, IsLimitedByGroupsOfVersionOne) {
  write("proc/self/cgroup", "9:cpu:/\n4:memory:/box\n");
  write("sys/fs/cgroup/memory/box/memory.limit_in_bytes", "2048000\n");
  write("sys/fs/cgroup/memory/box/memory.usage_in_bytes", "4096000\n");
  EXPECT_EQ(free(), 0);
}

TEST(MemorySizes, AreRead) {
  EXPECT_EQ(parseBytes("--memory", "4G", 0), 4 * kKilo * kKilo * kKilo);
  EXPECT_EQ(parseBytes("--memory", "500M", 0), 500 * kKilo * kKilo);
  EXPECT_EQ(parseBytes("--memory", "1.5 GiB", 0), 1.5 * kKilo * kKilo * kKilo);
  EXPECT_EQ(parseBytes("--memory", "2gb", 0), 2 * kKilo * kKilo * kKilo);
  EXPECT_EQ(parseBytes("--memory", "50%", 1000), 500);
  for (const char* wrong : {"", "4", "G", "-1G", "0M", "4Q", "4GG", "nanG", "1e999T"})
    EXPECT_THROW(parseBytes("--memory", wrong, 1000), InputError) << wrong;
  EXPECT_EQ(describeBytes(1536 * kKilo * kKilo), "1.5 GB");
  EXPECT_EQ(describeBytes(300 * kKilo * kKilo), "300 MB");
}

TEST(MemoryLimits, AreRefusedWithTheNumbers) {
  const MemoryLimit none;
  EXPECT_TRUE(std::isinf(none.left()));
  EXPECT_NO_THROW(none.require(1e30, "a", "b", "c"));
  const MemoryLimit limit{takenMemory() + 100 * kKilo * kKilo};
  EXPECT_NO_THROW(limit.require(10 * kKilo * kKilo, "x.obj", "a grid", "use less"));
  try {
    limit.require(3 * kKilo * kKilo * kKilo, "x.obj", "a grid", "use less");
    ADD_FAILURE() << "three gigabytes of a tenth of one";
  } catch (const MemoryError& error) {
    const std::string said = error.what();
    for (const char* part : {"x.obj", "a grid", "3 GB", "--memory", "use less"})
      EXPECT_NE(said.find(part), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace slicemorph
