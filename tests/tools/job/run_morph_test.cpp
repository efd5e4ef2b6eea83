#include "tools/job/run_morph.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_writer.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// Records a job's events, and cancels it after some files.
struct Recorder : JobEvents {
  void report(const char*, double fraction) override {
    EXPECT_GE(fraction, most) << "progress goes back";
    most = std::max(most, fraction);
  }
  bool cancelled() const override { return files.size() >= endAfter; }
  void note(const Note& note) override { seen.push_back(note); }
  void fileWritten(const std::string& path, bool kept) override {
    EXPECT_TRUE(fs::exists(path)) << path;
    files.push_back(fs::path(path).filename().string() + (kept ? " (kept)" : ""));
  }

  size_t endAfter = 1000;
  double most = 0;
  Notes seen;
  std::vector<std::string> files;
};

using Names = std::vector<std::string>;

/// Two spheres in a folder of their own, and a job of three frames between them as a host would set it up.
class RunMorphTest : public testing::Test {
 protected:
  void SetUp() override {
    openvdb::initialize();
    folder_ = testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directory(folder_);
    for (const char* name : {"/a.vdb", "/b.vdb"}) {
      const float radius = settings_.inputs.empty() ? 1.f : 0.8f;
      const auto sphere = openvdb::tools::createLevelSetSphere<FloatGrid>(radius, openvdb::Vec3f(0.f), 0.1f);
      sphere->setName("surface");
      writeVdb(folder_ + name, {sphere}, {});
      settings_.inputs.push_back(folder_ + name);
    }
    settings_.output = folder_ + "/m.#.vdb";
    settings_.method = "sdf";
    for (int i = 0; i < 3; ++i)
      settings_.frames.push_back(
          {i + 1, i / 2.0, {1 - i / 2.0, i / 2.0}, OutputName(settings_.output).path(i + 1), 0, {0, 0}});
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string folder_;
  MorphSettings settings_;
};

TEST_F(RunMorphTest, TellsItsCallerAndPrintsNothing) {
  settings_.reports = {folder_ + "/r.json"};
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Recorder events;
  runMorph(settings_, events);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(events.files, (Names{"m.1.vdb", "m.2.vdb", "m.3.vdb"}));
  EXPECT_TRUE(fs::exists(settings_.reports[0]));
  EXPECT_GT(events.most, 0);
  EXPECT_LE(events.most, 1);
}

TEST_F(RunMorphTest, EndsWhenItsCallerSaysSoAndGoesOnLater) {
  Recorder first;
  first.endAfter = 1;
  EXPECT_THROW(runMorph(settings_, first), Cancelled);
  EXPECT_EQ(first.files, (Names{"m.1.vdb"}));
  settings_.resume = true;
  Recorder second;
  runMorph(settings_, second);
  EXPECT_EQ(second.files, (Names{"m.1.vdb (kept)", "m.2.vdb", "m.3.vdb"}));
}

TEST_F(RunMorphTest, SaysWhyFramesAreNotKept) {
  Recorder first;
  first.endAfter = 1;
  EXPECT_THROW(runMorph(settings_, first), Cancelled);
  settings_.resume = true;
  settings_.framesPerSecond += 1;
  Recorder second;
  runMorph(settings_, second);
  EXPECT_EQ(second.files, (Names{"m.1.vdb", "m.2.vdb", "m.3.vdb"}));
  EXPECT_EQ(std::count_if(second.seen.begin(), second.seen.end(),
                          [](const Note& note) { return note.code == "resume.other-job"; }),
            1);
}

TEST_F(RunMorphTest, RefusesAnUnknownMethod) {
  settings_.method = "melt";
  Recorder events;
  EXPECT_THROW(runMorph(settings_, events), InputError);
  EXPECT_TRUE(events.files.empty());
}

}  // namespace
}  // namespace slicemorph
