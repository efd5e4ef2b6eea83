#include "io/image/image_file.h"

#include "io/image/itk_library.h"
#include "io/image/nifti_reader.h"
#include "io/image/stack_reader.h"
#include "io/mesh/mesh_reader.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace slicemorph {
namespace {

enum class Format { kNone, kNifti, kNrrd, kMetaImage, kDicom, kStack };

Format formatOf(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".nii" ||
      (extension == ".gz" && extensionOf(std::filesystem::path(path).stem().string()) == ".nii"))
    return Format::kNifti;
  if (extension == ".nrrd" || extension == ".nhdr") return Format::kNrrd;
  if (extension == ".mha" || extension == ".mhd") return Format::kMetaImage;
  std::error_code ignored;
  // A folder whose name says it is a shape is a mistake, not a series.
  if (extension == ".vdb" || isMeshExtension(extension)) return Format::kNone;
  if (extension == ".dcm" || std::filesystem::is_directory(path, ignored)) return Format::kDicom;
  if (extension == ".tif" || extension == ".tiff") return Format::kStack;
  if ((extension == ".png" || extension == ".exr") && isSequenceInput(path)) return Format::kStack;
  return Format::kNone;
}

int volumeOf(const InputName& name) {
  if (name.grid.empty()) return 0;
  const bool digits =
      std::all_of(name.grid.begin(), name.grid.end(), [](unsigned char c) { return std::isdigit(c); });
  if (!digits || name.grid.size() > 9)
    throw InputError(name.path + ":" + name.grid + ": '" + name.grid +
                     "' is no volume of the file; give its number, from 0");
  return std::stoi(name.grid);
}

void noteVolumes(const InputName& name, ImageFile& file) {
  if (file.volumes > 1 && name.grid.empty())
    file.notes.push_back("took volume 0 of " + std::to_string(file.volumes) + " (" + name.path +
                         ":N takes another)");
}

std::vector<ImageFile> listSeries(const InputName& name) {
  std::error_code ignored;
  if (!name.grid.empty() || !std::filesystem::is_directory(name.path, ignored)) {
    Notes notes;
    ImageFile file =
        itkReaders().dicomSeries(name.path, itkReaders().chooseSeries(name.path, name.grid, notes));
    file.name = name.path + (name.grid.empty() ? "" : ":" + name.grid);
    file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
    return {std::move(file)};
  }
  const DicomFolder folder = itkReaders().dicomFolder(name.path);
  std::vector<ImageFile> files;
  for (size_t i = 0; i < folder.series.size(); ++i) {
    files.push_back(itkReaders().dicomSeries(name.path, folder.series[i]));
    files.back().name = name.path + ":" + std::to_string(i + 1);
    if (i == 0) files[0].notes.insert(files[0].notes.begin(), folder.notes.begin(), folder.notes.end());
  }
  return files;
}

}  // namespace

bool isImageInput(const std::string& input) {
  const Format format = formatOf(splitImageInput(input).path);
  return format != Format::kNone;
}

InputName splitImageInput(const std::string& input) {
  std::error_code ignored;
  const size_t colon = input.rfind(':');
  if (std::filesystem::exists(input, ignored) || colon == std::string::npos || colon == 0) return {input, ""};
  const std::string path = input.substr(0, colon);
  if (formatOf(path) == Format::kNone) return {input, ""};
  if (colon + 1 == input.size()) throw InputError(input + ": nothing is named after the colon");
  return {path, input.substr(colon + 1)};
}

ImageFile readImage(const std::string& input, const ImageOptions& options) {
  const InputName name = splitImageInput(input);
  ImageFile file;
  switch (formatOf(name.path)) {
    case Format::kNifti:
      file = readNifti(name.path, volumeOf(name));
      break;
    case Format::kNrrd:
      file = itkReaders().nrrd(name.path, volumeOf(name));
      break;
    case Format::kMetaImage:
      file = itkReaders().metaImage(name.path, volumeOf(name));
      break;
    case Format::kDicom: {
      Notes notes;
      const DicomSeries series = itkReaders().chooseSeries(name.path, name.grid, notes);
      file = itkReaders().dicomSeries(name.path, series);
      file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
      break;
    }
    case Format::kStack:
      file = readStack(name.path, options);
      break;
    case Format::kNone:
      throw InputError(
          input +
          " is no image; use .nii .nii.gz .nrrd .nhdr .mha .mhd, a DICOM folder or name.####.tif|png|exr");
  }
  noteVolumes(name, file);
  return file;
}

std::vector<ImageFile> listImages(const std::string& input, const ImageOptions& options) {
  const InputName name = splitImageInput(input);
  const Format format = formatOf(name.path);
  if (format == Format::kDicom) return listSeries(name);
  const bool withoutSpacing = format == Format::kStack && options.spacing[0] == 0;
  ImageFile file = withoutSpacing ? readStack(name.path, options, false) : readImage(input, options);
  file.name = input;
  return {std::move(file)};
}

}  // namespace slicemorph
