#include "io/scratch_folder.h"
#include "io/usd/usda_mesh.h"
#include "io/usd/usda_volume.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_reader.h"
#include "slicemorph/io/vdb_writer.h"

#include <gtest/gtest.h>

#include <fstream>

namespace slicemorph {
namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Mesh tetrahedron(const Vec3d& origin) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  mesh.origin = origin;
  return mesh;
}

openvdb::FloatGrid::Ptr fogGrid(const std::string& name, const openvdb::Coord& voxel) {
  const auto grid = openvdb::FloatGrid::create(0);
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(2));
  grid->tree().setValue(voxel, 1);
  return grid;
}

TEST(UsdaText, NamesArePrimNames) {
  EXPECT_EQ(usdaName("density"), "density");
  EXPECT_EQ(usdaName("vel.x"), "vel_x");
  EXPECT_EQ(usdaName("3d"), "_3d");
  EXPECT_EQ(usdaName(""), "_");
  EXPECT_EQ(usdaName("\xc3\xa9"), "__");
  EXPECT_EQ(usdaNameOfFile("a.b/shot 1.usda"), "shot_1");
}

TEST(UsdaText, QuotesWhatNeedsIt) {
  EXPECT_EQ(usdaString("a"), "\"a\"");
  EXPECT_EQ(usdaString("a\"b"), "'a\"b'");
  EXPECT_EQ(usdaString("a\"b'"), "\"a\\\"b'\"");
  EXPECT_EQ(usdaString("a\\b\n"), "\"a\\\\b\\n\"");
  EXPECT_EQ(usdaAsset("x.vdb"), "@./x.vdb@");
  EXPECT_EQ(usdaAsset("x@y.vdb"), "@@@./x@y.vdb@@@");
  EXPECT_EQ(usdaAsset("x@@@y.vdb"), "@@@./x\\@@@y.vdb@@@");
}

TEST(UsdaText, NumbersAreReadBackTheSame) {
  for (const float value : {0.1f, 1.f / 3, 1e-30f, -16777216.f, 3.4e38f}) {
    std::string text;
    addNumber(text, value);
    EXPECT_EQ(std::stof(text), value) << text;
  }
}

TEST(UsdaMesh, FramesShareOneTranslation) {
  const ScratchFolder folder;
  const std::string path = folder.file("x.usda");
  UsdaMeshWriter writer(path, {});
  writer.add(1, {}, {});  // nothing is there yet
  writer.add(2, tetrahedron({1000, 0, 0}), {});
  writer.add(3, tetrahedron({1002, 0, 0}), std::vector<openvdb::Vec3s>(4, {1, 2, 3}));
  writer.commit();
  const std::string text = readWholeFile(path);
  EXPECT_TRUE(holds(text, "xformOp:translate = (1000, 0, 0)")) << text;
  EXPECT_TRUE(holds(text, "1: [],")) << text;
  EXPECT_TRUE(holds(text, "2: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],")) << text;
  EXPECT_TRUE(holds(text, "3: [(2, 0, 0), (3, 0, 0), (2, 1, 0), (2, 0, 1)],")) << text;
  EXPECT_TRUE(holds(text, "2: None,\n            3: [(1, 2, 3), (1, 2, 3), (1, 2, 3), (1, 2, 3)],")) << text;
  EXPECT_FALSE(holds(text, "displayColor")) << text;
}

TEST(UsdaMesh, AStillHasNoTimes) {
  const ScratchFolder folder;
  const std::string path = folder.file("x.usda");
  Mesh mesh = tetrahedron(Vec3d(0.0));
  mesh.colors.assign(4, {1, 0.5f, 0});
  writeUsdaMesh(path, mesh, {24, 0.01, true});
  const std::string text = readWholeFile(path);
  EXPECT_FALSE(holds(text, "timeSamples") || holds(text, "TimeCode") || holds(text, "xform")) << text;
  EXPECT_TRUE(holds(text, "metersPerUnit = 0.01\n    upAxis = \"Z\"")) << text;
  EXPECT_TRUE(
      holds(text, "primvars:displayColor = [(1, 0.5, 0), (1, 0.5, 0), (1, 0.5, 0), (1, 0.5, 0)] (\n"));
}

TEST(UsdaVolume, GridsAreToldApartAndFoundAgain) {
  initialiseVdb();
  const ScratchFolder folder;
  const std::string a = folder.file("x.1.vdb"), b = folder.file("x.2.vdb"), path = folder.file("x.usda");
  writeVdb(a, {fogGrid("heat 1", {0, 0, 0}), fogGrid("heat.1", {0, 0, 0}), fogGrid("heat.1", {4, 0, 0})}, {});
  writeVdb(b, {fogGrid("heat.1", {1, 1, 1})}, {});
  writeUsdaVolume(path, {{1, a}, {2, b}, {3, folder.file("x.3.vdb")}}, {});
  const std::string text = readWholeFile(path);
  // The file of frame 3 is to come: nobody knows what it will lack.
  EXPECT_TRUE(
      holds(text,
            "def OpenVDBAsset \"heat_1\"\n        {\n            token fieldClass = \"fogVolume\"\n"
            "            token fieldDataType = \"float\"\n            int fieldIndex = 0\n"
            "            token fieldName = \"heat 1\"\n            asset filePath.timeSamples = {\n"
            "                1: @./x.1.vdb@,\n                2: None,\n                3: @./x.3.vdb@,"))
      << text;
  EXPECT_TRUE(holds(text, "rel field:heat_1_3 = </x/volume/heat_1_3>")) << text;
  EXPECT_TRUE(holds(text, "int fieldIndex = 1\n            token fieldName = \"heat.1\"")) << text;
  // Voxels of 2 around their centres: from -1 to 9, and from 1 to 3.
  EXPECT_TRUE(holds(text, "1: [(-1, -1, -1), (9, 1, 1)],\n            2: [(1, 1, 1), (3, 3, 3)],\n        }"))
      << text;
}

TEST(UsdaVolume, ADamagedFileIsNamed) {
  initialiseVdb();
  const ScratchFolder folder;
  const std::string a = folder.file("x.1.vdb");
  std::ofstream(a) << "no VDB";
  try {
    writeUsdaVolume(folder.file("x.usda"), {{1, a}}, {});
    FAIL();
  } catch (const IoError& error) {
    EXPECT_TRUE(holds(error.what(), "x.1.vdb")) << error.what();
  }
}

}  // namespace
}  // namespace slicemorph
