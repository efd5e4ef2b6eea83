#include "io/atomic_file.h"

#include "slicemorph/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// Files in a folder of their own.
class AtomicFileTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directory(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string at(const std::string& name) const { return folder_ + "/" + name; }
  std::vector<std::string> there() const {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  std::string folder_;
};

TEST_F(AtomicFileTest, AppearsWholeOrNotAtAll) {
  {
    AtomicFile left(at("left")), done(at("done"));
    left.write("a"), done.write("b");
    EXPECT_FALSE(fs::exists(at("done")));
    done.commit();
  }
  EXPECT_EQ(there(), std::vector<std::string>{"done"});
}

/// Where a process ends in the middle, what it was writing goes, and nothing else.
TEST_F(AtomicFileTest, OpenOnesAreRemovedAtTheEnd) {
  std::ofstream(at("before")) << "kept";
  AtomicFile first(at("first")), done(at("done")), before(at("before")), last(at("last"));
  { AtomicFile closed(at("closed")); }
  for (AtomicFile* file : {&first, &done, &before, &last}) file->write("text");
  done.commit();
  EXPECT_EQ(there().size(), 5u);
  removeOpenFiles();
  EXPECT_EQ(there(), (std::vector<std::string>{"before", "done"}));
  EXPECT_THROW(first.commit(), IoError);
  removeOpenFiles();
  EXPECT_EQ(there(), (std::vector<std::string>{"before", "done"}));
  std::string text;
  std::ifstream(at("before")) >> text;
  EXPECT_EQ(text, "kept");
}

}  // namespace
}  // namespace slicemorph
