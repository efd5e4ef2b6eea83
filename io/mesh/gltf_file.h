#pragma once

#include <tiny_gltf.h>

#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

/// A picture of a glTF file, not yet decoded.
struct GltfImage {
  int bufferView = -1;  ///< where its bytes are; below 0: `uri` names them
  std::string uri;      ///< a file beside the glTF file, or the bytes themselves (data:)
};

/// A glTF 2.0 file with all its data in memory: buffers of files and data URIs are read, and what
/// EXT_meshopt_compression packs is unpacked.
struct GltfFile {
  tinygltf::Model model;  ///< has one buffer; no images
  std::vector<GltfImage> images;
};

/// Reads a file of either container: binary (.glb) or text (.gltf), whose buffers may be files in its folder.
/// Throws IoError where it is cut short or damaged, of another version, or needs an extension that is not read.
GltfFile readGltfFile(const std::string& path, std::string_view bytes);

/// The text and the binary chunk of a file; of .gltf the whole text. Throws IoError where chunks do not fit the file.
struct GltfParts {
  std::string_view json, binary;
};
GltfParts gltfPartsOf(const std::string& path, std::string_view bytes);

/// A .glb of a text and a binary chunk.
std::string gltfContainer(std::string text, std::string binary);

/// The bytes that a URI means: those of a data URI, or those of a file in the folder of `path`, whose name may
/// have escapes (%20). Throws GltfDamage or IoError.
std::string bytesOfUri(const std::string& path, const std::string& uri);

}  // namespace slicemorph
