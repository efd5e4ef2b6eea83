#include "tools/commands/convert_command.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/same_image.h"
#include "io/image/image_formats.h"
#include "io/vdb/grid_choice.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/commands/command_options.h"
#include "tools/commands/common_options.h"
#include "tools/job/image_lattice.h"
#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/job/memory_need.h"
#include "tools/job/option_values.h"
#include "tools/job/write_structures.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

namespace slicemorph {
namespace {

struct ConvertSettings {
  std::string input, output, like, source, names;
  LoadOptions load;
  bool quiet = false, verbose = false;
  MeshSpace space = MeshSpace::kUnsaid;  ///< of meshes
};

/// An image and what is to be said of it.
struct ImageWithHeader {
  Image image;
  ImageHeader header;
};

/// The image on the lattice that the options ask for; unchanged where they ask for none.
ImageWithHeader onAskedLattice(Image image, ImageHeader header, const ConvertSettings& s) {
  if (s.like.empty() && s.load.voxelSize == 0 && s.load.resolution == 0)
    return {std::move(image), std::move(header)};
  ImageLattice on;
  if (s.like.empty()) {
    on = cubicLattice(image.lattice, s.load);
  } else {
    const ImageVoxels like = voxelsLike(s.like, s.load.image);
    on = like.lattice, header.forms = like.forms;
  }
  require(s.load.memory, s.output, needOfImage(on, 1));
  return {isLabelMap(image, s.load.imageKind) ? nearestTo(image, on) : resampledTo(image, on),
          std::move(header)};
}

/// The settings for a file that may say itself that its values are labels.
ConvertSettings settingsFor(const ImageFile& file, ConvertSettings s) {
  if (s.load.imageKind == ImageKind::kAuto && isStatedLabels(file)) s.load.imageKind = ImageKind::kLabels;
  return s;
}

/// The image that is converted; labels that are stored as floating point are rounded but where values stay as they are.
ImageFile imageToConvert(const InputSpec& input, const ConvertSettings& s) {
  ImageFile file = readImage(input, s.load.image);
  const bool resampled = !s.like.empty() || s.load.voxelSize != 0 || s.load.resolution != 0;
  if (resampled || !isImageOutput(s.output)) takeLabels(file, s.load.imageKind);
  return file;
}

/// Writes an image's values as a grid, and with --iso its surface as another.
void writeGrids(const ConvertSettings& s, const Image& image) {
  const bool labels = isLabelMap(image, s.load.imageKind);
  openvdb::GridCPtrVec grids{gridOf(image, labels ? "labels" : "image", labels)};
  if (s.load.isoGiven) {
    const double smallest =
        std::min({image.lattice.spacing()[0], image.lattice.spacing()[1], image.lattice.spacing()[2]});
    grids.push_back(surfaceGrid(*levelSetOf(shapeAbove(image, s.load.iso), s.load.iso, smallest)));
  }
  writeGridFile(s.output, grids, {});
}

/// The grid that is named, else the first that was made from an image, else the one that loadObject
/// would try first.
size_t gridForImage(const VdbFile& file, const InputSpec& name) {
  if (!name.selection.empty()) return findGrid(file, name);
  for (size_t i = 0; i < file.entries().size(); ++i)
    if (const auto header = file.readHeader(i); header && (*header)["image_size"]) return i;
  return gridsToTry(file, name.path).at(0);
}

Image imageOfGrid(const ConvertSettings& s) {
  const InputSpec name = stillInput(parseInput(s.input));
  const VdbFile file(name.path);
  const openvdb::GridBase::Ptr grid =
      placed(file.read(gridForImage(file, name)), placingOf(name.placing, s.load.image.up));
  require(s.load.memory, s.input, needOfDenseGrid(*grid));
  return imageOf(*grid);
}

/// A mask of a level set: 1 inside, 0 outside.
Image maskOf(const FloatGrid& levelSet) {
  Image distances = imageOf(levelSet);
  std::vector<std::uint8_t> mask;
  for (float d : std::get<std::vector<float>>(distances.values)) mask.push_back(d < 0);
  distances.values = std::move(mask);
  return distances;
}

/// The header of a file of some volumes of another: the time between them, where they follow each other evenly.
ImageHeader headerOfVolumes(ImageHeader header, const std::vector<InputFrame>& volumes) {
  const int step = volumes[1].number - volumes[0].number;
  bool even = true;
  for (size_t n = 1; n < volumes.size(); ++n)
    even = even && volumes[n].number - volumes[n - 1].number == step;
  header.timeStep = even ? header.timeStep * std::abs(step) : 0;
  return header;
}

/// Several volumes of an image become one file.
void convertVolumes(const ConvertSettings& s, const std::vector<InputFrame>& volumes) {
  std::optional<ImageSliceWriter> writer;
  Image first;  // without its values
  for (const InputFrame& volume : volumes) {
    ImageFile file = imageToConvert(volume.input, s);
    // Where volumes become one file, the time between them does count, and is told once.
    for (Note& note : file.notes)
      if (note.code == kTimeByRepetition && !writer) note.severity = Severity::kNote;
    printNotes(volume.input.text + ": ", file.notes, s.quiet, s.verbose);
    const ConvertSettings own = settingsFor(file, s);
    const auto [image, header] = onAskedLattice(std::move(file.image), std::move(file.header), own);
    if (!writer) {
      first.lattice = image.lattice;
      writer.emplace(s.output, image.lattice, image.values, int(volumes.size()),
                     headerOfVolumes(header, volumes));
      first.values =
          std::visit([](const auto& v) { return ImageValues(std::decay_t<decltype(v)>()); }, image.values);
    }
    if (image.values.index() != first.values.index())
      throw InputError(volume.input.text, "its values have another type than those of " +
                                              volumes[0].input.text +
                                              ", and one file holds one type; convert each volume by itself");
    if (!sameLattice(image.lattice, first.lattice))
      throw InputError(volume.input.text,
                       "has other voxels than " + volumes[0].input.text +
                           ", and one file holds one lattice; convert each volume by itself, or "
                           "give --like IMAGE");
    writer->add(image.values);
  }
  writer->commit();
}

void convertToImage(const ConvertSettings& s) {
  const InputSpec input = parseInput(s.input);
  if (input.isImage() && input.isMoving()) {
    const std::vector<InputFrame> volumes = framesOf(input);
    if (volumes.size() > 1) return convertVolumes(s, volumes);
  }
  if (input.isImage()) {
    ImageFile file = imageToConvert(input, s);
    printNotes(s.input + ": ", file.notes, s.quiet, s.verbose);
    const auto [image, header] =
        onAskedLattice(std::move(file.image), std::move(file.header), settingsFor(file, s));
    writeImage(s.output, image, header);
  } else if (parseInput(s.input).isGrids()) {
    const auto [image, header] = onAskedLattice(imageOfGrid(s), {}, s);
    writeImage(s.output, image, header);
  } else {
    const LoadedObject loaded = loadObject(s.input, s.load);
    printNotes(s.input + ": ", loaded.notes, s.quiet, s.verbose);
    require(s.load.memory, s.input, needOfDenseGrid(*loaded.object.levelSet));
    Image mask = maskOf(*loaded.object.levelSet);
    if (s.like.empty()) return writeImage(s.output, mask);
    const ImageFile like = readImage(s.like, s.load.image);
    writeImage(s.output, nearestTo(mask, like.image.lattice), like.header);
  }
}

/// Labels, or the shape of anything else, as structures.
void convertToStructures(const ConvertSettings& s) {
  StructuresJob job{s.input, s.output, s.source, s.like, s.names, s.load.image};
  if (isImageInput(s.input)) {
    ImageFile file = readImage(s.input, s.load.image);
    takeLabels(file, s.load.imageKind);
    const ConvertSettings own = settingsFor(file, s);
    if (isLabelMap(file.image, own.load.imageKind)) {
      printNotes(s.input + ": ", file.notes, s.quiet, s.verbose);
      job.labels = file.header.labels;
      const auto labels = std::make_shared<const Image>(onAskedLattice(std::move(file.image), {}, own).image);
      printNotes(s.output + ": ", writeLabelStructures(job, labels), s.quiet, s.verbose);
      return;
    }
  }
  const LoadedObject loaded = loadObject(s.input, s.load);
  printNotes(s.input + ": ", loaded.notes, s.quiet, s.verbose);
  const std::string name = loaded.gridName.empty()
                               ? std::filesystem::path(parseInput(s.input).path).stem().string()
                               : loaded.gridName;
  const FloatGrid& shape = *loaded.object.levelSet;
  ImageLattice otherwise;
  if (loaded.image) {
    otherwise = loaded.image->lattice;
  } else if (s.like.empty() && s.source.empty()) {
    require(s.load.memory, s.input, needOfDenseGrid(shape));
    otherwise = imageOf(shape).lattice;
  }
  const Notes notes = writeSurfaceStructures(job, {{1, name, loaded.object.levelSet}}, otherwise);
  printNotes(s.output + ": ", notes, s.quiet, s.verbose);
}

void runConvert(const OptionSet& options) {
  options.checkExclusions();
  const JobOptions& given = options.values();
  const MeshSpace usual = isImageInput(given.input) ? MeshSpace::kLps : MeshSpace::kUnsaid;
  const ConvertSettings s = {given.input,  given.output,  given.like,
                             given.source, given.names,   loadSettings(options),
                             given.quiet,  given.verbose, meshSpace(options, given.output, usual)};
  if (OutputName(s.output).isSequence())
    throw InputError("-o " + s.output + ": convert writes one file; leave out the ####");
  checkStudyOutput(s.output, s.source, s.names);
  checkInputExists(s.input);
  const auto limit = limitThreads(given.threads);
  s.load.memory.enforce();
  if (isStructureOutput(s.output)) {
    convertToStructures(s);
  } else if (isImageOutput(s.output)) {
    convertToImage(s);
  } else if (isImageInput(s.input) && isGridOutput(s.output)) {
    ImageFile file = imageToConvert(parseInput(s.input), s);
    printNotes(s.input + ": ", file.notes, s.quiet, s.verbose);
    const ConvertSettings own = settingsFor(file, s);
    writeGrids(own, onAskedLattice(std::move(file.image), {}, own).image);
  } else {
    if (!s.like.empty()) throw InputError("--like is for images; the output " + s.output + " is none");
    const LoadedObject loaded = loadObject(s.input, s.load);
    printNotes(s.input + ": ", loaded.notes, s.quiet, s.verbose);
    SurfaceOutput options;
    options.halfFloat = loaded.halfFloat, options.doubles = loaded.doubles && !loaded.fog;
    options.name = surfaceNameOf({loaded});
    options.colors = loaded.colors, options.space = s.space;
    writeSurface(s.output, *loaded.object.levelSet, options);
  }
  if (!s.quiet) std::printf("%s\n", s.output.c_str());
}

}  // namespace

void addConvertCommand(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("convert", "Voxelise, mesh or resample a shape, or convert an image");
  const auto options = addOptions(*command, kConvert);
  command->callback([options] { runConvert(*options); });
}

}  // namespace slicemorph
