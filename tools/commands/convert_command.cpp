#include "tools/commands/convert_command.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/level_set.h"
#include "engine/volume/resample_image.h"
#include "io/paths.h"
#include "io/vdb/grid_choice.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/commands/common_options.h"
#include "tools/job/image_lattice.h"

#include <cstdio>

namespace slicemorph {
namespace {

struct ConvertSettings {
  std::string input, output, like;
  LoadOptions load;
  SamplingOptions sampling;
  int threads = 0;
  CLI::Option* threadsGiven = nullptr;
  bool quiet = false;
};

bool isLabelMap(const Image& image, ImageKind kind) {
  return kind == ImageKind::kLabels || (kind == ImageKind::kAuto && looksLikeLabels(image));
}

/// The image on the lattice that was asked for, its own where none was.
Image onAskedLattice(Image image, const ConvertSettings& s) {
  if (s.like.empty() && s.load.voxelSize == 0 && s.load.resolution == 0) return image;
  const ImageLattice on =
      s.like.empty() ? cubicLattice(image.lattice, s.load) : readImage(s.like, s.load.image).image.lattice;
  return isLabelMap(image, s.load.imageKind) ? nearestTo(image, on) : resampledTo(image, on);
}

/// An image's values, and with --iso its surface beside them.
void writeGrids(const ConvertSettings& s, const Image& image) {
  const bool labels = isLabelMap(image, s.load.imageKind);
  openvdb::GridCPtrVec grids{gridOf(image, labels ? "labels" : "image", labels)};
  if (s.load.isoGiven) {
    const double smallest =
        std::min({image.lattice.spacing()[0], image.lattice.spacing()[1], image.lattice.spacing()[2]});
    grids.push_back(surfaceGrid(*toLevelSet(shapeAbove(image, s.load.iso), smallest, s.load.iso).grid));
  }
  writeVdb(s.output, grids, {});
}

Image imageOfGrid(const ConvertSettings& s) {
  const InputSpec name = parseInput(s.input);
  const VdbFile file(name.path);
  if (!name.selection.empty()) return imageOf(*file.read(findGrid(file, name)));
  for (size_t i = 0; i < file.entries().size(); ++i)
    if (const auto header = file.readHeader(i); header && (*header)["image_size"])
      return imageOf(*file.read(i));
  return imageOf(*file.read(gridsToTry(file, name.path).at(0)));
}

/// 1 inside, 0 outside.
Image maskOf(const FloatGrid& levelSet) {
  Image distances = imageOf(levelSet);
  std::vector<std::uint8_t> mask;
  for (float d : std::get<std::vector<float>>(distances.values)) mask.push_back(d < 0);
  distances.values = std::move(mask);
  return distances;
}

void convertToImage(const ConvertSettings& s) {
  if (isImageInput(s.input)) {
    ImageFile file = readImage(s.input, s.load.image);
    printNotes(s.input + ": ", file.notes, s.quiet);
    writeImage(s.output, onAskedLattice(std::move(file.image), s));
  } else if (parseInput(s.input).isGrids()) {
    writeImage(s.output, onAskedLattice(imageOfGrid(s), s));
  } else {
    const LoadedObject loaded = loadObject(s.input, s.load);
    printNotes(s.input + ": ", loaded.notes, s.quiet);
    Image mask = maskOf(*loaded.object.levelSet);
    writeImage(s.output,
               s.like.empty() ? mask : nearestTo(mask, readImage(s.like, s.load.image).image.lattice));
  }
}

void runConvert(const ConvertSettings& s) {
  checkSampling(s.load, s.sampling);
  if (OutputName(s.output).isSequence())
    throw InputError("-o " + s.output + ": convert writes one file; leave out the ####");
  checkOutput(s.output);
  checkInputExists(s.input);
  const auto limit = limitThreads(s.threads, s.threadsGiven);
  if (isImageOutput(s.output)) {
    convertToImage(s);
  } else if (isImageInput(s.input) && extensionOf(s.output) == ".vdb") {
    ImageFile file = readImage(s.input, s.load.image);
    printNotes(s.input + ": ", file.notes, s.quiet);
    writeGrids(s, onAskedLattice(std::move(file.image), s));
  } else {
    if (!s.like.empty()) throw InputError("--like is for images; the output " + s.output + " is none");
    const LoadedObject loaded = loadObject(s.input, s.load);
    printNotes(s.input + ": ", loaded.notes, s.quiet);
    SurfaceOutput options;
    options.halfFloat = loaded.halfFloat;
    options.colors = loaded.colors;
    writeSurface(s.output, *loaded.object.levelSet, options);
  }
  if (!s.quiet) std::printf("%s\n", s.output.c_str());
}

}  // namespace

void addConvertCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("convert", "Voxelise, mesh or resample a shape, or convert an image");
  const auto s = std::make_shared<ConvertSettings>();
  command
      ->add_option("INPUT", s->input,
                   "Shape: .vdb (file.vdb:grid picks a grid) .obj .ply .stl .off .glb; image: .nii .nii.gz "
                   ".nrrd .nhdr .mha .mhd "
                   "(file:N for a volume), a DICOM folder (folder:N for a series), name.####.tif|png|exr")
      ->required();
  command
      ->add_option("-o,--output", s->output,
                   "Result: .vdb (a level set; of an image its values, with --iso the surface beside them), "
                   ".obj .ply .stl .glb "
                   "(the surface), .nii .nii.gz .nrrd .mha (an image; of a shape 1 inside)")
      ->required()
      ->type_name("OUTPUT");
  s->sampling = addSamplingOptions(*command, s->load);
  command->add_option("--like", s->like, "Put an image on the voxels of another one")->type_name("IMAGE");
  s->threadsGiven = addThreadsOption(*command, s->threads);
  command->add_flag("--quiet", s->quiet, "Print nothing but errors");
  command->callback([s] { runConvert(*s); });
}

}  // namespace slicemorph
