#include "io/mesh/gltf_file.h"

#include "io/mesh/glb_accessor.h"
#include "io/mesh/gltf_meshopt.h"
#include "io/mesh/mesh_text.h"
#include "io/whole_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>

namespace slicemorph {
namespace {

using nlohmann::json;

/// Extensions that are read, and those that change no shape. Files that require another one are refused: they
/// would be read as another shape than they have.
constexpr const char* kRead[] = {"KHR_mesh_quantization",
                                 "KHR_draco_mesh_compression",
                                 "EXT_meshopt_compression",
                                 "EXT_mesh_gpu_instancing",
                                 "KHR_node_visibility",
                                 "KHR_animation_pointer",
                                 "KHR_xmp",
                                 "KHR_xmp_json_ld",
                                 "FB_ngon_encoding",
                                 "EXT_mesh_features",
                                 "EXT_instance_features",
                                 "EXT_structural_metadata"};
/// Beginnings of the names of extensions about materials and light.
constexpr const char* kLooks[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",    "MSFT_texture_",
                                  "KHR_lights_",    "EXT_lights_",  "ADOBE_materials_"};

std::uint32_t wordAt(std::string_view bytes, size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Throws IoError where the file needs what is not read.
void checkNeeds(const std::string& path, const json& gltf) {
  const auto asset = gltf.find("asset");
  if (asset == gltf.end() || !asset->is_object() || !asset->contains("version"))
    refuse(path, "is no glTF file: it has no asset.version");
  const std::string version = asset->at("version").get<std::string>();
  if (version.substr(0, 2) != "2.") refuse(path, "is glTF of version " + version + "; export it as glTF 2.0");
  if (!gltf.contains("extensionsRequired")) return;
  for (const json& entry : gltf.at("extensionsRequired")) {
    const std::string name = entry.get<std::string>();
    const auto begins = [&](const char* start) { return name.rfind(start, 0) == 0; };
    if (std::any_of(std::begin(kLooks), std::end(kLooks), begins)) continue;
    const bool read = std::find(std::begin(kRead), std::end(kRead), name) != std::end(kRead);
    if (!read || (name == kMeshoptExtension && !canReadMeshopt()))
      refuse(path, "needs the glTF extension " + name + ", which is not read; export it without");
  }
}

/// Arrays and objects within each other; exporters take some ten. JSON is written again by recursion, which deep files
/// would let run out of stack.
constexpr int kMostNested = 256;

bool nestsTooDeeply(std::string_view json) {
  int depth = 0;
  bool quoted = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted && c == '\\')
      ++i;
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '[' || c == '{') && ++depth > kMostNested)
      return true;
    else if (!quoted && (c == ']' || c == '}'))
      --depth;
  }
  return false;
}

/// A whole number that is not negative. Throws GltfDamage for anything else.
std::uint64_t wholeOf(const json& object, const char* key, std::uint64_t otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_number_unsigned()) throw GltfDamage(std::string("its '") + key + "' is no whole number");
  return found->get<std::uint64_t>();
}

std::string fromBase64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    static constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const size_t digit = kDigits.find(c);
    if (digit == kDigits.npos) throw GltfDamage("a data URI is no base64");
    bits = bits << 6 | std::uint32_t(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += char(bits >> count & 255);
  }
  return bytes;
}

