#include "io/scratch_folder.h"
#include "slicemorph/io/image_file.h"

#include <gtest/gtest.h>
#include <fstream>

namespace slicemorph {
namespace {

class Nrrd : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_.file(name), std::ios::binary) << bytes;
    return folder_.file(name);
  }
  /// 2 x 3 x 4 bytes, each with its index as value.
  std::string detached(const std::string& fields) const {
    std::string voxels;
    for (char i = 0; i < 24; ++i) voxels += i;
    write("voxels.raw", voxels);
    return write("image.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n" + fields +
                                   "data file: voxels.raw\n");
  }

  ScratchFolder folder_;
};

/// A space together with spacings, which the format forbids.
TEST_F(Nrrd, SpaceBesideSpacingsIsRead) {
  const ImageFile file = readImage(detached("spacings: 1 2 3\nspace: left-posterior-superior\n"));
  EXPECT_EQ(file.image.lattice.size, openvdb::Coord(2, 3, 4));
  EXPECT_EQ(file.image.lattice.spacing(), Vec3d(1, 2, 3));
  const auto& values = std::get<std::vector<std::uint8_t>>(file.image.values);
  ASSERT_EQ(values.size(), 24u);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], i);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_EQ(file.notes[0].code, "image.space-without-directions");
}

TEST_F(Nrrd, SpacingsAloneAreRead) {
  EXPECT_EQ(readImage(detached("spacings: 1 2 3\n")).image.lattice.spacing(), Vec3d(1, 2, 3));
}

}  // namespace
}  // namespace slicemorph
