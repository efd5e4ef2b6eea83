#include "io/points/gltf_positions.h"

#include "io/mesh/glb_accessor.h"
#include "io/mesh/gltf_file.h"
#include "slicemorph/errors.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

/// Throws InputError where the points of a primitive, as a node shows it, are not a plain list of places.
void checkPlain(const std::string& path, const tinygltf::Model& model, const PlacedNode& placed,
                const tinygltf::Primitive& primitive) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(path, "its points cannot be replaced: " + why + "; export it with plain points");
  };
  if (!placed.joints.empty()) refuse("a skin moves them");
  if (placed.places.size() != 1) refuse("EXT_mesh_gpu_instancing shows them several times");
  if (!primitive.targets.empty()) refuse("morph targets move them");
  if (!primitive.extensions.empty()) refuse("they are packed by " + primitive.extensions.begin()->first);
  const int index = primitive.attributes.at("POSITION");
  countOfGltf(model, index);
  const tinygltf::Accessor& accessor = model.accessors[size_t(index)];
  if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT || accessor.type != TINYGLTF_TYPE_VEC3)
    refuse("they are quantised");
  if (accessor.sparse.isSparse || accessor.bufferView < 0) refuse("they are sparse");
  if (std::abs(placed.places[0].linear.det()) < 1e-30) refuse("a node's scale is 0");
}

/// Bytes from one point to the next; 0 in a file means that nothing lies between them, as where it says none.
size_t strideOf(const Json& view) {
  const auto stated = view.value("byteStride", size_t(0));
  return stated == 0 ? 3 * sizeof(float) : stated;
}

}  // namespace

GltfPositions::GltfPositions(const std::string& path, std::string_view bytes) {
  try {
    const GltfFile file = readGltfFile(path, bytes);
    const GltfParts parts = gltfPartsOf(path, bytes);
    json_ = parts.json, binary_ = parts.binary;
    const Json gltf = Json::parse(json_);
    const tinygltf::Model& model = file.model;
    std::vector<bool> taken(model.accessors.size(), false);
    for (const PlacedNode& placed : placedNodes(model)) {
      const size_t mesh = size_t(model.nodes[size_t(placed.node)].mesh);
      if (mesh >= model.meshes.size()) throw GltfDamage("it refers to mesh " + std::to_string(mesh));
      for (const tinygltf::Primitive& primitive : model.meshes[mesh].primitives) {
        if (primitive.attributes.count("POSITION") == 0) continue;
        normals_ |= primitive.attributes.count("NORMAL") > 0;
        checkPlain(path, model, placed, primitive);
        const int index = primitive.attributes.at("POSITION");
        const bool same = !parts_.empty() && parts_.back().accessor == index && taken[size_t(index)];
        if (same && &primitive != &model.meshes[mesh].primitives.front())
          continue;  // one list for several materials
        if (taken[size_t(index)])
          throw InputError(path,
                           "its points cannot be replaced: a mesh is shown several times; export it once");
        taken[size_t(index)] = true;
        const tinygltf::Accessor& accessor = model.accessors[size_t(index)];
        const Json& view = gltf.at("bufferViews").at(size_t(accessor.bufferView));
        const Json& buffer = gltf.at("buffers").at(view.at("buffer").get<size_t>());
        if (view.contains("extensions") || buffer.contains("uri"))
          throw InputError(path, "its points cannot be replaced: they are packed or not in the file itself");
        const GltfVectors points = readGltfVectors(model, index, accessor.count, 3);
        Part part{index, accessor.count, view.value("byteOffset", size_t(0)) + accessor.byteOffset,
                  strideOf(view), placed.places[0]};
        for (size_t i = 0; i < part.count; ++i)
          positions_.push_back(part.toWorld.apply(Vec3d(openvdb::Vec3s(points.at(i)))));
        parts_.push_back(part);
      }
    }
  } catch (const GltfDamage& damage) {
    throw IoError(path, std::string("is damaged: ") + damage.what());
  } catch (const Json::exception& error) {
    throw IoError(path, std::string("is damaged: its JSON is no glTF (") + error.what() + ")");
  }
}

std::string GltfPositions::with(const std::vector<Vec3d>& positions) const {
  Json gltf = Json::parse(json_);
  std::string binary = binary_;
  size_t next = 0;
  for (const Part& part : parts_) {
    const Mat3d toNode = part.toWorld.linear.inverse(0.0);
    openvdb::Vec3s low(0.f), high(0.f);
    for (size_t i = 0; i < part.count; ++i) {
      const openvdb::Vec3s point(toNode * (positions.at(next++) - part.toWorld.shift));
      low = i == 0 ? point : openvdb::math::minComponent(low, point);
      high = i == 0 ? point : openvdb::math::maxComponent(high, point);
      std::memcpy(&binary[part.first + i * part.stride], point.asPointer(), 12);
    }
    Json& accessor = gltf.at("accessors").at(size_t(part.accessor));
    accessor["min"] = {low[0], low[1], low[2]}, accessor["max"] = {high[0], high[1], high[2]};
  }
  return gltfContainer(gltf.dump(-1, ' ', false, Json::error_handler_t::replace), binary);
}

}  // namespace slicemorph
