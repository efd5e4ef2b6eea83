#include "tools/commands/reconstruct_command.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/image_lattice.h"
#include "tools/job/reconstruct.h"

namespace slicemorph {
namespace {

struct ReconstructSettings {
  ReconstructJob job;
  std::string axis = "auto", grids;
  int threads = 0;
  CLI::Option *threadsGiven = nullptr, *voxelSizeGiven = nullptr, *betweenGiven = nullptr,
              *everyGiven = nullptr, *gridsGiven = nullptr;
  bool quiet = false;
};

void runReconstruct(ReconstructSettings& s) {
  ReconstructJob& job = s.job;
  const size_t axis = std::string("ijk").find(s.axis);
  if (s.axis != "auto" && (s.axis.size() != 1 || axis == std::string::npos))
    throw InputError("--axis " + s.axis + ": expected auto, i, j or k, the image's own axes");
  if (s.axis != "auto") job.axis = int(axis);
  if (s.voxelSizeGiven->count()) checkPositive("--voxel-size", job.voxelSize);
  if (s.everyGiven->count()) checkRange("--every", job.every, 2, 10000);
  if (s.betweenGiven->count()) checkRange("--between", job.between, 1, 1000);
  if (s.everyGiven->count() && s.betweenGiven->count())
    throw InputError("--every and --between exclude each other");
  if (s.gridsGiven->count()) job.grids = parseNames("--grids", s.grids);
  checkOutput(OutputName(job.output).path(1));
  for (const std::string& report : job.reports) {
    checkExtension(report, {".json", ".csv"});
    checkOutputPath(report);
  }
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  TerminalEvents events(s.quiet);
  reconstruct(job, events);
}

}  // namespace

void addReconstructCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "reconstruct", "A dense label map or closed surfaces from slices or contours, grids from EXR slices");
  const auto s = std::make_shared<ReconstructSettings>();
  command
      ->add_option(
          "INPUT", s->job.input,
          "Label map in which slices are empty, or a stack with --between: .nii .nii.gz .nrrd .nhdr .mha "
          ".mhd "
          "name.####.tif|png; contours: .csl, a DICOM RT structure set (file:NAME for one structure); slices "
          "of a "
          "volume as `slice` writes them: name.####.exr, or one file")
      ->required();
  command
      ->add_option("-o,--output", s->job.output,
                   "Result: .nii .nii.gz .nrrd .mha (a dense label map); .obj .ply .stl .glb (surfaces, #### "
                   "stands for the label); "
                   ".vdb (a level set per label; of EXR slices all their grids)")
      ->required()
      ->type_name("OUTPUT");
  command->add_option("--axis", s->axis, "Array axis that the slices follow each other along (auto)")
      ->type_name("auto|i|j|k");
  s->everyGiven =
      command
          ->add_option("--every", s->job.every, "Every n-th slice is given, also where it is empty (found)")
          ->type_name("N");
  s->betweenGiven =
      command
          ->add_option("--between", s->job.between, "All slices are given; put N between every two of them")
          ->type_name("N");
  s->voxelSizeGiven =
      command
          ->add_option(
              "--voxel-size", s->job.voxelSize,
              "Edge of a voxel of surfaces, millimetres (found), or of grids, world units (one pixel)")
          ->type_name("H");
  s->gridsGiven = command->add_option("--grids", s->grids, "Of EXR slices only these grids (all)")
                      ->type_name("NAME[,NAME...]");
  command->add_option("--like", s->job.like, "Put the dense label map on the voxels of this image")
      ->type_name("IMAGE");
  addSpacingOption(*command, s->job.image);
  command->add_option("--report", s->job.reports, "Volume, area and extents of every label")
      ->type_name("FILE.json|FILE.csv")
      ->allow_extra_args(false);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runReconstruct(*s); });
}

}  // namespace slicemorph
