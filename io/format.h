#pragma once

#include "slicemorph/io/input_spec.h"

#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

struct StoredMesh;
struct Mesh;
struct Image;
struct ImageFile;
struct ImageOptions;
struct ContourFile;

/// Whether a file or folder is of a format, by its name or by a look into it. It may not exist.
using Recogniser = bool (*)(const std::string& path);
/// `bytes`: the whole file. Checks that it is whole and sound: throws IoError naming `path`.
using MeshReader = StoredMesh (*)(const std::string& path, std::string_view bytes);
/// Whole or not at all. Throws IoError.
using MeshWriter = void (*)(const std::string& path, const Mesh& mesh);
using ImageReader = ImageFile (*)(const InputSpec& input, const ImageOptions& options);
/// For a listing: all that an input without a choice may mean.
using ImageLister = std::vector<ImageFile> (*)(const InputSpec& input, const ImageOptions& options);
using ImageWriter = void (*)(const std::string& path, const Image& image);
using ContourReader = ContourFile (*)(const std::string& path);

/// A format: what is null is not there.
struct Format {
  std::string name;
  Contents contents = Contents::kUnknown;
  std::vector<std::string> reads, writes;  ///< extensions, lower case, with the dot
  std::string help;                        ///< one line
  std::string listed;                      ///< instead of extensions where what can be read is listed
  Recogniser recognise = nullptr;          ///< null: by the extensions in `reads`
  MeshReader readMesh = nullptr;
  MeshWriter writeMesh = nullptr;
  ImageReader readImage = nullptr;
  ImageLister listImages = nullptr;  ///< null: the one that readImage gives
  ImageWriter writeImage = nullptr;
  ContourReader readContours = nullptr;
};

/// The table. The first row that recognises a name has it.
const std::vector<Format>& formats();

/// Null where no format is known by this name.
const Format* formatToRead(const std::string& path);
const Format* formatToWrite(const std::string& path);

/// Throws IoError where there is no such file, else InputError: what has no shape, and what can be read.
[[noreturn]] void refuseAsShape(const InputSpec& input);

}  // namespace slicemorph
