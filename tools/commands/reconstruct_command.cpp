#include "tools/commands/reconstruct_command.h"

#include "engine/measure/label_measures.h"
#include "engine/measure/measure.h"
#include "engine/reconstruct/contour_labels.h"
#include "engine/reconstruct/contour_surface.h"
#include "engine/reconstruct/label_level_set.h"
#include "engine/reconstruct/label_slices.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/level_set.h"
#include "engine/volume/manifold.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/voxelise.h"
#include "io/contours/contour_reader.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/output.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_progress.h"
#include "tools/job/image_lattice.h"
#include "tools/job/reconstruct_slices.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

struct ReconstructSettings {
  std::string input, output, axis = "auto", like, grids;
  std::vector<std::string> reports;
  int every = 0, between = 0;
  double voxelSize = 0;
  ImageOptions image;
  int threads = 0;
  CLI::Option *threadsGiven = nullptr, *voxelSizeGiven = nullptr, *betweenGiven = nullptr,
              *everyGiven = nullptr, *gridsGiven = nullptr;
  bool quiet = false;
};

/// One label or structure as it is written.
struct Structure {
  int number = 1;
  std::string name;
  Mesh mesh;
  FloatGrid::Ptr grid;  ///< level set
};

Json describe(const Structure& s, const std::string& file) {
  const ShapeMeasures m = measureMesh(s.mesh);
  openvdb::BBoxd box;
  for (const openvdb::Vec3s& p : s.mesh.points) box.expand(Vec3d(p));
  const Vec3d e = box.extents();
  return {{"label", s.number},           {"name", s.name},    {"file", file},
          {"volumeMl", m.volume / 1000}, {"areaMm2", m.area}, {"extentsMm", {e[0], e[1], e[2]}},
          {"pieces", m.pieces},          {"genus", m.genus}};
}

Json describe(const LabelMeasures& m, const std::string& file) {
  return {{"label", m.label},  {"name", std::to_string(m.label)},
          {"file", file},      {"volumeMl", m.volume / 1000},
          {"areaMm2", m.area}, {"extentsMm", {m.extents[0], m.extents[1], m.extents[2]}},
          {"pieces", nullptr}, {"genus", nullptr}};
}

void writeReports(const ReconstructSettings& s, const std::vector<Json>& rows, const Notes& notes) {
  for (const std::string& path : s.reports) {
    if (OutputName(path).extension() == ".json") {
      const Json report = {{"input", s.input}, {"notes", sentencesOf(notes)}, {"structures", rows}};
      writeTextFile(path, report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
      continue;
    }
    std::string table =
        "label,name,file,volume_ml,area_mm2,extent_x_mm,extent_y_mm,extent_z_mm,pieces,genus\n";
    for (const Json& row : rows) {
      std::string line;
      for (const char* key :
           {"label", "name", "file", "volumeMl", "areaMm2", "extentsMm", "pieces", "genus"}) {
        const Json& value = row[key];
        if (value.is_array())
          for (const Json& v : value) line += (line.empty() ? "" : ",") + v.dump();
        else
          line +=
              (line.empty() ? "" : ",") +
              (value.is_null() ? std::string() : value.dump(-1, ' ', false, Json::error_handler_t::replace));
      }
      table += line + "\n";
    }
    writeTextFile(path, table);
  }
}

/// Surfaces as meshes, a file each, or as level sets of one VDB.
class SurfaceWriter {
 public:
  SurfaceWriter(const ReconstructSettings& s, size_t count, const std::string& list)
      : s_(s), name_(s.output) {
    if (extensionOf(s.output) == ".vdb" || count < 2 || name_.isSequence()) return;
    throw InputError(
        "-o " + s.output + " is one file for " + std::to_string(count) +
        " surfaces; put #### where their number belongs (name.####.stl), write a .vdb, or choose one: " +
        list);
  }

  void add(const Structure& structure) {
    const bool vdb = extensionOf(s_.output) == ".vdb";
    const std::string path = vdb ? s_.output : name_.path(structure.number);
    if (vdb) {
      structure.grid->setName(structure.name);
      grids_.push_back(structure.grid);
    } else {
      writeMesh(path, structure.mesh);
      if (!s_.quiet) std::printf("%s\n", path.c_str());
    }
    if (!s_.reports.empty()) rows_.push_back(describe(structure, path));
  }

  const std::vector<Json>& finish() {
    if (!grids_.empty()) {
      writeVdb(s_.output, grids_, {});
      if (!s_.quiet) std::printf("%s\n", s_.output.c_str());
    }
    return rows_;
  }

 private:
  const ReconstructSettings& s_;
  OutputName name_;
  openvdb::GridCPtrVec grids_;
  std::vector<Json> rows_;
};

int axisOf(const std::string& axis) {
  const size_t found = std::string("ijk").find(axis);
  return axis == "auto" || axis.size() != 1 ? -1 : int(found);
}

/// The stack with `between` empty slices put between every two.
Image expanded(const Image& stack, int axis, int between) {
  Image result;
  result.lattice = stack.lattice;
  const int gap = between + 1;
  result.lattice.size[axis] = (stack.lattice.size[axis] - 1) * gap + 1;
  result.lattice.step[axis] /= gap;
  std::visit(
      [&](const auto& from) {
        std::decay_t<decltype(from)> to(result.lattice.count(), 0);
        const openvdb::Coord n = stack.lattice.size;
        for (int k = 0; k < n[2]; ++k)
          for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
              openvdb::Coord at(i, j, k);
              at[axis] *= gap;
              to[result.lattice.index(at[0], at[1], at[2])] = from[stack.lattice.index(i, j, k)];
            }
        result.values = std::move(to);
      },
      stack.values);
  return result;
}

