#include "tools/job/resume_log.h"

#include "tools/job/program_build.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A sequence of two frames in a folder of its own; the first frame is done.
class ResumeLogTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directory(folder_);
    for (const char* name : {"a.ply", "b.ply", "m.1.vdb"}) write(name, "something");
    settings_.inputs = {folder_ + "/a.ply", folder_ + "/b.ply"};
    settings_.output = folder_ + "/m.#.vdb";
    for (int i = 1; i <= 2; ++i)
      settings_.frames.push_back(
          {i, double(i - 1), {2.0 - i, i - 1.0}, folder_ + "/m." + std::to_string(i) + ".vdb", 0, {}});
    ResumeLog(settings_).add(settings_.frames[0], Json());
    settings_.resume = true;
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name) << text;
  }
  Json lastLine() const {
    std::ifstream file(logPath());
    std::string last;
    for (std::string line; std::getline(file, line);)
      if (!line.empty()) last = line;
    return Json::parse(last);
  }
  std::string logPath() const { return folder_ + "/.m.#.vdb.slicemorph"; }
  /// Reads the log again: empty where the first frame is kept, else why it is not.
  std::string refusal() const {
    const ResumeLog log(settings_);
    EXPECT_EQ(log.has(settings_.frames[0]), log.notes().empty());
    EXPECT_FALSE(log.has(settings_.frames[1]));
    return log.notes().empty() ? "" : log.notes()[0].code;
  }

  std::string folder_;
  MorphSettings settings_;
};

TEST_F(ResumeLogTest, KeepsFramesOfTheSameJob) { EXPECT_EQ(refusal(), ""); }

TEST_F(ResumeLogTest, KeepsNoFramesOfOtherSettings) {
  settings_.plan.slices += 1;
  EXPECT_EQ(refusal(), "resume.other-job");
}

TEST_F(ResumeLogTest, KeepsNoFramesOfOtherInputs) {
  write("b.ply", "something longer");
  EXPECT_EQ(refusal(), "resume.other-job");
}

TEST_F(ResumeLogTest, KeepsNoFramesOfAnotherProgram) {
  Json line = lastLine();
  ASSERT_EQ(line.at("program"), programBuild());
  line["program"] = "0.0.1 (0123)";
  std::ofstream(logPath()) << line << "\n";
  EXPECT_EQ(refusal(), "resume.other-program");
  line.erase("program");
  std::ofstream(logPath()) << line << "\n";
  EXPECT_EQ(refusal(), "resume.other-program");
}

/// Versions before wrote one table.
TEST_F(ResumeLogTest, SaysThatALogIsOfAnotherVersion) {
  std::ofstream(logPath()) << "{\n \"program\": \"0.9\"\n}\n";
  EXPECT_EQ(refusal(), "resume.other-program");
}

/// The line of a frame that another job wrote later is the one that counts.
TEST_F(ResumeLogTest, TheLastLineOfAFrameCounts) {
  MorphSettings other = settings_;
  other.framesPerSecond += 1;
  ResumeLog(other).add(other.frames[0], Json());
  EXPECT_EQ(refusal(), "resume.other-job");
  ResumeLog(settings_).add(settings_.frames[0], Json());
  EXPECT_EQ(refusal(), "");
}

/// A process that was killed while it wrote leaves half a line, which costs its frame alone.
TEST_F(ResumeLogTest, HalfALineCostsNoOtherFrame) {
  std::ofstream(logPath(), std::ios::app) << lastLine().dump().substr(0, 20);
  EXPECT_EQ(refusal(), "");
  write("m.2.vdb", "something else");
  ResumeLog(settings_).add(settings_.frames[1], Json());
  EXPECT_TRUE(ResumeLog(settings_).has(settings_.frames[0]));
  EXPECT_TRUE(ResumeLog(settings_).has(settings_.frames[1]));
}

/// Processes that make frames of one sequence see what the others made since they began.
TEST_F(ResumeLogTest, SeesWhatOthersMakeMeanwhile) {
  ResumeLog mine(settings_);
  EXPECT_EQ(mine.madeMeanwhile(settings_.frames[0]), ResumeLog::Maker::kNobody) << "made before";
  write("m.2.vdb", "something else");
  ResumeLog(settings_).add(settings_.frames[1], Json());
  EXPECT_EQ(mine.madeMeanwhile(settings_.frames[1]), ResumeLog::Maker::kSameJob);
  MorphSettings other = settings_;
  other.framesPerSecond += 1;
  ResumeLog(other).add(other.frames[0], Json());
  EXPECT_EQ(mine.madeMeanwhile(settings_.frames[0]), ResumeLog::Maker::kOtherJob);
}

TEST_F(ResumeLogTest, GoesAwayWhenAllFramesAreMade) {
  ResumeLog(settings_).finish();
  EXPECT_TRUE(fs::exists(logPath())) << "the second frame is not made";
  write("m.2.vdb", "something else");
  ResumeLog log(settings_);
  log.add(settings_.frames[1], Json());
  log.finish();
  EXPECT_FALSE(fs::exists(logPath()));
}

TEST_F(ResumeLogTest, TellsNothingWhereThereIsNoLog) {
  fs::remove(logPath());
  EXPECT_TRUE(ResumeLog(settings_).notes().empty());
  EXPECT_FALSE(ResumeLog(settings_).has(settings_.frames[0]));
}

/// The build id as binutils reads it.
TEST(ProgramBuild, IsTheVersionAndTheLinkersIdentifier) {
  const std::string command = "readelf -n '" + fs::read_symlink("/proc/self/exe").string() + "' 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_TRUE(pipe);
  std::string listing;
  for (int c; (c = std::fgetc(pipe)) != EOF;) listing += char(c);
  if (pclose(pipe) != 0) GTEST_SKIP() << "readelf is not there";
  const std::string mark = "Build ID: ";
  const size_t at = listing.find(mark);
  ASSERT_NE(at, std::string::npos) << "the test is linked without --build-id";
  const std::string id = listing.substr(at + mark.size(), listing.find('\n', at) - at - mark.size());
  // The engine's id follows if it is a shared library of its own.
  EXPECT_NE(programBuild().find(" (" + id), std::string::npos) << programBuild() << " without " << id;
}

}  // namespace
}  // namespace slicemorph
