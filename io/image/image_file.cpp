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

#include <cmath>
#include <filesystem>

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

/// The DICOM series that is selected, or the only one.
ImageFile readOneSeries(const InputSpec& input, const ImageOptions& options) {
  Notes notes;
  const DicomSeries series = itkReaders().chooseSeries(input.path, input.selection, notes);
  ImageFile file = itkReaders().dicomSeries(input.path, series, checkOf(input, options));
  file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
  return file;
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

bool isDicomImage(const std::string& path) { return extensionOf(path) == ".dcm" || isFolder(path); }

bool isImageStack(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".tif" || extension == ".tiff") return true;
  return (extension == ".png" || extension == ".exr") && isNumbered(path);
}

ImageFile readNiftiImage(const InputSpec& input, const ImageOptions& options) {
  return readNifti(input.path, volumeOf(input), checkOf(input, options));
}

ImageFile readNrrdImage(const InputSpec& input, const ImageOptions& options) {
  return itkReaders().nrrd(input.path, volumeOf(input), checkOf(input, options));
}

ImageFile readMetaImageFile(const InputSpec& input, const ImageOptions& options) {
  return itkReaders().metaImage(input.path, volumeOf(input), checkOf(input, options));
}

ImageFile readDicomImage(const InputSpec& input, const ImageOptions& options) {
  return readOneSeries(input, options);
}

std::vector<ImageFile> listDicomImages(const InputSpec& input, const ImageOptions& options) {
  if (!input.selection.empty() || !isFolder(input.path)) {
    ImageFile file = readOneSeries(input, options);
    file.name = input.text;
    return {std::move(file)};
  }
  const DicomFolder folder = itkReaders().dicomFolder(input.path);
  std::vector<ImageFile> files;
  for (size_t i = 0; i < folder.series.size(); ++i) {
    files.push_back(itkReaders().dicomSeries(input.path, folder.series[i], checkOf(input, options)));
    files.back().name = input.path + ":" + std::to_string(i + 1);
    if (i == 0) files[0].notes.insert(files[0].notes.begin(), folder.notes.begin(), folder.notes.end());
  }
  return files;
}

ImageFile readStackImage(const InputSpec& input, const ImageOptions& options) {
  return readStack(input, options);
}

std::optional<ImageSlices> openNiftiSlices(const InputSpec& input, const ImageOptions&) {
  return openNifti(input.path, volumeOf(input));
}

std::optional<ImageSlices> openNrrdSlices(const InputSpec& input, const ImageOptions&) {
  return itkReaders().nrrdSlices(input.path, volumeOf(input));
}

std::optional<ImageSlices> openMetaImageSlices(const InputSpec& input, const ImageOptions&) {
  return itkReaders().metaImageSlices(input.path, volumeOf(input));
}

std::optional<ImageSlices> openStackSlices(const InputSpec& input, const ImageOptions& options) {
  return openStack(input, options);
}

std::vector<ImageFile> listStackImages(const InputSpec& input, const ImageOptions& options) {
  ImageFile file = readStack(input, options, /*placed=*/options.spacing[0] != 0);
  file.name = input.text;
  return {std::move(file)};
}

ImageFile readImage(const InputSpec& given, const ImageOptions& options) {
  const InputSpec input = stillInput(given);
  if (!input.format || !input.format->readImage)
    throw InputError(input.text, "is no image; use " + readableList(Contents::kImage));
  ImageFile file = input.format->readImage(input, options);
  place(file.image.lattice, placingOf(input.placing, options.up));
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
  if (slices) place(slices->file.image.lattice, placingOf(input.placing, options.up));
  return slices;
}

std::vector<ImageFile> listImages(const InputSpec& input, const ImageOptions& options) {
  if (input.format && input.format->listImages) return input.format->listImages(input, options);
  ImageFile file = readImage(input, options);
  file.name = input.text;
  return {std::move(file)};
}

}  // namespace slicemorph
