#include "tools/job/compare_shapes.h"

#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"
#include "tools/job/compare_maps.h"
#include "tools/job/memory_need.h"
#include "tools/report/comparison_report.h"

namespace slicemorph {

Comparison compareShapes(const CompareJob& job, JobEvents& events) {
  Comparison result;
  FloatGrid::ConstPtr grids[2];
  Mesh meshes[2];
  std::shared_ptr<const Image> maps[2];
  for (size_t i = 0; i < 2; ++i) {
    events.throwIfCancelled();
    const HeldInput* const held = heldAt(job.held, i);
    const LoadedObject loaded = held ? loadObject(*held, job.load) : loadObject(job.inputs[i], job.load);
    events.notes(about(job.inputs[i], loaded.notes));
    result.inputs[i] = job.inputs[i];
    grids[i] = loaded.object.levelSet;
    if (loaded.labels) maps[i] = loaded.image;
  }
  const std::string both = job.inputs[0] + " and " + job.inputs[1];
  if (maps[0] && maps[1]) {
    MapComparison compared = compareMaps(*maps[0], *maps[1], job.load.memory, both);
    events.notes(about(both, compared.notes));
    result.labels = std::move(compared.labels);
  }
  require(job.load.memory, both, needOfComparison(*grids[0], *grids[1]));
  for (int i = 0; i < 2; ++i) {
    meshes[i] = surfaceOf(*grids[i]);
    result.shapes[i] = measureMesh(meshes[i]);
    result.voxelSizes[i] = grids[i]->voxelSize()[0];
  }
  events.throwIfCancelled();
  result.distance = surfaceDistance(meshes[0], meshes[1]);
  result.overlap = overlap(*grids[0], *grids[1]);
  return result;
}

nlohmann::ordered_json jsonOf(const Comparison& c) {
  const auto distance = [&](double unit) {
    return nlohmann::ordered_json{{"mean", c.distance.mean / unit},
                                  {"p95", c.distance.p95 / unit},
                                  {"p99", c.distance.p99 / unit},
                                  {"max", c.distance.max / unit}};
  };
  nlohmann::ordered_json json;
  for (int i = 0; i < 2; ++i) {
    const ShapeMeasures& shape = c.shapes[i];
    json[i ? "b" : "a"] = {{"file", c.inputs[i]}, {"voxelSize", c.voxelSizes[i]}, {"volume", shape.volume},
                           {"area", shape.area},  {"pieces", shape.pieces},       {"genus", shape.genus}};
  }
  json["distance"] = distance(1);
  json["distanceVoxels"] = distance(c.voxelSizes[0]);
  json["dice"] = c.overlap.dice;
  json["intersection"] = c.overlap.intersection;
  json["symmetricDifference"] = c.overlap.symmetricDifference;
  if (!c.labels.empty()) json["labels"] = labelsJson(c.labels);
  return json;
}

}  // namespace slicemorph
