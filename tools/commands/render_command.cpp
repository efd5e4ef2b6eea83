#include "tools/commands/render_command.h"

#include "io/image/video_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/commands/terminal_events.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"
#include "tools/job/render_pictures.h"

#include <cstdio>

namespace slicemorph {
namespace {

void checkRenderOutputs(const RenderJob& job) {
  if (job.output.empty() && job.sheet.empty())
    throw InputError("render needs an output: -o name.png, or --contact-sheet sheet.png");
  if (!job.output.empty()) checkExtension(job.output, {".png", ".exr", ".gif", ".mp4"});
  if (!job.sheet.empty()) checkExtension(job.sheet, {".png", ".exr"});
  for (const std::string& path : {job.output, job.sheet})
    if (!path.empty()) checkOutputPath(OutputName(path).path(1));
  if (!isVideoExtension(OutputName(job.output).extension())) return;
  if (OutputName(job.output).isSequence())
    throw InputError("-o " + job.output + " is one file for all pictures; leave out the ####");
  VideoWriter::checkAvailable(job.output);
}

/// --resolution means two sizes: WIDTHxHEIGHT that of the picture, one number that of a mesh in voxels.
RenderJob withResolution(RenderJob job, const std::string& text) {
  if (text.empty()) return job;
  int used = 0;
  if (parseSize(text)) {
    job.picture.size = text;
    job.picture.sizeOption = "--resolution";
  } else if (std::sscanf(text.c_str(), "%d%n", &job.load.resolution, &used) == 1 &&
             size_t(used) == text.size()) {
    checkRange("--resolution", job.load.resolution, 8, 4096);
  } else {
    throw InputError("--resolution " + text +
                     ": expected pixels, for example 640x480, or a number of voxels");
  }
  return job;
}

RenderJob renderJob(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  if (given.inputs.empty())
    throw InputError("render needs an input; for example: slicemorph render a.vdb -o a.png");
  RenderJob job;
  job.inputs = given.inputs, job.output = given.output, job.sheet = given.contactSheet;
  job.columns = given.columns, job.turntable = given.turntable;
  job.framesPerSecond = given.framesPerSecond, job.asSurface = given.fogAsSurface;
  job.picture = given.picture, job.load = loadSettings(options);
  job = withResolution(std::move(job), given.pictureResolution);
  job.picture.framing.allRound = job.turntable > 0;
  job.picture = checkedPicture(job.picture, options);
  job.picture.render.channels = OutputName(job.output).extension() == ".exr";
  checkRenderOutputs(job);
  return job;
}

void runRender(const OptionSet& options) {
  const JobOptions& given = options.values();
  const RenderJob job = renderJob(options);
  const auto limit = limitThreads(given.threads);
  job.load.memory.enforce();
  TerminalEvents events(given.quiet, given.verbose);
  renderPictures(job, events);
}

}  // namespace

void addRenderCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("render", "Pictures of shapes, fog and sequences, seen by one camera");
  const auto options = addOptions(*command, kRender);
  command->callback([options] { runRender(*options); });
}

}  // namespace slicemorph
