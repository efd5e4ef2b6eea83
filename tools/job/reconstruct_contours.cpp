#include "tools/job/reconstruct_contours.h"

#include "engine/measure/label_measures.h"
#include "engine/reconstruct/contour_labels.h"
#include "engine/reconstruct/contour_surface.h"
#include "io/contours/contour_reader.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/surface_writer.h"
#include "tools/job/write_structures.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace slicemorph {
namespace {

std::vector<ContourSet> chosenSets(const InputSpec& input, std::vector<ContourSet> sets) {
  sets.erase(
      std::remove_if(sets.begin(), sets.end(), [](const ContourSet& set) { return set.planes.empty(); }),
      sets.end());
  if (input.selection.empty()) return sets;
  std::string list;
  for (const ContourSet& set : sets) {
    if (set.name == input.selection || std::to_string(set.label) == input.selection) return {set};
    list += (list.empty() ? "" : ", ") + std::to_string(set.label) + " '" + set.name + "'";
  }
  throw InputError(input.path + " has no structure '" + input.selection + "'; there are " + list);
}

/// A dense label map of several structures. Where structures overlap, the deepest wins among the materials of
/// a CSL file, which share walls, and the smallest among regions of a structure set, which may be nested.
Image denseLabels(const ReconstructJob& job, const std::vector<ContourSet>& sets,
                  const std::vector<ContourSurface>& surfaces, bool materials) {
  double finest = std::numeric_limits<double>::infinity();
  std::vector<int> labels;
  for (size_t i = 0; i < sets.size(); ++i)
    finest = std::min(finest, surfaces[i].voxelSize), labels.push_back(sets[i].label);
  const ImageLattice on = job.like.empty() ? contourLattice(sets, job.voxelSize > 0 ? job.voxelSize : finest)
                                           : readImage(job.like, job.image).image.lattice;
  return contourLabels(surfaces, labels, on, materials ? SharedVoxel::deepest : SharedVoxel::smallest);
}

std::vector<StructureRow> rowsOf(const Image& dense, const std::vector<ContourSet>& sets,
                                 const std::string& file) {
  std::vector<StructureRow> rows;
  for (const LabelMeasures& m : measureLabels(dense)) {
    rows.push_back(rowOf(m, file));
    for (const ContourSet& set : sets)
      if (set.label == m.label) rows.back().name = set.name;
  }
  return rows;
}

/// Structures, each by its own surface: they may overlap.
void writeContourStructures(const ReconstructJob& job, const std::vector<ContourSet>& sets,
                            const std::vector<ContourSurface>& surfaces, const Notes& notes,
                            JobEvents& events) {
  std::vector<NamedSurface> named;
  std::vector<StructureRow> rows;
  double finest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < sets.size(); ++i) {
    named.push_back({sets[i].label, sets[i].name, surfaces[i].grid});
    finest = std::min(finest, surfaces[i].voxelSize);
    if (!job.reports.empty())
      rows.push_back(rowOf(sets[i].label, sets[i].name, contourMesh(sets[i], surfaces[i]), job.output));
  }
  events.notes(writeSurfaceStructures({job.input, job.output, job.source, job.like, job.names, job.image},
                                      named,
                                      contourLattice(sets, job.voxelSize > 0 ? job.voxelSize : finest)));
  events.fileWritten(job.output, false);
  writeStructureReports(job.reports, job.input, rows, notes);
}

/// "file:name, file:name": the inputs that select one of the sets.
std::string listOf(const std::vector<ContourSet>& sets, const std::string& path) {
  std::string list;
  for (const ContourSet& set : sets) list += (list.empty() ? "" : ", ") + path + ":" + set.name;
  return list;
}

}  // namespace

void reconstructContours(const ReconstructJob& job, const InputSpec& input, JobEvents& events) {
  ContourFile file = readContours(input);
  Notes notes = file.notes;
  events.notes(about(input.path, notes));
  const std::vector<ContourSet> sets = chosenSets(input, std::move(file.sets));
  const bool structures = isStructureOutput(job.output);
  const bool toImage = isImageOutput(job.output) || structures;
  std::optional<SurfaceWriter> writer;
  if (!toImage) writer.emplace(job, sets.size(), listOf(sets, input.path), events);
  std::vector<ContourSurface> surfaces;
  for (const ContourSet& set : sets) {
    ContourSurface surface = contourSurface(set, {job.voxelSize}, &events);
    const Notes own = about(set.name, surface.notes);
    events.notes(about(input.path, own));
    notes.insert(notes.end(), own.begin(), own.end());
    if (toImage)
      surfaces.push_back(std::move(surface));
    else
      writer->add({set.label, set.name, contourMesh(set, surface), surface.grid});
  }
  if (!toImage) return writeStructureReports(job.reports, job.input, writer->finish(), notes);
  if (structures) return writeContourStructures(job, sets, surfaces, notes, events);
  const Image dense = denseLabels(job, sets, surfaces, extensionOf(input.path) == ".csl");
  writeImage(job.output, dense);
  events.fileWritten(job.output, false);
  if (!job.reports.empty())
    writeStructureReports(job.reports, job.input, rowsOf(dense, sets, job.output), notes);
}

}  // namespace slicemorph
