#include "tools/job/frame_writer.h"

#include "engine/volume/same_image.h"
#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "io/mesh/glb_writer.h"
#include "io/sequence.h"
#include "io/usd/usda_volume.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/mesh_writer.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/job/carry_grids.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {
namespace {

Mesh coloredSurfaceOf(const MorphFrame& frame) {
  Mesh mesh = surfaceOf(*frame.shape.surface);
  if (frame.colors) mesh.colors = colorsAt(*frame.colors, mesh.points);
  return mesh;
}

void writeStill(const FrameTask& task, const MorphFrame& frame) {
  Mesh mesh = coloredSurfaceOf(frame);
  MovingMesh still{0, std::move(mesh.triangles), {std::move(mesh.points)}, {}};
  if (!mesh.colors.empty()) still.colors = {std::move(mesh.colors)};
  writeGlb(task.job.path, {std::move(still)}, task.settings.framesPerSecond, task.settings.glb);
}

/// The morph's velocities at a mesh's points, world units per second; empty where there are none.
std::vector<openvdb::Vec3s> velocitiesAt(const FrameTask& task, const MorphFrame& frame, const Mesh& mesh) {
  const openvdb::Vec3SGrid::ConstPtr grid = velocityAround(task, *frame.shape.surface);
  if (!grid) return {};
  std::vector<openvdb::Vec3s> velocities(mesh.points.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, velocities.size()), [&](const auto& range) {
    const openvdb::Vec3SGrid::ConstAccessor values = grid->getConstAccessor();
    for (size_t i = range.begin(); i < range.end(); ++i)
      velocities[i] = openvdb::tools::BoxSampler::sample(
          values, grid->transform().worldToIndex(Vec3d(mesh.points[i]) + mesh.origin));
  });
  return velocities;
}

void writeGrids(const FrameTask& task, const MorphFrame& frame) {
  VdbOutput options = fileOptionsOf(task.inputs);
  options.framesPerSecond = task.settings.framesPerSecond;
  options.frame = task.job.number;
  writeGridFile(task.job.path, frame.grids, options);
}

/// The frames of each mesh: "1-4, 5". `numbers`: of all frames.
std::string runsOf(const std::vector<MovingMesh>& meshes, const std::vector<int>& numbers) {
  std::string runs;
  for (const MovingMesh& m : meshes) {
    const auto first = numbers.begin() + std::ptrdiff_t(m.first);
    runs += (runs.empty() ? "" : ", ") + listOfNumbers({first, first + std::ptrdiff_t(m.points.size())});
  }
  return runs;
}

/// `part`: the frames are not the whole sequence.
Note noteOn(const std::string& output, const std::vector<MovingMesh>& meshes, const std::vector<int>& numbers,
            bool part) {
  const std::string which = part ? ": frames " + listOfNumbers(numbers) : "";
  if (meshes.size() == 1)
    return {
        "glb.one-mesh", Severity::kNote, output,
        (meshes[0].points.size() > 1 ? "one mesh with a morph target for each frame" : "one mesh") + which};
  return {"glb.several-meshes", Severity::kNote, output,
          std::to_string(meshes.size()) +
              " meshes, each shown in its own frames, as none fits the surfaces of all: frames " +
              runsOf(meshes, numbers)};
}

}  // namespace

void FrameWriter::prepare(const FrameMaker& maker, double done) {
  if (!settings_.toFrameImages()) return;
  PartProgress looking(events_, done, done);
  images_ = setUpImages(settings_, maker, looking);
  events_.notes(images_->notes);
}

void FrameWriter::write(const FrameTask& task, const MorphFrame& frame) {
  if (images_) {
    events_.notes(writeFrameImage(task, *images_, frame, events_));
  } else if (frame.image && settings_.oneImage()) {
    addVolume(task, *frame.image);
  } else if (frame.image) {
    writeImage(task.job.path, *frame.image, task.plan.images.header);
  } else if (settings_.oneGlb()) {
    surfaces_.push_back({frame.shape.surface, task.job.weights, frame.colors});
    numbers_.push_back(task.job.number);
  } else if (settings_.oneUsda()) {
    addToUsda(task, frame);
  } else if (OutputName(task.job.path).extension() == ".glb") {
    writeStill(task, frame);
  } else if (OutputName(task.job.path).extension() == ".usda") {
    writeUsdaMesh(task.job.path, meshForFile(*frame.shape.surface, frame.colors.get()), settings_.stage);
  } else if (frame.grids.empty()) {
    const bool scans = std::all_of(task.inputs.begin(), task.inputs.end(),
                                   [](const LoadedObject& object) { return object.image != nullptr; });
    writeMesh(task.job.path, meshForFile(*frame.shape.surface, frame.colors.get()),
              scans ? MeshSpace::kLps : MeshSpace::kUnsaid);
  } else {
    writeGrids(task, frame);
  }
}

void FrameWriter::addVolume(const FrameTask& task, const Image& image) {
  if (!volumes_) {
    const int volumes = int(settings_.wantedFrames().size());
    ImageHeader header = task.plan.images.header;
    header.timeStep = 1 / settings_.framesPerSecond, header.inSeconds = true;
    volumes_ =
        std::make_unique<ImageSliceWriter>(settings_.output, image.lattice, image.values, volumes, header);
    lattice_ = image.lattice;
  }
  if (!sameLattice(image.lattice, *lattice_))
    throw InputError(settings_.output,
                     "its frames do not have the same voxels, so that one file cannot hold them; put "
                     "#### into the name, or give --like IMAGE");
  volumes_->add(image.values);
}

void FrameWriter::addToUsda(const FrameTask& task, const MorphFrame& frame) {
  if (!usda_) usda_ = std::make_unique<UsdaMeshWriter>(settings_.output, settings_.stage);
  const Mesh mesh = meshForFile(*frame.shape.surface, frame.colors.get());
  usda_->add(task.job.number, mesh, velocitiesAt(task, frame, mesh));
}

/// Writes the mesh of all frames, or the stage that shows the VDB files of the whole sequence, whoever made them.
void FrameWriter::finishUsda() {
  if (usda_) {
    usda_->commit();
    usda_.reset();
    events_.fileWritten(settings_.output, false);
  }
  if (settings_.usdVolume.empty()) return;
  std::vector<UsdaFrame> frames;
  for (const FrameJob& job : settings_.frames) frames.push_back({job.number, job.path});
  writeUsdaVolume(settings_.usdVolume, frames, settings_.stage);
  events_.fileWritten(settings_.usdVolume, false);
}

void FrameWriter::finish(const MorphPlan* plan, Progress& following) {
  finishUsda();
  if (volumes_) {
    volumes_->commit();
    volumes_.reset();
    events_.fileWritten(settings_.output, false);
  }
  if (!settings_.oneGlb()) return;
  const std::vector<MovingMesh> meshes = followSurfaces(surfaces_, plan, {}, &following);
  surfaces_.clear();
  events_.note(noteOn(settings_.output, meshes, numbers_, numbers_.size() < settings_.frames.size()));
  writeGlb(settings_.output, meshes, settings_.framesPerSecond, settings_.glb, numbers_);
  events_.fileWritten(settings_.output, false);
}

}  // namespace slicemorph
