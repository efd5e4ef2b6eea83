#include "tools/commands/render_command.h"

#include "io/image/video_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/render_pictures.h"

#include <cstdio>
#include <memory>

namespace slicemorph {
namespace {

struct RenderSettings {
  RenderJob job;
  SamplingOptions sampling;
  CLI::Option *threadsGiven = nullptr, *turntableGiven = nullptr;
  int threads = 0;
  bool quiet = false;
};

void checkOutputs(const RenderSettings& s) {
  if (s.job.output.empty() && s.job.sheet.empty())
    throw InputError("render needs an output: -o name.png, or --contact-sheet sheet.png");
  if (!s.job.output.empty()) checkExtension(s.job.output, {".png", ".exr", ".gif", ".mp4"});
  if (!s.job.sheet.empty()) checkExtension(s.job.sheet, {".png", ".exr"});
  for (const std::string& path : {s.job.output, s.job.sheet})
    if (!path.empty()) checkOutputPath(OutputName(path).path(1));
  checkPositive("--fps", s.job.framesPerSecond);
  if (!isVideoExtension(OutputName(s.job.output).extension())) return;
  if (OutputName(s.job.output).isSequence())
    throw InputError("-o " + s.job.output + " is one file for all pictures; leave out the ####");
  VideoWriter::checkAvailable(s.job.output);
}

void runRender(RenderSettings& s) {
  if (s.job.inputs.empty())
    throw InputError("render needs an input; for example: slicemorph render a.vdb -o a.png");
  checkSampling(s.job.load, s.sampling);
  checkRange("--samples", s.job.picture.render.samples, 1, 64);
  checkRange("--columns", s.job.columns, 0, 1000);
  if (s.turntableGiven->count()) checkRange("--turntable", s.job.turntable, 1, 100000);
  s.job.picture.framing.allRound = s.job.turntable > 0;
  checkPictureOptions(s.job.picture);
  checkOutputs(s);
  s.job.picture.render.channels = OutputName(s.job.output).extension() == ".exr";
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  TerminalEvents events(s.quiet);
  renderPictures(s.job, events);
}

/// One option for two sizes that everybody calls the resolution: of the picture, and of a mesh's voxels.
void addResolutionOption(CLI::App& command, RenderSettings& s) {
  command.remove_option(s.sampling.resolution);
  s.sampling.resolution = nullptr;
  const auto parse = [&s](const std::string& text) {
    int width = 0, height = 0, used = 0;
    if (parseSize(text, width, height)) {
      s.job.picture.size = text;
      s.job.picture.sizeOption = "--resolution";
    } else if (std::sscanf(text.c_str(), "%d%n", &s.job.load.resolution, &used) == 1 &&
               size_t(used) == text.size()) {
      checkRange("--resolution", s.job.load.resolution, 8, 4096);
    } else {
      throw InputError("--resolution " + text +
                       ": expected pixels, for example 640x480, or a number of voxels");
    }
  };
  command
      .add_option_function<std::string>(
          "--resolution", parse,
          "Pixels of a picture, as --size; or one number: voxels along the longest side of a "
          "mesh, 8 to 4096 (256)")
      ->type_name("WxH|N");
}

}  // namespace

void addRenderCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("render", "Pictures of shapes, fog and sequences, seen by one camera");
  const auto s = std::make_shared<RenderSettings>();
  command->add_option("INPUT", s->job.inputs,
                      "Shapes and fog; name.####.vdb stands for all files of that name that are there");
  command
      ->add_option("-o,--output", s->job.output,
                   "Pictures: .png, .exr (with mask, Z and N); #### stands for the number; a preview: .gif, "
                   ".mp4 (needs ffmpeg)")
      ->type_name("OUTPUT");
  command
      ->add_option("--contact-sheet", s->job.sheet, "All pictures on one sheet, with captions: .png or .exr")
      ->type_name("FILE");
  command->add_option("--columns", s->job.columns, "Columns of the contact sheet (0: about as wide as high)")
      ->type_name("N");
  command->add_option("--fps", s->job.framesPerSecond, "Pictures a second of a preview (24)")->type_name("F");
  command
      ->add_option("--samples", s->job.picture.render.samples,
                   "Rays per pixel, 1 to 64 (4); of surfaces only where these end or turn")
      ->type_name("N");
  addPictureOptions(*command, s->job.picture);
  s->turntableGiven =
      command
          ->add_option("--turntable", s->job.turntable,
                       "Pictures of a full turn around the up axis, during which a sequence plays once")
          ->type_name("N");
  command->add_flag("--surface", s->job.asSurface, "Fog is drawn as the shape in it, at --iso");
  s->sampling = addSamplingOptions(*command, s->job.load);
  addResolutionOption(*command, *s);
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runRender(*s); });
}

}  // namespace slicemorph