GivenSlices everySlice(int axis, int gap, int size) {
  GivenSlices given;
  given.axis = axis;
  for (int at = 0; at < size; at += gap) given.at.push_back(at);
  return given;
}

std::string described(const GivenSlices& given) {
  const int first = given.at.size() > 1 ? given.at[1] - given.at[0] : 0;
  const bool even = std::adjacent_find(given.at.begin(), given.at.end(),
                                       [&](int a, int b) { return b - a != first; }) == given.at.end();
  return std::to_string(given.at.size()) + " given slices along axis " + std::string(1, "ijk"[given.axis]) +
         (even ? ", every " + std::to_string(first) : ", unevenly") + ", from " +
         std::to_string(given.at.front()) + " to " + std::to_string(given.at.back());
}

void writeLabelSurfaces(const ReconstructSettings& s, const Image& sparse, const GivenSlices& given,
                        const Notes& notes) {
  RankedSlices ranked = rankSlices(sparse, given);
  const std::vector<double> values = ranked.values;
  const SliceScores scores(std::move(ranked.stack));
  const ImageLattice& lattice = sparse.lattice;
  StackPlace place;
  place.origin = lattice.origin;
  place.stepX = lattice.step[given.axis == 0 ? 1 : 0];
  place.stepY = lattice.step[given.axis == 2 ? 1 : 2];
  place.along = lattice.step[given.axis].unit();
  std::string list;
  for (double v : values)
    if (v != 0) list += (list.empty() ? "" : ", ") + formatNumber(v);
  SurfaceWriter writer(s, values.size() - size_t(std::count(values.begin(), values.end(), 0.0)),
                       "labels " + list);
  for (size_t rank = 0; rank < values.size(); ++rank) {
    if (values[rank] == 0) continue;
    const FloatGrid::Ptr field = labelLevelSet(scores, int(rank), place);
    Structure structure;
    structure.number = int(values[rank]);
    structure.name = "label_" + formatNumber(values[rank]);
    structure.mesh = makeManifold(surfaceOf(*field)).mesh;
    if (extensionOf(s.output) == ".vdb") {
      const Vec3d spacing = lattice.spacing();
      structure.grid = voxelise(
          structure.mesh, s.voxelSize > 0 ? s.voxelSize : std::min({spacing[0], spacing[1], spacing[2]}));
      structure.grid->setGridClass(openvdb::GRID_LEVEL_SET);
    }
    writer.add(structure);
  }
  writeReports(s, writer.finish(), notes);
}