/// A URI's text with its escapes (%20) replaced.
std::string unescaped(const std::string& uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    unsigned code = 0;
    const char *first = uri.data() + i + 1, *last = first + 2;
    if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(first, last, code, 16).ptr == last) {
      text += char(code);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

/// Puts all data into one buffer, so that every view lies in it.
class BufferJoiner {
 public:
  BufferJoiner(const std::string& path, json& gltf, std::string_view binary)
      : path_(path), gltf_(gltf), binary_(binary) {}

  std::string join() {
    json& views = gltf_["bufferViews"];
    if (views.is_null()) views = json::array();
    for (json& view : views) {
      std::string packed;
      if (const json* meshopt = meshoptOf(view)) {
        packed = unpackMeshopt(*meshopt, bytesIn(*meshopt));
        view.erase("extensions");
      }
      const std::string_view bytes = packed.empty() ? bytesIn(view) : std::string_view(packed);
      joined_.resize((joined_.size() + 7) / 8 * 8, '\0');
      view["buffer"] = 0, view["byteOffset"] = joined_.size(), view["byteLength"] = bytes.size();
      joined_.append(bytes);
      if (joined_.size() > std::numeric_limits<std::uint32_t>::max() / 2)
        refuse(path_, "has more than 2 GiB of data, the most that is read of a mesh");
    }
    joined_.resize(std::max<size_t>(4, (joined_.size() + 3) / 4 * 4), '\0');
    gltf_["buffers"] = {{{"byteLength", joined_.size()}}};
    return std::move(joined_);
  }

 private:
  static const json* meshoptOf(const json& view) {
    const auto extensions = view.find("extensions");
    if (extensions == view.end()) return nullptr;
    const auto found = extensions->find(kMeshoptExtension);
    return found == extensions->end() || !canReadMeshopt() ? nullptr : &*found;
  }

  /// The part of a buffer that a view or a meshopt extension names.
  std::string_view bytesIn(const json& view) {
    const std::uint64_t index = wholeOf(view, "buffer", ~std::uint64_t(0));
    const std::string_view bytes = bufferAt(index);
    const std::uint64_t offset = wholeOf(view, "byteOffset", 0), length = wholeOf(view, "byteLength", 0);
    if (offset > bytes.size() || length > bytes.size() - offset)
      throw GltfDamage("a buffer view reaches beyond its buffer");
    return bytes.substr(offset, length);
  }

  std::string_view bufferAt(std::uint64_t index) {
    const json none = json::array();
    const json& buffers = gltf_.contains("buffers") ? gltf_.at("buffers") : none;
    if (index >= buffers.size())
      throw GltfDamage("it refers to buffer " + std::to_string(index) + ", it has " +
                       std::to_string(buffers.size()));
    buffers_.resize(buffers.size());
    const json& buffer = buffers.at(index);
    const std::uint64_t length = wholeOf(buffer, "byteLength", 0);
    std::string_view bytes = binary_;
    if (buffer.contains("uri")) {
      if (buffers_[index].empty()) buffers_[index] = bytesOfUri(path_, buffer.at("uri").get<std::string>());
      bytes = buffers_[index];
    } else if (index > 0 || !binary_.data()) {
      throw GltfDamage("buffer " + std::to_string(index) + " has no data");
    }
    if (length > bytes.size())
      throw GltfDamage("buffer " + std::to_string(index) + " is to have " + std::to_string(length) +
                       " bytes, there are " + std::to_string(bytes.size()));
    return bytes.substr(0, length);
  }

  const std::string& path_;
  json& gltf_;
  std::string_view binary_;
  std::vector<std::string> buffers_;  ///< that are not in the file's own chunk
  std::string joined_;
};

std::vector<GltfImage> takeImages(json& gltf) {
  std::vector<GltfImage> images;
  if (gltf.contains("images")) {
    for (const json& entry : gltf.at("images")) {
      GltfImage image;
      if (entry.contains("bufferView")) image.bufferView = int(wholeOf(entry, "bufferView", 0));
      if (entry.contains("uri")) image.uri = entry.at("uri").get<std::string>();
      images.push_back(std::move(image));
    }
    gltf.erase("images");
  }
  return images;
}

/// TinyGLTF refuses indices without a buffer view, which Draco's have not: they come from the packed data.
void dropDracoIndices(json& gltf) {
  if (!gltf.contains("meshes")) return;
  for (json& mesh : gltf.at("meshes"))
    for (json& primitive : mesh.at("primitives"))
      if (primitive.contains("extensions") &&
          primitive.at("extensions").contains("KHR_draco_mesh_compression"))
        primitive.erase("indices");
}

tinygltf::Model loadModel(const std::string& path, const std::string& container) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string problem, ignored;
  if (loader.LoadBinaryFromMemory(&model, &problem, &ignored,
                                  reinterpret_cast<const unsigned char*>(container.data()),
                                  unsigned(container.size())))
    return model;
  while (!problem.empty() && isSpace(problem.back())) problem.pop_back();
  refuse(path, "cannot be read as glTF: " + (problem.empty() ? "it is damaged" : problem));
}

}  // namespace

