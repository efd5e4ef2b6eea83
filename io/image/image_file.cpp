#include "slicemorph/io/image_file.h"

#include "io/format.h"
#include "io/image/chosen_volume.h"
#include "io/image/image_formats.h"
#include "io/image/itk_library.h"
#include "io/image/nifti_reader.h"
#include "io/image/stack_reader.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/placing.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>

namespace slicemorph {
namespace {

bool isFolder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

/// Throws MemoryError for images that would not fit.
SizeCheck checkOf(const InputSpec& input, const ImageOptions& options) {
  return [&input, &options](const openvdb::Coord& size, double bytes) {
    options.memory.require(bytes, input.text,
                           "an image of " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
                               " x " + std::to_string(size[2]) + " voxels",
                           "crop it or make it coarser");
  };
}

/// The DICOM volume that is selected, or the only one.
ImageFile readOneVolume(const InputSpec& input, const ImageOptions& options) {
  Notes notes;
  const DicomChoice choice = itkReaders().chooseVolume(input.path, input.selection, options.force, notes);
  ImageFile file = itkReaders().dicomVolume(input.path, choice, options, checkOf(input, options));
  file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
  return file;
}

/// A volume for a listing: a large one without values.
ImageFile volumeToList(const InputSpec& input, const ImageOptions& options, const DicomChoice& choice,
                       double mostVoxels) {
  const DicomFile& first = choice.series.files[0];
  const double voxels =
      choice.series.isSegmentation()
          ? 0
          : double(first.columns) * first.rows * double(choice.series.volumes[choice.volume].slices.size());
  return voxels > mostVoxels ? itkReaders().dicomHead(input.path, choice, options)
                             : itkReaders().dicomVolume(input.path, choice, options, checkOf(input, options));
}

/// The same; where it is refused, the reason as a note.
ImageFile listedVolume(const InputSpec& input, const ImageOptions& options, const DicomChoice& choice,
                       double mostVoxels) {
  try {
    return volumeToList(input, options, choice, mostVoxels);
  } catch (const MemoryError&) {
    throw;
  } catch (const Error& error) {
    const DicomFile& first = choice.series.files[0];
    ImageFile file;
    file.format = "DICOM series";
    file.about = choice.series.modality;
    file.image.lattice.size =
        openvdb::Coord(first.columns, first.rows, int(choice.series.volumes[choice.volume].slices.size()));
    file.notes.emplace_back(kImageRefused, Severity::kWarning, error.note().about, error.note().text);
    return file;
  }
}

/// Every volume of every series.
void listVolumes(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                 const ImageVisitor& visit) {
  DicomFolder folder = itkReaders().dicomFolder(input.path, options.force);
  Notes notes = std::move(folder.notes);  // of the first volume that is told of
  for (const auto& [uid, note] : folder.damaged) notes.push_back(note);
  for (size_t i = 0; i < folder.series.size(); ++i) {
    DicomChoice choice{std::move(folder.series[i]), 0};
    const size_t volumes = choice.series.isSegmentation() ? 1 : choice.series.volumes.size();
    for (size_t v = 0; v < volumes; ++v) {
      choice.volume = choice.series.isSegmentation() ? 0 : v;
      const bool only = folder.series.size() == 1 && volumes == 1;
      ImageFile file = only ? volumeToList(input, options, choice, mostVoxels)
                            : listedVolume(input, options, choice, mostVoxels);
      file.name = input.path + ":" + std::to_string(i + 1);
      if (volumes > 1) file.name += "@" + std::to_string(v + 1);
      file.volumes = int(volumes);
      file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
      notes.clear();
      visit(std::move(file));
    }
  }
}

/// Whether a file of any name begins as DICOM files do (PS3.10 section 7.1).
bool beginsAsDicom(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::binary);
  char head[132];
  return file.read(head, sizeof head) && std::string_view(head + 128, 4) == "DICM";
}

/// Places an image as its braces ask, which takes it out of the space that its NIfTI codes name.
void placeImage(const InputSpec& input, const ImageOptions& options, ImageFile& file) {
  const Placing placing = placingOf(input.placing, options.up);
  place(file.image.lattice, placing);
  if (!placing.isIdentity()) file.header.forms.reset();
}

void noteNotFinite(ImageFile& file) {
  const auto [all, count] = std::visit(
      [](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        size_t found = 0;
        if constexpr (std::is_floating_point_v<T>)
          for (const T v : values) found += !std::isfinite(v);
        return std::pair(values.size(), found);
      },
      file.image.values);
  if (count > 0)
    file.notes.emplace_back("image.not-finite", Severity::kWarning, "",
                            std::to_string(count) + " of its " + std::to_string(all) +
                                " values are not finite (NaN or infinite): shapes have NaN outside");
}

}  // namespace