void reconstructLabels(const ReconstructSettings& s) {
  ImageFile file = readImage(s.input, s.image);
  Image& image = file.image;
  Notes notes = file.notes;
  int axis = axisOf(s.axis);
  GivenSlices given;
  if (s.betweenGiven->count()) {
    if (axis < 0) {
      axis = int(openvdb::math::MaxIndex(image.lattice.spacing()));
    }
    if (image.lattice.size[axis] < 2)
      throw InputError(s.input + " has one slice along axis " + std::string(1, "ijk"[axis]) +
                       "; a surface needs two or more");
    labelsOf(image);
    image = expanded(image, axis, s.between);
    given = everySlice(axis, s.between + 1, image.lattice.size[axis]);
  } else {
    try {
      given = findGivenSlices(image, axis, s.every);
    } catch (const InputError& error) {
      throw InputError(s.input + ": " + error.what() +
                       "; --between N puts N slices between every two of a stack");
    }
  }
  notes.push_back(described(given));
  printNotes(s.input + ": ", notes, s.quiet);
  if (!isImageOutput(s.output)) return writeLabelSurfaces(s, image, given, notes);
  Image dense = interpolateLabels(image, given);
  if (!s.like.empty()) dense = nearestTo(dense, readImage(s.like, s.image).image.lattice);
  writeImage(s.output, dense);
  if (!s.quiet) std::printf("%s\n", s.output.c_str());
  if (s.reports.empty()) return;
  std::vector<Json> rows;
  for (const LabelMeasures& m : measureLabels(dense)) rows.push_back(describe(m, s.output));
  writeReports(s, rows, notes);
}

std::vector<ContourSet> chosenSets(const InputSpec& name, std::vector<ContourSet> sets) {
  sets.erase(
      std::remove_if(sets.begin(), sets.end(), [](const ContourSet& set) { return set.planes.empty(); }),
      sets.end());
  if (name.selection.empty()) return sets;
  std::string list;
  for (const ContourSet& set : sets) {
    if (set.name == name.selection || std::to_string(set.label) == name.selection) return {set};
    list += (list.empty() ? "" : ", ") + std::to_string(set.label) + " '" + set.name + "'";
  }
  throw InputError(name.path + " has no structure '" + name.selection + "'; there are " + list);
}

/// A dense label map of several structures: materials of a CSL file share walls, regions of a structure set
/// may lie in each other.
void writeContourLabels(const ReconstructSettings& s, const std::vector<ContourSet>& sets,
                        const std::vector<ContourSurface>& surfaces, bool materials, const Notes& notes) {
  double finest = std::numeric_limits<double>::infinity();
  std::vector<int> labels;
  for (size_t i = 0; i < sets.size(); ++i)
    finest = std::min(finest, surfaces[i].voxelSize), labels.push_back(sets[i].label);
  const ImageLattice on = s.like.empty() ? contourLattice(sets, s.voxelSize > 0 ? s.voxelSize : finest)
                                         : readImage(s.like, s.image).image.lattice;
  const Image dense =
      contourLabels(surfaces, labels, on, materials ? SharedVoxel::deepest : SharedVoxel::smallest);
  writeImage(s.output, dense);
  if (!s.quiet) std::printf("%s\n", s.output.c_str());
  if (s.reports.empty()) return;
  std::vector<Json> rows;
  for (const LabelMeasures& m : measureLabels(dense)) {
    rows.push_back(describe(m, s.output));
    for (const ContourSet& set : sets)
      if (set.label == m.label) rows.back()["name"] = set.name;
  }
  writeReports(s, rows, notes);
}

void reconstructContours(const ReconstructSettings& s, const InputSpec& name) {
  ContourFile file = readContours(name.path);
  Notes notes = file.notes;
  printNotes(name.path + ": ", notes, s.quiet);
  const std::vector<ContourSet> sets = chosenSets(name, std::move(file.sets));
  std::string list;
  for (const ContourSet& set : sets) list += (list.empty() ? "" : ", ") + name.path + ":" + set.name;
  const bool toImage = isImageOutput(s.output);
  std::optional<SurfaceWriter> writer;
  if (!toImage) writer.emplace(s, sets.size(), list);
  TerminalProgress progress(s.quiet);
  std::vector<ContourSurface> surfaces;
  for (const ContourSet& set : sets) {
    ContourSurface surface = contourSurface(set, {s.voxelSize}, &progress);
    progress.clear();
    for (const Note& note : about(set.name, surface.notes)) {
      notes.push_back(note);
      printNotes(name.path + ": ", {notes.back()}, s.quiet);
    }
    if (toImage)
      surfaces.push_back(std::move(surface));
    else
      writer->add({set.label, set.name, contourMesh(set, surface), surface.grid});
  }
  if (!toImage) return writeReports(s, writer->finish(), notes);
  writeContourLabels(s, sets, surfaces, extensionOf(name.path) == ".csl", notes);
}

/// EXR images are slices with their places, unless a spacing says that they are a stack of labels.
bool isSlices(const ReconstructSettings& s) {
  return extensionOf(s.input) == ".exr" && s.image.spacing[0] == 0;
}

