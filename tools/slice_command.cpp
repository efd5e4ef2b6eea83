#include "tools/slice_command.h"

#include "engine/errors.h"
#include "engine/slices/place_sections.h"
#include "engine/spine/fit_spine.h"
#include "io/exr_slice_writer.h"
#include "io/input_grids.h"
#include "io/output.h"
#include "tools/common_options.h"
#include "tools/plane_file.h"
#include "tools/terminal_progress.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdio>

namespace slicemorph {
namespace {

struct SliceSettings {
  std::string input, output, axis = "auto", grids, planeFile;
  std::vector<std::string> planes;
  SectionOptions section;
  SliceExrOptions exr;
  LoadOptions load;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *pixelGiven = nullptr, *slicesGiven = nullptr, *axisGiven = nullptr,
              *tilesGiven = nullptr, *timeGiven = nullptr, *gridsGiven = nullptr;
  double t = 0;
  int threads = 0;
  bool spine = false, quiet = false;

  bool givenPlanes() const { return !planes.empty() || !planeFile.empty(); }
};

std::vector<PlaneInSpace> planesInSpace(const SliceSettings& s) {
  std::vector<PlaneInSpace> planes;
  if (!s.planeFile.empty()) planes = readPlanes(s.planeFile);
  for (const std::string& plane : s.planes) planes.push_back(parsePlane("--plane", plane));
  return planes;
}

void checkSettings(SliceSettings& s) {
  checkRange("--slices", s.section.count, 1, 100000);
  checkSampling(s.load, s.sampling);
  if (s.pixelGiven->count()) checkPositive("--pixel-size", s.section.pixelSize);
  if (s.tilesGiven->count()) checkRange("--tiles", s.exr.tile, 8, 65536);
  if (s.timeGiven->count()) {
    if (!(s.t >= 0 && s.t <= 1))
      throw InputError("--t " + formatNumber(s.t) + " is out of range; it must be 0 to 1");
    s.exr.t = s.t;
  }
  if (s.axis != "auto") s.section.axis = parseDirection("--axis", s.axis);
  const int ways = int(s.givenPlanes()) + int(s.spine) + int(s.axisGiven->count() > 0);
  if (ways > 1) throw InputError("--axis, --spine and --plane or --planes exclude each other");
  if (s.givenPlanes() && s.slicesGiven->count())
    throw InputError("--slices " + std::to_string(s.section.count) +
                     ": the planes are given, their number too");
  checkExtension(s.output, {".exr"});
  checkOutputPath(OutputName(s.output).path(1));
}

/// Grids of VDB files are sliced as they are: what says how to voxelise would do nothing.
void checkVoxels(const SliceSettings& s) {
  const bool voxels = s.sampling.voxelSize->count() || s.sampling.resolution->count();
  const bool vdb = !isImageInput(s.input) && extensionOf(splitInput(s.input).path) == ".vdb";
  if (voxels && vdb && !s.load.isoGiven && !s.spine)
    throw InputError(
        s.input +
        " is sliced as it is; --voxel-size and --resolution are for meshes; --pixel-size sets the pixels");
}

openvdb::GridCPtrVec baresOf(const std::vector<SliceGrid>& grids) {
  openvdb::GridCPtrVec bare;
  for (const SliceGrid& grid : grids) bare.push_back(grid.grid);
  return bare;
}

std::vector<SectionPlane> placed(const InputGrids& input, const SliceSettings& s,
                                 const std::vector<PlaneInSpace>& given) {
  const openvdb::GridCPtrVec grids = baresOf(input.grids);
  if (!given.empty()) return sectionPlanesAt(given, grids, s.section.pixelSize);
  if (s.spine) {
    if (const auto spine = fitSpine(DistanceField(input.shape)))
      return sectionPlanesAlong(spine->chart, grids, s.section.count, s.section.pixelSize);
    printNotes(s.input + ": ", {"the shape has no clear axis of its own: the slices are parallel"}, s.quiet);
  }
  return sectionPlanes(grids, s.section);
}

/// What the file of a frame says of its time.
void takeTime(const openvdb::MetaMap& metadata, SliceExrOptions& exr) {
  if (const auto frame = metadata.getMetadata<openvdb::Int32Metadata>("frame")) exr.frame = frame->value();
  if (const auto fps = metadata.getMetadata<openvdb::FloatMetadata>("fps"); fps && fps->value() > 0)
    exr.framesPerSecond = double(fps->value());
}

void writeFiles(const OutputName& name, const std::vector<SliceGrid>& grids,
                const std::vector<SectionPlane>& planes, const SliceSettings& s) {
  TerminalProgress progress(s.quiet);
  if (!name.isSequence()) return writeSlicesExr(name.path(1), grids, planes, s.exr, progress);
  std::atomic<size_t> done{0};
  tbb::parallel_for(size_t(0), planes.size(), [&](size_t i) {
    if (progress.cancelled()) throw Cancelled();
    writeSliceExr(name.path(int(i) + 1), grids, planes, i, s.exr);
    progress.report("slicing", double(++done) / double(planes.size()));
  });
}

void runSlice(SliceSettings& s) {
  checkSettings(s);
  const std::vector<std::string> wanted =
      s.gridsGiven->count() ? parseNames("--grids", s.grids) : std::vector<std::string>();
  const std::vector<PlaneInSpace> given = planesInSpace(s);
  checkInputExists(s.input);
  checkVoxels(s);
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  cancelOnInterrupt();

  const InputGrids input = readInputGrids(s.input, wanted, s.load, s.spine);
  printNotes(s.input + ": ", input.notes, s.quiet);
  s.exr.units = input.units;
  takeTime(input.metadata, s.exr);
  const std::vector<SectionPlane> planes = placed(input, s, given);
  const OutputName name(s.output);
  writeFiles(name, input.grids, planes, s);
  if (s.quiet) return;
  for (int i = 1; i <= (name.isSequence() ? int(planes.size()) : 1); ++i)
    std::printf("%s\n", name.path(i).c_str());
}

}  // namespace

void addSliceCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("slice", "Oriented slices of any volume, all its grids, as EXR images");
  const auto s = std::make_shared<SliceSettings>();
  command
      ->add_option("INPUT", s->input,
                   "Volume: .vdb (all grids; file.vdb:grid one), .obj .ply .stl .off .glb, an image (.nii "
                   ".nii.gz .nrrd "
                   ".nhdr .mha .mhd, a DICOM folder, name.####.tif|png)")
      ->required();
  command
      ->add_option("-o,--output", s->output,
                   "Images: name.####.exr, one a slice from 1, or name.exr, one file of several parts")
      ->required()
      ->type_name("OUTPUT");
  s->slicesGiven =
      command->add_option("--slices", s->section.count, "Slices, 1 to 100000 (64)")->type_name("N");
  s->axisGiven = command->add_option("--axis", s->axis, "Slicing direction; auto: the volume's longest")
                     ->type_name("auto|x|y|z|DX,DY,DZ");
  command->add_flag("--spine", s->spine, "Slices lean: they stand across the shape's own curved axis");
  command
      ->add_option("--plane", s->planes, "Slice here: a point and a normal, world units; may be given again")
      ->type_name("OX,OY,OZ/NX,NY,NZ")
      ->allow_extra_args(false);
  command
      ->add_option("--planes", s->planeFile,
                   "Slice on the planes of a text or CSV file: ox oy oz nx ny nz a line")
      ->type_name("FILE");
  s->gridsGiven =
      command->add_option("--grids", s->grids, "Only these grids (all)")->type_name("NAME[,NAME...]");
  s->pixelGiven =
      command->add_option("--pixel-size", s->section.pixelSize, "Edge of a pixel, world units (one voxel)")
          ->type_name("H");
  command->add_flag("--half", s->exr.halfFloat, "16-bit floats; whole numbers keep 32 bits");
  command
      ->add_option("--compression", s->exr.compression,
                   "Of the EXR files (zip); from pxr24 on values lose precision")
      ->type_name("none|rle|zips|zip|piz|pxr24|b44|b44a|dwaa|dwab")
      ->check(oneOf(exrCompressions()));
  s->tilesGiven =
      command->add_option("--tiles", s->exr.tile, "Tiles of N x N pixels, 8 to 65536 (scan lines)")
          ->type_name("N");
  s->timeGiven =
      command->add_option("--t", s->t, "Time of the volume in its morph, 0 to 1, for the attribute sliceT")
          ->type_name("T");
  s->sampling = addSamplingOptions(*command, s->load);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runSlice(*s); });
}

}  // namespace slicemorph