bool isDicomImage(const std::string& path) {
  const std::string extension = extensionOf(path);
  return extension == ".dcm" || extension == ".ima" || isFolder(path) || beginsAsDicom(path);
}

bool isImageStack(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".tif" || extension == ".tiff") return true;
  return (extension == ".png" || extension == ".exr") && isNumbered(path);
}

ImageFile readNiftiImage(const InputSpec& input, const ImageOptions& options) {
  return readNifti(input.path, volumeOf(input), options, checkOf(input, options));
}

ImageFile readNrrdImage(const InputSpec& input, const ImageOptions& options) {
  return itkReaders().nrrd(input.path, volumeOf(input), options, checkOf(input, options));
}

ImageFile readMetaImageFile(const InputSpec& input, const ImageOptions& options) {
  return itkReaders().metaImage(input.path, volumeOf(input), options, checkOf(input, options));
}

ImageFile readDicomImage(const InputSpec& input, const ImageOptions& options) {
  return readOneVolume(input, options);
}

void listDicomImages(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                     const ImageVisitor& visit) {
  const bool whole = isFolder(input.path) || itkReaders().dicomHoldsVolumes(input.path);
  if (input.selection.empty() && whole) return listVolumes(input, options, mostVoxels, visit);
  Notes notes;
  const DicomChoice choice = itkReaders().chooseVolume(input.path, input.selection, options.force, notes);
  ImageFile file = volumeToList(input, options, choice, mostVoxels);
  file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
  file.name = input.text;
  visit(std::move(file));
}

bool isStatedLabels(const ImageFile& file) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [](const Note& note) { return note.code == kLabelsStated; });
}

ImageFile readStackImage(const InputSpec& input, const ImageOptions& options) {
  return readStack(input, options);
}

std::optional<ImageSlices> openNiftiSlices(const InputSpec& input, const ImageOptions& options) {
  return openNifti(input.path, volumeOf(input), options);
}

std::optional<ImageSlices> openNrrdSlices(const InputSpec& input, const ImageOptions& options) {
  return itkReaders().nrrdSlices(input.path, volumeOf(input), options);
}

std::optional<ImageSlices> openMetaImageSlices(const InputSpec& input, const ImageOptions& options) {
  return itkReaders().metaImageSlices(input.path, volumeOf(input), options);
}

std::optional<ImageSlices> openStackSlices(const InputSpec& input, const ImageOptions& options) {
  return openStack(input, options);
}

void listStackImages(const InputSpec& input, const ImageOptions& options, double, const ImageVisitor& visit) {
  ImageFile file = readStack(input, options, /*placed=*/options.spacing[0] != 0);
  file.name = input.text;
  visit(std::move(file));
}

ImageFile readImage(const InputSpec& given, const ImageOptions& options) {
  const InputSpec input = stillInput(given);
  if (!input.format || !input.format->readImage)
    throw InputError(input.text, "is no image; use " + readableList(Contents::kImage));
  ImageFile file = input.format->readImage(input, options);
  placeImage(input, options, file);
  noteNotFinite(file);
  return file;
}

ImageFile readImage(const std::string& text, const ImageOptions& options) {
  return readImage(parseInput(text), options);
}

std::optional<ImageSlices> openImageSlices(const std::string& text, const ImageOptions& options) {
  return openImageSlices(parseInput(text), options);
}

std::optional<ImageSlices> openImageSlices(const InputSpec& given, const ImageOptions& options) {
  const InputSpec input = stillInput(given);
  if (!input.format || !input.format->openSlices) return std::nullopt;
  std::optional<ImageSlices> slices = input.format->openSlices(input, options);
  if (slices) placeImage(input, options, slices->file);
  return slices;
}

void visitImages(const InputSpec& input, const ImageOptions& options, double mostVoxels,
                 const ImageVisitor& visit) {
  if (input.format && input.format->listImages)
    return input.format->listImages(input, options, mostVoxels, visit);
  ImageFile file = readImage(input, options);
  file.name = input.text;
  visit(std::move(file));
}

std::vector<ImageFile> listImages(const InputSpec& input, const ImageOptions& options) {
  std::vector<ImageFile> files;
  visitImages(input, options, std::numeric_limits<double>::infinity(),
              [&](ImageFile file) { files.push_back(std::move(file)); });
  return files;
}

}  // namespace slicemorph
