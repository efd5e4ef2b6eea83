#include "io/mesh/gltf_vertices.h"

#include "io/mesh/gltf_draco.h"

#include <tiny_gltf.h>

#include <algorithm>

namespace slicemorph {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

int integerOf(const tinygltf::Value& object, const std::string& key) {
  if (!object.IsObject() || !object.Has(key) || !object.Get(key).IsNumber())
    throw GltfDamage(std::string(kDraco) + " has no '" + key + "'");
  return object.Get(key).GetNumberAsInt();
}

/// What a primitive packs with Draco; null: it does not.
std::shared_ptr<const DracoMesh> dracoOf(const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
  const auto found = primitive.extensions.find(kDraco);
  if (found == primitive.extensions.end()) return nullptr;
  return std::make_shared<const DracoMesh>(
      unpackDraco(bytesOfGltfView(model, integerOf(found->second, "bufferView"))));
}

/// The number by which Draco knows an attribute; below 0: it does not have it.
int dracoNumberOf(const tinygltf::Primitive& primitive, const std::string& attribute) {
  const tinygltf::Value& extension = primitive.extensions.at(kDraco);
  if (!extension.Has("attributes") || !extension.Get("attributes").Has(attribute)) return -1;
  return integerOf(extension.Get("attributes"), attribute);
}

}  // namespace

GltfVertices::GltfVertices(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                           const std::vector<double>& weights)
    : model_(model), primitive_(primitive), weights_(weights), draco_(dracoOf(model, primitive)) {
  weights_.resize(std::min(weights_.size(), primitive.targets.size()));
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return;
  count_ = countOfGltf(model, position->second);
  if (draco_ && draco_->points != count_)
    throw GltfDamage("Draco packs " + std::to_string(draco_->points) + " points of a mesh of " +
                     std::to_string(count_));
  for (size_t t = 0; t < weights_.size(); ++t)
    morphed_ |= weights_[t] != 0 && primitive.targets[t].count("POSITION") > 0;
}

bool GltfVertices::has(const std::string& attribute) const {
  return primitive_.attributes.count(attribute) > 0;
}

size_t GltfVertices::countOf(const std::string& attribute) const {
  return countOfGltf(model_, primitive_.attributes.at(attribute));
}

GltfVectors GltfVertices::read(const std::string& attribute, int width, bool normalise) const {
  const int accessor = primitive_.attributes.at(attribute);
  const int packed = draco_ ? dracoNumberOf(primitive_, attribute) : -1;
  GltfVectors vectors;
  if (packed >= 0) {
    const auto found = draco_->attributes.find(packed);
    if (found == draco_->attributes.end() || found->second.vectors.width < width)
      throw GltfDamage("Draco packs no " + attribute + " that fits");
    vectors = found->second.vectors;
    normalise |= model_.accessors.at(size_t(accessor)).normalized;
    if (normalise && found->second.most > 0)
      for (float& value : vectors.values) value = std::max(value / float(found->second.most), -1.f);
  } else {
    vectors = readGltfVectors(model_, accessor, count_, width, normalise);
  }
  for (size_t t = 0; t < weights_.size(); ++t) {
    const auto target = primitive_.targets[t].find(attribute);
    if (weights_[t] == 0 || target == primitive_.targets[t].end()) continue;
    const GltfVectors moves = readGltfVectors(model_, target->second, count_, width, normalise);
    for (size_t i = 0; i < count_; ++i)
      for (size_t c = 0; c < size_t(std::min(moves.width, vectors.width)); ++c)
        vectors.values[i * size_t(vectors.width) + c] += float(weights_[t]) * moves.at(i)[c];
  }
  return vectors;
}

std::vector<std::uint32_t> GltfVertices::corners() const {
  if (draco_) return draco_->corners;
  if (primitive_.indices >= 0) return readGltfIndices(model_, primitive_.indices);
  std::vector<std::uint32_t> corners(count_);
  for (size_t i = 0; i < count_; ++i) corners[i] = std::uint32_t(i);
  return corners;
}

}  // namespace slicemorph
