#include "tools/job/reconstruct_slices.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/voxelise.h"
#include "io/exr/exr_slice_reader.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_progress.h"
#include "tools/job/image_lattice.h"

#include <algorithm>
#include <cstdio>

namespace slicemorph {
namespace {

/// A pixel, or less where a level set needs that.
double voxelSizeFor(const ExrSlices& slices, const SlicedGrid& sliced, const SlicesJob& job) {
  if (job.voxelSize > 0) return job.voxelSize;
  double pixel = slices.planes[0].pixelSize;
  for (const SectionPlane& plane : slices.planes) pixel = std::min(pixel, plane.pixelSize);
  const double most = mostVoxelSize(*sliced.like);
  if (pixel <= most * 1.001) return pixel;
  printNotes(job.input + ": ",
             {"'" + sliced.like->getName() + "' gets voxels of " + formatNumber(most) +
              ", finer than the pixels of " + formatNumber(pixel) + ": its distances reach no farther"},
             job.quiet);
  return most;
}

std::string namesOf(const ExrSlices& slices) {
  std::string names;
  for (const SlicedGrid& sliced : slices.grids) names += (names.empty() ? "" : ", ") + sliced.like->getName();
  return names;
}

/// Meshes and images hold one grid.
void checkOne(const ExrSlices& slices, const SlicesJob& job) {
  if (slices.grids.size() > 1)
    throw InputError("-o " + job.output + " holds one grid, " + job.input + " has " + namesOf(slices) +
                     "; choose one with --grids, or write a .vdb");
}

void writeGrids(const openvdb::GridCPtrVec& grids, const SlicesJob& job) {
  if (extensionOf(job.output) == ".vdb") return writeVdb(job.output, grids, {});
  if (isImageOutput(job.output)) return writeImage(job.output, imageOf(*grids[0]));
  const auto scalars = openvdb::GridBase::grid<FloatGrid>(grids[0]);
  if (!scalars || scalars->getGridClass() != openvdb::GRID_LEVEL_SET)
    throw InputError("-o " + job.output + ": '" + grids[0]->getName() +
                     "' is no level set and has no surface; write a .vdb");
  writeMesh(job.output, surfaceOf(*scalars));
}

}  // namespace

void reconstructSlices(const SlicesJob& job) {
  TerminalProgress progress(job.quiet);
  progress.report("reading", 0);
  const ExrSlices slices = readSliceExrs(
      parseInput(job.input), job.grids ? parseNames("--grids", *job.grids) : std::vector<std::string>());
  progress.clear();
  printNotes(job.input + ": ", slices.notes, job.quiet);
  if (extensionOf(job.output) != ".vdb") checkOne(slices, job);
  openvdb::GridCPtrVec grids;
  for (size_t g = 0; g < slices.grids.size(); ++g) {
    if (progress.cancelled()) throw Cancelled();
    progress.report("reconstructing", double(g + 1) / double(slices.grids.size() + 1));
    try {
      grids.push_back(
          gridOfSections(slices.planes, slices.grids[g], voxelSizeFor(slices, slices.grids[g], job)));
    } catch (const InputError& error) {
      throw InputError(job.input + ": " + error.what());
    }
  }
  writeGrids(grids, job);
  progress.clear();
  if (!job.quiet) std::printf("%s\n", job.output.c_str());
}

}  // namespace slicemorph
