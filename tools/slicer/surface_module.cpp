#include "slicemorph/io/mesh_writer.h"
#include "tools/job/limit_threads.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct.h"
#include "tools/slicer/given_group.h"
#include "tools/slicer/slicer_events.h"
#include "tools/slicer/slicer_module.h"

#include <set>
#include <utility>

namespace slicemorph {
namespace {

/// Share of making surfaces in a run; the rest is writing them.
constexpr double kSurfacesMade = 0.95;

using Surfaces = std::vector<std::pair<std::string, Mesh>>;

Mesh joined(const Surfaces& surfaces) {
  Mesh all;
  for (const auto& [name, mesh] : surfaces) {
    const auto first = openvdb::Vec3I::ValueType(all.points.size());
    all.points.insert(all.points.end(), mesh.points.begin(), mesh.points.end());
    for (const openvdb::Vec3I& triangle : mesh.triangles)
      all.triangles.push_back(triangle + openvdb::Vec3I(first));
  }
  return all;
}

/// A name that files may have, which none of `taken` is; Slicer names a model as its file.
std::string fileName(std::string name, std::set<std::string>& taken) {
  for (char& c : name)
    if (c == '/' || c == '\\' || c == '#' || static_cast<unsigned char>(c) < ' ') c = '_';
  if (name.empty() || name[0] == '.') name = "_" + name;
  std::string chosen = name;
  for (int number = 2; !taken.insert(chosen).second; ++number) chosen = name + "_" + std::to_string(number);
  return chosen;
}

/// The surface of one label of a map, by its number or its name. Throws InputError where there is none.
Surfaces onlyLabel(Surfaces surfaces, const std::string& label) {
  std::string names;
  for (auto& surface : surfaces) {
    if (surface.first == label || surface.first == "label_" + label) return {std::move(surface)};
    names += (names.empty() ? "" : ", ") + surface.first;
  }
  throw InputError("--structure " + label + " is not in the label map; there are " + names);
}

ReconstructJob surfaceJob(const ModuleValues& values) {
  const bool labels = values.given("inputLabels");
  if (labels == values.given("contours"))
    throw InputError(labels
                         ? "a label map and a file of contours are given; give one of them"
                         : "nothing is given to make a surface of; give a label map or a file of contours");
  OptionSet options(kReconstruct);
  values.apply(options);
  const std::string part = labels || !values.given("structure") ? "" : ":" + values.text("structure");
  options.set(options.row("input"), {labels ? values.text("inputLabels") : values.text("contours") + part});
  options.set(options.row("output"), {"surface.####.vtp"});  // taken by takeSurface, so never written
  if (labels) options.set(options.row("image"), {"labels"});
  return reconstructJob(options);
}

void runSurfaceModule(const ModuleValues& values, JobEvents& events) {
  const std::string &output = values.text("outputModel"), &folder = values.text("folder");
  const bool each = values.given("each");
  if (output.empty() && !each)
    throw InputError(
        "no output: give a model, or ask for a file of each structure (--each) and name a folder");
  if (each && folder.empty()) throw InputError("--each needs a folder for the files (--folder)");
  if (!output.empty()) checkOutputPath(output), checkExtension(output, {".vtp", ".ply", ".stl", ".obj"});
  if (each) checkOutputPath(folder + "/surface.vtp");
  ReconstructJob job = surfaceJob(values);
  Surfaces surfaces;
  job.takeSurface = [&](const std::string& name, const Mesh& mesh) { surfaces.push_back({name, mesh}); };
  const auto limit = limitThreads(int(values.number("threads")));
  job.memory.enforce();
  PartEvents making(events, 0, kSurfacesMade);
  making.report("making surfaces", 0);
  reconstruct(job, making);
  if (values.given("inputLabels") && values.given("structure"))
    surfaces = onlyLabel(std::move(surfaces), values.text("structure"));

  events.report("writing", kSurfacesMade);
  const auto write = [&](const std::string& path, const Mesh& mesh) {
    events.throwIfCancelled();
    writeMesh(path, mesh, MeshSpace::kLps);
    events.fileWritten(path, false);
  };
  std::set<std::string> taken;
  for (const auto& [name, mesh] : surfaces)
    if (each) write(folder + "/" + fileName(name, taken) + ".vtp", mesh);
  if (!output.empty()) write(output, joined(surfaces));
}

}  // namespace

SlicerModule surfaceModule() {
  ModuleParameter contours = inputOf(ParameterKind::kFile, "contours", "File of contours",
                                     "A DICOM RT structure set (.dcm) or contours on any planes (.csl)");
  contours.extensions = {".dcm", ".csl"};
  ModuleParameter structure;
  structure.name = "structure", structure.label = "Structure";
  structure.help = "Number or name of the only label or structure wanted; empty: all";
  ModuleParameter each;
  each.kind = ParameterKind::kFlag, each.name = "each", each.label = "A file of each structure";
  each.value = "false", each.help = "Write each structure as a model of its own into the folder";
  SlicerModule module;
  module.name = "SlicemorphSurface", module.title = "Surface from contours";
  module.description =
      "Makes closed surfaces of labels that were drawn on some slices or on all, or of contours on planes in "
      "any "
      "position, such as those of a DICOM RT structure set.";
  module.groups = {
      {"Input",
       "Give one of the two.",
       false,
       {inputOf(ParameterKind::kLabelMap, "inputLabels", "Label map or segmentation",
                "Labels on some slices or on all"),
        contours, structure}},
      {"Output",
       "All structures in one model, or each in a file of its own.",
       false,
       {outputOf(ParameterKind::kModel, "outputModel", "Model", "The surfaces of all structures", ""), each,
        folderOf("folder", "Folder of the files",
                 "Each is named as its structure; of no effect without them")}},
      givenGroup({"axis", "given", "every", "voxel-size"}),
      executionGroup(kReconstruct)};
  module.run = runSurfaceModule;
  return module;
}

}  // namespace slicemorph
