#include "io/file_claim.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// A file to be claimed in a folder of its own.
class FileClaimTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directory(folder_);
    path_ = folder_ + "/m.0001.vdb";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string claimText() const {
    std::ifstream file(claimFileOf(path_));
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  void writeClaim(const std::string& text) const { std::ofstream(claimFileOf(path_)) << text; }
  /// Leaves the claim of a process that has ended, and what it had half written.
  pid_t leaveDeadClaim() const {
    const pid_t child = fork();
    if (child == 0) {
      const auto* claim = new FileClaim(path_, "job");  // never freed
      std::ofstream(folder_ + "/.m.0001.vdb.tmp-" + std::to_string(getpid())) << "half";
      _exit(claim->held() ? 0 : 1);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    return child;
  }

  std::string folder_, path_;
};

TEST_F(FileClaimTest, IsHeldByOneAndFreedAtItsEnd) {
  {
    const FileClaim first(path_, "job");
    ASSERT_TRUE(first.held());
    const FileClaim second(path_, "other");
    EXPECT_FALSE(second.held());
    EXPECT_EQ(second.other().process, getpid());
    EXPECT_EQ(second.other().purpose, "job");
    EXPECT_TRUE(second.other().isKnownAlive);
  }
  EXPECT_FALSE(fs::exists(claimFileOf(path_))) << "the second, which did not hold it, is no owner";
  EXPECT_FALSE(claimOn(path_));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(FileClaimTest, OfADeadProcessIsTakenOverWithWhatItLeft) {
  const pid_t dead = leaveDeadClaim();
  ASSERT_TRUE(fs::exists(claimFileOf(path_)));
  EXPECT_FALSE(claimOn(path_));
  const FileClaim claim(path_, "job");
  EXPECT_TRUE(claim.held());
  EXPECT_EQ(claimOn(path_)->process, getpid());
  EXPECT_FALSE(fs::exists(folder_ + "/.m.0001.vdb.tmp-" + std::to_string(dead)));
}

/// A number that a later process has got is not the owner's.
TEST_F(FileClaimTest, OfAnEarlierProcessOfTheSameNumberIsTakenOver) {
  std::string text;
  {
    const FileClaim claim(path_, "job");
    text = claimText();
  }
  const size_t at = text.find("started ") + 8;
  text.replace(at, text.find('\n', at) - at, "1");
  writeClaim(text);
  EXPECT_TRUE(FileClaim(path_, "job").held());
}

TEST_F(FileClaimTest, OfAnotherMachineIsRespected) {
  std::string text;
  {
    const FileClaim claim(path_, "job");
    text = claimText();
  }
  const size_t at = text.find("host ") + 5;
  text.replace(at, text.find('\n', at) - at, "farm3");
  writeClaim(text);
  const FileClaim claim(path_, "job");
  EXPECT_FALSE(claim.held());
  EXPECT_EQ(claim.other().host, "farm3");
  EXPECT_FALSE(claim.other().isKnownAlive);
  EXPECT_EQ(claimText(), text);
}

TEST_F(FileClaimTest, ThatWasCutIsTakenOver) {
  writeClaim("host fa");
  EXPECT_TRUE(FileClaim(path_, "job").held());
}

/// Of many processes that find a dead one's claim at the same time one takes it.
TEST_F(FileClaimTest, IsTakenOverByOneOfMany) {
  for (int round = 0; round < 5; ++round) {
    leaveDeadClaim();
    int start[2], done[2];
    ASSERT_EQ(pipe(start), 0);
    ASSERT_EQ(pipe(done), 0);
    std::vector<pid_t> children;
    for (int i = 0; i < 8; ++i) {
      children.push_back(fork());
      if (children.back() != 0) continue;
      char byte;
      close(start[1]), close(done[1]);
      if (read(start[0], &byte, 1) < 0) _exit(2);
      const auto* claim = new FileClaim(path_, "job");
      const bool held = claim->held();
      // All stay alive until all have tried.
      if (read(done[0], &byte, 1) < 0) _exit(2);
      delete claim;
      _exit(held ? 1 : 0);
    }
    close(start[1]);
    usleep(300000);
    close(done[1]);
    int held = 0;
    for (const pid_t child : children) {
      int status = 0;
      waitpid(child, &status, 0);
      held += WEXITSTATUS(status);
    }
    close(start[0]), close(done[0]);
    EXPECT_EQ(held, 1);
    EXPECT_FALSE(fs::exists(claimFileOf(path_)));
  }
}

}  // namespace
}  // namespace slicemorph
