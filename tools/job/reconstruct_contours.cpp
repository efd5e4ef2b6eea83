#include "tools/job/reconstruct_contours.h"

#include "engine/measure/label_measures.h"
#include "engine/reconstruct/contour_labels.h"
#include "engine/reconstruct/contour_surface.h"
#include "io/contours/contour_reader.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "tools/job/image_lattice.h"
#include "tools/job/option_values.h"
#include "tools/job/surface_writer.h"
#include "tools/job/write_structures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace slicemorph {
namespace {

/// "4 'Heart'"
std::string numbered(int label, const std::string& name) { return std::to_string(label) + " '" + name + "'"; }

bool selects(const InputSpec& input, int label, const std::string& name) {
  return name == input.selection || std::to_string(label) == input.selection;
}

size_t planesWithContours(const ContourSet& set) {
  return size_t(std::count_if(set.planes.begin(), set.planes.end(),
                              [](const PlaneContours& plane) { return !plane.loops.empty(); }));
}

Note leftOut(const std::string& name, const std::string& why) {
  return {"contours.left-out", Severity::kWarning, name, why + ": left out"};
}

/// The structures to be made. What makes no body is left out with a note,
/// unless it was selected. Throws InputError where nothing is left.
std::vector<ContourSet> chosenSets(const InputSpec& input, ContourFile& file) {
  if (!input.selection.empty()) {
    std::string list;
    for (ContourSet& set : file.sets)
      if (planesWithContours(set) > 0) {
        if (selects(input, set.label, set.name)) return {std::move(set)};
        list += (list.empty() ? "" : ", ") + numbered(set.label, set.name);
      }
    for (const RefusedSet& set : file.refused)
      if (selects(input, set.label, set.name)) throw IoError(input.path, set.why);
    throw InputError(input.path + " has no structure '" + input.selection + "'; there are " + list);
  }
  for (const RefusedSet& set : file.refused) file.notes.push_back(leftOut("", set.why));
  std::vector<ContourSet> sets;
  for (ContourSet& set : file.sets) {
    const size_t planes = planesWithContours(set);
    if (planes == 1) file.notes.push_back(leftOut(set.name, "has contours on one plane only, and no height"));
    if (planes > 1) sets.push_back(std::move(set));
  }
  if (!sets.empty()) return sets;
  std::string why = "no structure has contours on two planes or more";
  for (const Note& note : file.notes) why += "; " + note.sentence();
  throw InputError(input.path, why);
}

/// "file:name, file:name": the inputs that select one of the sets.
std::string listOf(const std::vector<ContourSet>& sets, const std::string& path) {
  std::string list;
  for (const ContourSet& set : sets) list += (list.empty() ? "" : ", ") + path + ":" + set.name;
  return list;
}

/// Structures and their surfaces, one each.
struct Structures {
  std::vector<ContourSet> sets;
  std::vector<ContourSurface> surfaces;
};

/// Nodes of a structure's lattice for a map, at the default size: less memory than for a surface, whose mesh is to meet
/// the contours.
constexpr double kMapNodes = 2.4e7;
/// Voxels of a map at the default size: enough for a body at .8 mm.
constexpr double kDefaultVoxels = 1e8;

/// The voxels of a map, and the codes of their space where an image has them.
struct MapVoxels {
  ImageLattice lattice;
  ImageHeader header;
};

/// The default size is that of the finest structure, but small ones do not make a map of billions of voxels of large
/// ones.
MapVoxels voxelsFor(const ReconstructJob& job, const Structures& made, JobEvents& events) {
  if (!job.like.empty()) {
    const ImageVoxels like = voxelsLike(job.like, job.image);
    MapVoxels voxels{like.lattice, {}};
    voxels.header.forms = like.forms;
    return voxels;
  }
  if (job.voxelSize > 0) return {contourLattice(made.sets, job.voxelSize), {}};
  double finest = std::numeric_limits<double>::infinity(), coarsest = 0;
  openvdb::BBoxd box;
  for (const ContourSurface& surface : made.surfaces) {
    finest = std::min(finest, surface.voxelSize), coarsest = std::max(coarsest, surface.voxelSize);
    const openvdb::CoordBBox around = surface.grid->evalActiveVoxelBoundingBox();
    box.expand(surface.grid->indexToWorld(around.min())),
        box.expand(surface.grid->indexToWorld(around.max()));
  }
  const Vec3d size = box.extents();
  const double most = std::cbrt(size[0] * size[1] * size[2] / kDefaultVoxels);
  const double voxel = std::max(finest, std::min(most, coarsest));
  if (voxel > finest)
    events.note({"contours.coarser-voxels", Severity::kNote, job.input,
                 "voxels of about " + formatNumber(voxel, 2) + ", the smallest structure alone would get " +
                     formatNumber(finest, 2) + "; --voxel-size decides"});
  return {contourLattice(made.sets, voxel), {}};
}

/// Of each structure as it is alone, whatever overlaps it.
std::vector<StructureRow> ownRows(const Structures& made, const ImageLattice& on,
                                  const std::function<std::string(int)>& file) {
  std::vector<StructureRow> rows;
  for (size_t i = 0; i < made.sets.size(); ++i) {
    const int label = made.sets[i].label;
    LabelMeasures own;
    for (const LabelMeasures& m : measureLabels(contourMask(made.surfaces[i], on, MaskOf::itsBox))) own = m;
    own.label = label;
    rows.push_back(rowOf(own, file(label)));
    rows.back().name = made.sets[i].name;
  }
  return rows;
}

/// What a map of one label a voxel does not show of structures that overlap.
Notes hiddenIn(const ContourMap& map, const std::vector<ContourSet>& sets) {
  const ImageLattice& on = map.image.lattice;
  const double voxel = std::abs(on.step[0].cross(on.step[1]).dot(on.step[2]));
  const auto millilitres = [&](size_t voxels) {
    return formatNumber(double(voxels) * voxel / 1000, 4) + " ml";
  };
  Notes notes;
  for (size_t i = 0; i < sets.size(); ++i)
    if (map.shown[i] < map.own[i])
      notes.emplace_back("contours.overlap", Severity::kWarning, sets[i].name,
                         "has " + millilitres(map.own[i]) + ", of which the label map shows " +
                             millilitres(map.shown[i]) +
                             ": others overlap it, and a voxel holds one label; -o name.####.nii.gz writes a "
                             "mask of each");
  return notes;
}

/// Structures, each by its own surface: they may overlap.
void writeContourStructures(const ReconstructJob& job, const Structures& made, const Notes& notes,
                            JobEvents& events) {
  std::vector<NamedSurface> named;
  std::vector<StructureRow> rows;
  for (size_t i = 0; i < made.sets.size(); ++i) {
    const ContourSet& set = made.sets[i];
    named.push_back({set.label, set.name, made.surfaces[i].grid});
    if (!job.reports.empty())
      rows.push_back(rowOf(set.label, set.name, contourMesh(set, made.surfaces[i]), job.output));
  }
  const bool placed = !job.like.empty() || !job.source.empty();
  events.notes(writeSurfaceStructures({job.input, job.output, job.source, job.like, job.names, job.image},
                                      named, placed ? ImageLattice() : voxelsFor(job, made, events).lattice));
  events.fileWritten(job.output, false);
  writeStructureReports(job.reports, job.input, rows, notes);
}

void writeMap(const ReconstructJob& job, const Structures& made, Notes notes, JobEvents& events) {
  const MapVoxels voxels = voxelsFor(job, made, events);
  const ImageLattice& on = voxels.lattice;
  // Materials of a CSL file share walls: the deepest wins; of regions of a
  // structure set, which may be nested, the smallest.
  const bool materials = extensionOf(parseInput(job.input).path) == ".csl";
  std::vector<int> labels;
  for (const ContourSet& set : made.sets) labels.push_back(set.label);
  const ContourMap map =
      contourMap(made.surfaces, labels, on, materials ? SharedVoxel::deepest : SharedVoxel::smallest);
  if (job.takeImage) return job.takeImage(map.image);
  writeImage(job.output, map.image, voxels.header);
  events.fileWritten(job.output, false);
  if (!materials) {
    const Notes hidden = hiddenIn(map, made.sets);
    events.notes(about(job.input, hidden));
    notes.insert(notes.end(), hidden.begin(), hidden.end());
  }
  if (job.reports.empty()) return;
  writeStructureReports(job.reports, job.input, ownRows(made, on, [&](int) { return job.output; }), notes);
}

void writeMasks(const ReconstructJob& job, const Structures& made, const Notes& notes, JobEvents& events) {
  const OutputName name(job.output);
  const MapVoxels voxels = voxelsFor(job, made, events);
  const ImageLattice& on = voxels.lattice;
  for (size_t i = 0; i < made.sets.size(); ++i) {
    events.throwIfCancelled();
    const std::string path = name.path(made.sets[i].label);
    writeImage(path, contourMask(made.surfaces[i], on, MaskOf::all), voxels.header);
    events.fileWritten(path, false);
  }
  if (job.reports.empty()) return;
  writeStructureReports(job.reports, job.input,
                        ownRows(made, on, [&](int label) { return name.path(label); }), notes);
}

}  // namespace

