#include "tools/job/frame_content.h"

#include "slicemorph/errors.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

/// An object as loaded from a mesh, with colours or without.
LoadedObject solid(bool colored = false) {
  LoadedObject input;
  input.object.levelSet = openvdb::tools::createLevelSetSphere<FloatGrid>(1.f, openvdb::Vec3f(0.f), 0.2f);
  if (colored) input.colors = openvdb::Vec3SGrid::create();
  return input;
}

LoadedObject picture(bool labels) {
  LoadedObject input = solid();
  input.image = std::make_shared<Image>();
  input.labels = labels;
  return input;
}

MorphSettings jobFor(const std::string& output, const std::string& method) {
  MorphSettings settings;
  settings.inputs = {"a", "b"};
  settings.output = output;
  settings.method = method;
  return settings;
}

TEST(FrameContent, OfSolidsIsTheirSurface) {
  for (const char* output : {"m.ply", "m.vdb", "m.png"})
    for (const char* method : {"slices", "sdf", "levelset"}) {
      const FrameContent content = contentOf(jobFor(output, method), {solid(), solid()}, true);
      EXPECT_TRUE(content.surface && !content.images && content.sets.empty() && !content.shapeSet)
          << output << " " << method;
      EXPECT_TRUE(content.notes.empty());
    }
}

TEST(FrameContent, OfAMethodWithoutSurfaceIsFog) {
  const FrameContent content = contentOf(jobFor("m.vdb", "dissolve"), {solid(), solid()}, true);
  EXPECT_FALSE(content.surface);
  ASSERT_EQ(content.sets.size(), 1u);
  EXPECT_EQ(content.sets[0].name, "density");
  EXPECT_EQ(content.shapeSet, std::optional<size_t>(0));
  MorphSettings asked = jobFor("m.vdb", "dissolve");
  asked.grids = {"surface"};
  EXPECT_THROW(contentOf(asked, {solid(), solid()}, true), InputError);
}

TEST(FrameContent, HasColorsWhereTheMethodCarriesThem) {
  const std::vector<LoadedObject> inputs{solid(), solid(true)};
  EXPECT_EQ(contentOf(jobFor("m.vdb", "slices"), inputs, true).colorName, "Cd");
  MorphSettings surfaceAlone = jobFor("m.vdb", "slices");
  surfaceAlone.grids = {"surface"};
  EXPECT_EQ(contentOf(surfaceAlone, inputs, true).colorName, "");
  for (const char* method : {"sdf", "levelset", "dissolve"}) {
    const FrameContent first = contentOf(jobFor("m.vdb", method), inputs, true);
    EXPECT_EQ(first.colorName, "") << method;
    ASSERT_EQ(first.notes.size(), 1u) << method;
    EXPECT_EQ(first.notes[0].code, "colors.left-out");
    // It is said once, not with every frame of a sequence.
    EXPECT_TRUE(contentOf(jobFor("m.vdb", method), inputs, false).notes.empty()) << method;
  }
}

TEST(FrameContent, OfImagesIsTheirValuesAndSurface) {
  const std::vector<LoadedObject> inputs{picture(false), picture(false)};
  EXPECT_TRUE(contentOf(jobFor("m.nii.gz", "slices"), inputs, true).images);
  EXPECT_FALSE(contentOf(jobFor("m.ply", "slices"), inputs, true).images);
  EXPECT_FALSE(contentOf(jobFor("m.vdb", "sdf"), inputs, true).images);
  EXPECT_FALSE(contentOf(jobFor("m.vdb", "dissolve"), inputs, true).surface);
  MorphSettings named = jobFor("m.vdb", "slices");
  named.grids = {"image"};
  const FrameContent values = contentOf(named, inputs, true);
  EXPECT_TRUE(values.images && !values.surface);
  EXPECT_THROW(contentOf(named, {picture(true), picture(true)}, true), InputError);
}

TEST(FrameContent, IsWhatIsAskedForInTheFirstFrame) {
  MorphSettings asked = jobFor("m.vdb", "slices");
  asked.grids = {"surface", "heat"};
  EXPECT_THROW(contentOf(asked, {solid(), solid()}, true), InputError);
  // In a sequence grids may be missing in some frames.
  EXPECT_TRUE(contentOf(asked, {solid(), solid()}, false).surface);
}

}  // namespace
}  // namespace slicemorph
