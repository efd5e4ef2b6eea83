#include <slicemorph/errors.h>
#include <slicemorph/io/output.h>
#include <slicemorph/io/vdb_reader.h>
#include <slicemorph/measure.h>
#include <slicemorph/slicemorph.h>

#include <openvdb/tools/LevelSetSphere.h>

#include <iostream>

/// Half way between two balls: writes its surface into half_way.vdb and prints its volume.
int main() try {
  slicemorph::initialiseVdb();
  const auto ball = [](double radius, double x) {
    const double voxelSize = radius / 25;
    return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(radius, {x, 0, 0}, voxelSize);
  };
  const slicemorph::MorphPlan plan({{"large ball", ball(1.0, 0.0)}, {"small ball", ball(0.5, 3.0)}});
  const slicemorph::InBetween halfWay = plan.frame({0.5, 0.5});
  slicemorph::writeSurface("half_way.vdb", *halfWay.surface);
  std::cout << slicemorph::measureShape(*halfWay.surface).volume << "\n";
  return 0;
} catch (const slicemorph::Error& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