void reconstructContours(const ReconstructJob& job, const InputSpec& input, JobEvents& events) {
  ContourFile file = readContours(input);
  std::vector<ContourSet> sets = chosenSets(input, file);
  Notes notes = std::move(file.notes);
  events.notes(about(input.path, notes));
  const bool structures = isStructureOutput(job.output), alone = sets.size() == 1;
  const bool toImage = isImageOutput(job.output) || structures;
  std::optional<SurfaceWriter> writer;
  if (!toImage) writer.emplace(job, sets.size(), listOf(sets, input.path), events);
  ContourSurfaceOptions options;
  options.voxelSize = job.voxelSize;
  if (toImage) options.mostNodes = kMapNodes;
  Structures made;
  size_t count = 0;
  const auto note = [&](const Notes& more) {
    events.notes(about(input.path, more));
    notes.insert(notes.end(), more.begin(), more.end());
  };
  for (size_t n = 0; n < sets.size(); ++n) {
    ContourSet& set = sets[n];
    ContourSurface surface;
    try {
      PartProgress own(events, double(n) / double(sets.size()), double(n + 1) / double(sets.size()));
      surface = contourSurface(set, options, &own);
    } catch (const GeometryError& error) {
      if (alone) throw;
      note({leftOut("", error.what())});
      continue;
    }
    ++count;
    note(about(set.name, surface.notes));
    if (toImage)
      made.surfaces.push_back(std::move(surface)), made.sets.push_back(std::move(set));
    else
      writer->add({set.label, set.name, contourMesh(set, surface), surface.grid});
  }
  if (count == 0) throw GeometryError(input.path + ": none of its structures encloses anything");
  if (!toImage) return writeStructureReports(job.reports, job.input, writer->finish(), notes);
  if (structures) return writeContourStructures(job, made, notes, events);
  if (OutputName(job.output).isSequence())
    writeMasks(job, made, notes, events);
  else
    writeMap(job, made, std::move(notes), events);
}

}  // namespace slicemorph