GltfParts gltfPartsOf(const std::string& path, std::string_view bytes) {
  if (bytes.substr(0, 4) != "glTF") return {bytes, {}};
  if (bytes.size() < 20) refuseTruncated(path, "a binary glTF file has at least 20 bytes");
  if (wordAt(bytes, 4) != 2)
    refuse(path, "is binary glTF of version " + std::to_string(wordAt(bytes, 4)) + "; export it as glTF 2.0");
  const std::uint64_t size = wordAt(bytes, 8);
  if (size > bytes.size())
    refuseTruncated(path, "the header says " + std::to_string(size) + " bytes, the file has " +
                              std::to_string(bytes.size()));
  GltfParts parts;
  for (std::uint64_t at = 12; at + 8 <= size; at += 8 + std::uint64_t(wordAt(bytes, at))) {
    const std::uint64_t length = wordAt(bytes, at);
    if (at + 8 + length > size) refuse(path, "is damaged: a chunk reaches beyond the end");
    const std::string_view kind = bytes.substr(at + 4, 4), chunk = bytes.substr(at + 8, length);
    if (kind == "JSON" && parts.json.empty()) parts.json = chunk;
    if (kind == std::string_view("BIN\0", 4) && !parts.binary.data()) parts.binary = chunk;
  }
  return parts;
}

std::string gltfContainer(std::string text, std::string binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const auto word = [](size_t value) {
    const auto number = std::uint32_t(value);
    return std::string(reinterpret_cast<const char*>(&number), sizeof number);
  };
  return "glTF" + word(2) + word(28 + text.size() + binary.size()) + word(text.size()) + "JSON" + text +
         word(binary.size()) + std::string("BIN\0", 4) + binary;
}

std::string bytesOfUri(const std::string& path, const std::string& uri) {
  if (uri.rfind("data:", 0) == 0) {
    const size_t comma = uri.find(',');
    if (comma == uri.npos || uri.find(";base64") > comma) throw GltfDamage("a data URI is no base64");
    return fromBase64(std::string_view(uri).substr(comma + 1));
  }
  return readWholeFile((std::filesystem::path(path).parent_path() / unescaped(uri)).string());
}

GltfFile readGltfFile(const std::string& path, std::string_view bytes) {
  const GltfParts parts = gltfPartsOf(path, bytes);
  std::string memory;
  const std::string_view text = plainText(parts.json, memory);
  if (nestsTooDeeply(text))
    refuse(path, "is damaged: its JSON nests deeper than " + std::to_string(kMostNested) + " levels");
  json gltf = json::parse(text.begin(), text.end(), nullptr, false);
  if (!gltf.is_object()) refuse(path, "cannot be read as glTF: its JSON is damaged or cut short");
  GltfFile file;
  std::string container;
  try {
    checkNeeds(path, gltf);
    file.images = takeImages(gltf);
    dropDracoIndices(gltf);
    const std::string joined = BufferJoiner(path, gltf, parts.binary).join();
    container = gltfContainer(gltf.dump(-1, ' ', false, json::error_handler_t::replace), joined);
  } catch (const json::exception& error) {
    refuse(path, std::string("is damaged: its JSON is no glTF (") + error.what() + ")");
  }
  file.model = loadModel(path, container);
  return file;
}

}  // namespace slicemorph