void reconstructExrs(const ReconstructSettings& s) {
  const std::vector<std::pair<bool, std::string>> others = {{s.everyGiven->count() > 0, "--every"},
                                                            {s.betweenGiven->count() > 0, "--between"},
                                                            {s.axis != "auto", "--axis"},
                                                            {!s.like.empty(), "--like"},
                                                            {!s.reports.empty(), "--report"}};
  for (const auto& [given, option] : others)
    if (given)
      throw InputError(option + " is for label maps and contours; " + s.input + " are slices of grids");
  reconstructSlices({s.input, s.output, s.gridsGiven->count() ? std::optional(s.grids) : std::nullopt,
                     s.voxelSize, s.quiet});
}

void runReconstruct(const ReconstructSettings& s) {
  if (axisOf(s.axis) < -1 ||
      (s.axis != "auto" && (s.axis.size() != 1 || std::string("ijk").find(s.axis) == std::string::npos)))
    throw InputError("--axis " + s.axis + ": expected auto, i, j or k, the image's own axes");
  if (s.voxelSizeGiven->count()) checkPositive("--voxel-size", s.voxelSize);
  if (s.everyGiven->count()) checkRange("--every", s.every, 2, 10000);
  if (s.betweenGiven->count()) checkRange("--between", s.between, 1, 1000);
  if (s.everyGiven->count() && s.betweenGiven->count())
    throw InputError("--every and --between exclude each other");
  checkOutput(OutputName(s.output).path(1));
  for (const std::string& report : s.reports) {
    checkExtension(report, {".json", ".csv"});
    checkOutputPath(report);
  }
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  cancelOnInterrupt();
  if (isSlices(s)) return reconstructExrs(s);
  if (s.gridsGiven->count()) throw InputError("--grids is for EXR slices; " + s.input + " are none");
  const InputSpec input = parseInput(s.input);
  if (!input.isImage()) filesOfInput(input);  // a missing file is the better message
  if (input.contents == Contents::kContours) return reconstructContours(s, input);
  if (!input.isImage())
    throw InputError(
        s.input +
        " is neither a label map (.nii .nii.gz .nrrd .nhdr .mha .mhd, name.####.png|tif) nor contours (.csl, "
        "a DICOM RT structure set) nor EXR slices (name.####.exr, name.exr)");
  checkInputExists(s.input);
  reconstructLabels(s);
}

}  // namespace

void addReconstructCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "reconstruct", "A dense label map or closed surfaces from slices or contours, grids from EXR slices");
  const auto s = std::make_shared<ReconstructSettings>();
  command
      ->add_option(
          "INPUT", s->input,
          "Label map in which slices are empty, or a stack with --between: .nii .nii.gz .nrrd .nhdr .mha "
          ".mhd "
          "name.####.tif|png; contours: .csl, a DICOM RT structure set (file:NAME for one structure); slices "
          "of a "
          "volume as `slice` writes them: name.####.exr, or one file")
      ->required();
  command
      ->add_option("-o,--output", s->output,
                   "Result: .nii .nii.gz .nrrd .mha (a dense label map); .obj .ply .stl .glb (surfaces, #### "
                   "stands for the label); "
                   ".vdb (a level set per label; of EXR slices all their grids)")
      ->required()
      ->type_name("OUTPUT");
  command->add_option("--axis", s->axis, "Array axis that the slices follow each other along (auto)")
      ->type_name("auto|i|j|k");
  s->everyGiven =
      command->add_option("--every", s->every, "Every n-th slice is given, also where it is empty (found)")
          ->type_name("N");
  s->betweenGiven =
      command->add_option("--between", s->between, "All slices are given; put N between every two of them")
          ->type_name("N");
  s->voxelSizeGiven =
      command
          ->add_option(
              "--voxel-size", s->voxelSize,
              "Edge of a voxel of surfaces, millimetres (found), or of grids, world units (one pixel)")
          ->type_name("H");
  s->gridsGiven = command->add_option("--grids", s->grids, "Of EXR slices only these grids (all)")
                      ->type_name("NAME[,NAME...]");
  command->add_option("--like", s->like, "Put the dense label map on the voxels of this image")
      ->type_name("IMAGE");
  addSpacingOption(*command, s->image);
  command->add_option("--report", s->reports, "Volume, area and extents of every label")
      ->type_name("FILE.json|FILE.csv")
      ->allow_extra_args(false);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runReconstruct(*s); });
}

}  // namespace slicemorph
