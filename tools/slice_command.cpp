#include "tools/slice_command.h"

#include "engine/errors.h"
#include "engine/slices/section.h"
#include "io/exr_writer.h"
#include "io/output.h"
#include "tools/common_options.h"
#include "tools/terminal_progress.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdio>

namespace slicemorph {
namespace {

struct SliceSettings {
  std::string input, output, axis = "auto";
  SectionOptions section;
  LoadOptions load;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *pixelGiven = nullptr;
  int threads = 0;
  bool quiet = false;
};

void writeSlices(const FloatGrid& grid, const SliceSettings& s) {
  const OutputName name(s.output);
  const std::vector<SectionPlane> planes = sectionPlanes(grid, s.section);
  TerminalProgress progress(s.quiet);
  std::atomic<size_t> done{0};
  tbb::parallel_for(size_t(0), planes.size(), [&](size_t i) {
    if (progress.cancelled()) throw Cancelled();
    writeSliceExr(name.path(int(i) + 1), sampleSection(grid, planes[i]));
    progress.report("slicing", double(++done) / double(planes.size()));
  });
}

void runSlice(SliceSettings& s) {
  checkRange("--slices", s.section.count, 1, 100000);
  checkSampling(s.load, s.sampling);
  if (s.pixelGiven->count()) checkPositive("--pixel-size", s.section.pixelSize);
  if (s.axis != "auto") s.section.axis = parseDirection("--axis", s.axis);
  const OutputName name(s.output);
  if (s.section.count > 1 && !name.isSequence())
    throw InputError("-o " + s.output + " is one file for " + std::to_string(s.section.count) +
                     " slices; put #### where the slice number belongs (name.####.exr)");
  checkExtension(s.output, {".exr"});
  checkOutputPath(name.path(1));
  checkInputExists(s.input);
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  cancelOnInterrupt();

  const LoadedObject loaded = loadObject(s.input, s.load);
  printNotes(s.input + ": ", loaded.notes, s.quiet);
  writeSlices(*loaded.object.levelSet, s);
  if (s.quiet) return;
  for (int i = 1; i <= s.section.count; ++i) std::printf("%s\n", name.path(i).c_str());
}

}  // namespace

void addSliceCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand("slice", "Oriented slices of a shape as float EXR images");
  const auto s = std::make_shared<SliceSettings>();
  command->add_option("INPUT", s->input, "Shape: .vdb (file.vdb:grid picks a grid) .obj .ply .stl .off .glb")
      ->required();
  command->add_option("-o,--output", s->output, "Images: .exr; #### stands for the slice number, from 1")
      ->required()
      ->type_name("OUTPUT");
  command->add_option("--slices", s->section.count, "Slices, 1 to 100000 (64)")->type_name("N");
  command->add_option("--axis", s->axis, "Slicing direction; auto: the shape's longest")
      ->type_name("auto|x|y|z|DX,DY,DZ");
  s->pixelGiven =
      command->add_option("--pixel-size", s->section.pixelSize, "Edge of a pixel, world units (one voxel)")
          ->type_name("H");
  s->sampling = addSamplingOptions(*command, s->load);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runSlice(*s); });
}

}  // namespace slicemorph
