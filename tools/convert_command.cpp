#include "tools/convert_command.h"

#include "engine/errors.h"
#include "io/output.h"
#include "tools/common_options.h"

#include <cstdio>

namespace slicemorph {
namespace {

struct ConvertSettings {
  std::string input, output;
  LoadOptions load;
  SamplingOptions sampling;
  int threads = 0;
  CLI::Option* threadsGiven = nullptr;
  bool quiet = false;
};

void runConvert(const ConvertSettings& s) {
  checkSampling(s.load, s.sampling);
  if (OutputName(s.output).isSequence())
    throw InputError("-o " + s.output + ": convert writes one file; leave out the ####");
  checkSurfaceOutput(s.output);
  checkInputExists(s.input);
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  const LoadedObject loaded = loadObject(s.input, s.load);
  printNotes(s.input + ": ", loaded.notes, s.quiet);
  SurfaceOutput options;
  options.halfFloat = loaded.halfFloat;
  writeSurface(s.output, *loaded.object.levelSet, options);
  if (!s.quiet) std::printf("%s\n", s.output.c_str());
}

}  // namespace

void addConvertCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand("convert", "Voxelise, mesh or resample a shape");
  const auto s = std::make_shared<ConvertSettings>();
  command->add_option("INPUT", s->input, "Shape: .vdb (file.vdb:grid picks a grid) .obj .ply .stl .off .glb")
      ->required();
  command->add_option("-o,--output", s->output, "Result: .vdb (a level set) .obj .ply .stl (its surface)")
      ->required()
      ->type_name("OUTPUT");
  s->sampling = addSamplingOptions(*command, s->load);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runConvert(*s); });
}

}  // namespace slicemorph
