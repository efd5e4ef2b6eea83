#include "slicemorph/errors.h"
#include "slicemorph/io/image_file.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// A folder that is set as the system's for temporary files, with names that contain the process id, as an
/// attacker could predict them.
class Nrrd : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("slicemorph_nrrd_" + std::to_string(getpid()));
    fs::create_directories(folder_ / "tmp");
    fs::create_directories(folder_ / "data");
    ::setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("TMPDIR");
    fs::permissions(folder_ / "tmp", fs::perms::owner_all);
    fs::remove_all(folder_);
  }

  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / "data" / name, std::ios::binary) << bytes;
    return (folder_ / "data" / name).string();
  }
  /// 2 x 3 x 4 bytes, each with its index as value.
  std::string detached(const std::string& fields) const {
    std::string voxels;
    for (char i = 0; i < 24; ++i) voxels += i;
    write("voxels.raw", voxels);
    return write("image.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n" + fields +
                                   "data file: voxels.raw\n");
  }

  fs::path folder_;
};

/// A space together with spacings, which the format forbids, is read through a header of our own.
TEST_F(Nrrd, SpaceBesideSpacingsIsRead) {
  const ImageFile file = readImage(detached("spacings: 1 2 3\nspace: left-posterior-superior\n"));
  EXPECT_EQ(file.image.lattice.size, openvdb::Coord(2, 3, 4));
  EXPECT_EQ(file.image.lattice.spacing(), Vec3d(1, 2, 3));
  const auto& values = std::get<std::vector<std::uint8_t>>(file.image.values);
  ASSERT_EQ(values.size(), 24u);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], i);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_EQ(file.notes[0].code, "image.space-without-directions");
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

/// A link at the path where a temporary file might be expected is not followed, and its target
/// is not changed.
TEST_F(Nrrd, LinksAmongTemporaryFilesAreNotFollowed) {
  const std::string victim = write("victim", "precious");
  const std::string name = "slicemorph-" + std::to_string(getpid());
  for (const char* end : {"", ".nhdr", ".tmp"}) fs::create_symlink(victim, folder_ / "tmp" / (name + end));
  readImage(detached("spacings: 1 2 3\nspace: left-posterior-superior\n"));
  std::ifstream file(victim);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "precious");
  for (const char* end : {"", ".nhdr", ".tmp"})
    EXPECT_TRUE(fs::is_symlink(folder_ / "tmp" / (name + end))) << end;
}

/// Correct headers need no temporary file.
TEST_F(Nrrd, OrdinaryHeadersWriteNothing) {
  ::setenv("TMPDIR", (folder_ / "missing").c_str(), 1);
  EXPECT_EQ(readImage(detached("spacings: 1 2 3\n")).image.lattice.spacing(), Vec3d(1, 2, 3));
}

}  // namespace
}  // namespace slicemorph
