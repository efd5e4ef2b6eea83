#include "tools/job/methods.h"

#include "engine/measure/measure.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "tools/job/morph_settings.h"
#include "tools/job/option_values.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace slicemorph {
namespace {

constexpr double kVoxel = 0.08, kSmall = 0.8, kLarge = 1.2;

LoadedObject sphere(double radius) {
  LoadedObject input;
  input.object.levelSet =
      openvdb::tools::createLevelSetSphere<FloatGrid>(float(radius), openvdb::Vec3f(0.f), float(kVoxel));
  return input;
}

/// A job of three frames from a small sphere to a large one about the same centre.
MorphSettings jobOf(const std::string& method) {
  MorphSettings settings;
  settings.inputs = {"small", "large"};
  settings.method = method;
  settings.plan.slices = 32;
  if (methodNamed(method).can.features) {
    Feature middle;
    middle.name = "middle", middle.positions = {{Vec3d(0.0)}, {Vec3d(0.0)}};
    settings.plan.features = {middle};
  }
  for (int i = 0; i < 3; ++i) settings.frames.push_back({i + 1, i / 2.0, {1 - i / 2.0, i / 2.0}, "", 0, {}});
  return settings;
}

double radiusOf(const FloatGrid& levelSet) { return std::cbrt(measureShape(levelSet).volume * 3 / 4 / M_PI); }

TEST(Methods, HaveNamesOfTheirOwnAndHelp) {
  std::set<std::string> names;
  for (const MorphMethod& method : morphMethods()) {
    EXPECT_TRUE(names.insert(method.name).second) << method.name;
    EXPECT_FALSE(method.help.empty()) << method.name;
    EXPECT_NE(methodHelp().find(method.name), std::string::npos);
    EXPECT_EQ(&methodNamed(method.name), &method);
  }
  EXPECT_EQ(methodNames().size(), names.size());
  EXPECT_EQ(MorphSettings().method, morphMethods()[0].name);
  try {
    methodNamed("melt");
    FAIL();
  } catch (const InputError& error) {
    for (const std::string& name : names) EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
  }
}

/// Every parameter has a default within its own limits, and is spelled as it is read.
TEST(Methods, TakeTheirParametersInBraces) {
  for (const MorphMethod& method : morphMethods()) {
    SCOPED_TRACE(method.name);
    EXPECT_TRUE(methodChoice(method.name).given.empty());
    for (const MethodParameter& parameter : method.parameters) {
      SCOPED_TRACE(parameter.name);
      EXPECT_NE(describeMethod(method).find(parameter.name + ": " + parameter.help), std::string::npos);
      for (const double value : {parameter.fallback, parameter.least, parameter.most}) {
        const std::string text = method.name + "{" + parameter.name + "=" + formatExactly(value) + "}";
        const MethodChoice choice = methodChoice(text);
        EXPECT_EQ(choice.name, method.name);
        EXPECT_EQ(choice.given, (MethodValues{{parameter.name, value}})) << text;
      }
      for (const std::string wrong : {"", "x", "nan", "inf", "1e300", "-1e300"})
        EXPECT_THROW(methodChoice(method.name + "{" + parameter.name + "=" + wrong + "}"), InputError)
            << wrong;
    }
    EXPECT_THROW(methodChoice(method.name + "{no-such=1}"), InputError);
    EXPECT_THROW(methodChoice(method.name + "{}"), InputError);
  }
}

TEST(Methods, HaveDefaultsWhereNothingIsGiven) {
  MorphSettings settings = jobOf("levelset");
  const std::vector<LoadedObject> inputs;
  Progress progress;
  EXPECT_EQ((MethodTask{settings, inputs, 1, nullptr, progress}.parameter("steps")), 2000);
  settings.parameters = methodChoice("levelset{steps=7}").given;
  EXPECT_EQ((MethodTask{settings, inputs, 1, nullptr, progress}.parameter("steps")), 7);
  EXPECT_THROW((MethodTask{settings, inputs, 1, nullptr, progress}.parameter("speed")), std::logic_error);
}

/// A method's plan makes what its row says.
TEST(Methods, DoWhatTheirTraitsSay) {
  const std::vector<LoadedObject> inputs{sphere(kSmall), sphere(kLarge)};
  for (const MorphMethod& method : morphMethods()) {
    SCOPED_TRACE(method.name);
    const MorphSettings settings = jobOf(method.name);
    Progress progress;
    const MethodPlan plan = method.plan({settings, inputs, 1, nullptr, progress});
    EXPECT_EQ(bool(plan.pullback), method.can.grids || method.can.colors || method.can.images);
    EXPECT_EQ(bool(plan.slices), method.can.guided);
    for (const FrameJob& job : settings.frames) {
      const InBetween frame = plan.shape(job);
      EXPECT_EQ(bool(frame.surface), method.can.surface);
      if (!frame.surface) continue;
      // The ends are the inputs, within the half voxel at which --method levelset ends.
      const double radius = radiusOf(*frame.surface), linear = kSmall + (kLarge - kSmall) * *job.t;
      if (*job.t == 0 || *job.t == 1) {
        EXPECT_NEAR(radius, linear, kVoxel / 2) << job.number;
      }
      // Between concentric spheres every method gives a radius between theirs.
      EXPECT_GT(radius, kSmall - kVoxel / 2);
      EXPECT_LT(radius, kLarge + kVoxel / 2);
    }
  }
}

}  // namespace
}  // namespace slicemorph
