#include "tools/job/landmarks.h"

#include "slicemorph/errors.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace slicemorph {
namespace {

std::string fileOf(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "landmarks_test_" + name;
  std::ofstream(path) << text;
  return path;
}

/// The points read from one file for one input.
std::vector<Vec3d> pointsOf(const std::string& path) {
  std::vector<Vec3d> points;
  for (const Landmark& mark : readLandmarks("--landmarks", path, 1)) points.push_back(mark.at(0));
  std::filesystem::remove(path);
  return points;
}

std::string errorOf(const std::string& path) {
  try {
    pointsOf(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

const std::vector<Vec3d> kPoints{{1, 2, 3}, {-4, 5.5, 6}};

TEST(Landmarks, AreReadFromLinesOfNumbers) {
  EXPECT_EQ(pointsOf(fileOf("plain.txt", "1 2 3\n-4 5.5 6\n")), kPoints);
  EXPECT_EQ(pointsOf(fileOf("table.csv", "x,y,z\n1,2,3\n-4,5.5,6\n")), kPoints);
  EXPECT_EQ(pointsOf(fileOf("labels.txt", "# by hand\r\nnose 1 2 3\r\nchin -4 5.5 6\r\n")), kPoints);
}

TEST(Landmarks, AreReadFromElastixPoints) {
  EXPECT_EQ(pointsOf(fileOf("elastix.txt", "point\n2\n1 2 3\n-4 5.5 6\n")), kPoints);
  EXPECT_NE(errorOf(fileOf("less.txt", "point\n3\n1 2 3\n-4 5.5 6\n")).find("states 3 points and holds 2"),
            std::string::npos);
  EXPECT_NE(errorOf(fileOf("index.txt", "index\n2\n1 2 3\n-4 5 6\n")).find("voxel indices"),
            std::string::npos);
}

TEST(Landmarks, AreReadFromSlicersMarkups) {
  const std::string points = "vtk_1,1,2,3,0,0,0,1,1,1,0,F-1,,\nvtk_2,-4,5.5,6,0,0,0,1,1,1,0,F-2,,\n";
  EXPECT_EQ(pointsOf(fileOf("lps.fcsv", "# CoordinateSystem = LPS\n" + points)), kPoints);
  std::vector<Vec3d> turned = kPoints;
  for (Vec3d& p : turned) p[0] = -p[0], p[1] = -p[1];
  for (const char* ras : {"RAS", "0"})
    EXPECT_EQ(pointsOf(fileOf("ras.fcsv", std::string("# CoordinateSystem = ") + ras + "\n" + points)),
              turned);
}

TEST(Landmarks, AreReadFromText) {
  const std::vector<Landmark> marks = readLandmarks("--landmarks", "1,2,3=4,5,6;7,8,9=0,0,1", 2);
  EXPECT_EQ(marks, (std::vector<Landmark>{{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {0, 0, 1}}}));
  EXPECT_TRUE(readLandmarks("--landmarks", "", 2).empty());
  EXPECT_THROW(readLandmarks("--landmarks", "1,2,3=4,5,6", 3), InputError);
  EXPECT_THROW(readLandmarks("--landmarks", "1,2=4,5", 2), InputError);
}

TEST(Landmarks, OfBrokenLinesAreRefusedByTheirLine) {
  EXPECT_NE(errorOf(fileOf("broken.txt", "1 2 3\n4 5\n")).find("broken.txt:2: expected x y z"),
            std::string::npos);
  EXPECT_NE(errorOf(fileOf("empty.txt", "\n# nothing\n")).find("holds no points"), std::string::npos);
}

}  // namespace
}  // namespace slicemorph
