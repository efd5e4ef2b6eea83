#pragma once

#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_writer.h"

#include <string>
#include <vector>

/// Functions of image formats, for the table of formats (io/formats.cpp).
namespace slicemorph {

/// A .dcm file, or a folder.
bool isDicomImage(const std::string& path);
/// A .tif, or a numbered sequence of .png or .exr.
bool isImageStack(const std::string& path);

/// As readImage.
ImageFile readNiftiImage(const InputSpec& input, const ImageOptions& options);
ImageFile readNrrdImage(const InputSpec& input, const ImageOptions& options);
ImageFile readMetaImageFile(const InputSpec& input, const ImageOptions& options);
ImageFile readDicomImage(const InputSpec& input, const ImageOptions& options);
ImageFile readStackImage(const InputSpec& input, const ImageOptions& options);
/// As listImages.
std::vector<ImageFile> listDicomImages(const InputSpec& input, const ImageOptions& options);
std::vector<ImageFile> listStackImages(const InputSpec& input, const ImageOptions& options);

/// As writeImage.
void writeNifti(const std::string& path, const Image& image);
void writeNrrd(const std::string& path, const Image& image);
void writeMetaImage(const std::string& path, const Image& image);
/// As writeVectors.
void writeNiftiVectors(const std::string& path, const VectorImage& image);
void writeNrrdVectors(const std::string& path, const VectorImage& image);
void writeMetaImageVectors(const std::string& path, const VectorImage& image);

}  // namespace slicemorph
