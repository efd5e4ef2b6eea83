#include "io/mesh/gltf_materials.h"

#include "io/mesh/glb_accessor.h"

#include <cmath>

namespace slicemorph {
namespace {

using tinygltf::Value;

/// A member of an object, or null.
const Value* memberOf(const Value& object, const char* key) {
  return object.IsObject() && object.Has(key) ? &object.Get(key) : nullptr;
}

double numberOf(const Value* value, double otherwise) {
  return value && value->IsNumber() ? value->GetNumberAsDouble() : otherwise;
}

double numberOf(const Value* list, size_t index, double otherwise) {
  return list && list->IsArray() && index < list->ArrayLen() ? numberOf(&list->Get(int(index)), otherwise)
                                                             : otherwise;
}

/// KHR_texture_transform turns coordinates anticlockwise as seen on the picture, whose v goes down. `extensions`: of the
/// reference to a texture.
void applyTransform(const tinygltf::ExtensionMap& extensions, GltfPaint& paint, int& set) {
  const auto found = extensions.find("KHR_texture_transform");
  if (found == extensions.end()) return;
  const Value *offset = memberOf(found->second, "offset"), *scale = memberOf(found->second, "scale");
  const double turn = numberOf(memberOf(found->second, "rotation"), 0), c = std::cos(turn),
               s = std::sin(turn);
  const double a = numberOf(scale, 0, 1), b = numberOf(scale, 1, 1);
  paint.toPicture = Mat3d(c * a, s * b, numberOf(offset, 0, 0),   //
                          -s * a, c * b, numberOf(offset, 1, 0),  //
                          0.0, 0.0, 1.0);
  set = int(numberOf(memberOf(found->second, "texCoord"), set));
}

TextureWrap wrapOf(int code) {
  return code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? TextureWrap::kClamp
         : code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? TextureWrap::kMirror
                                                         : TextureWrap::kRepeat;
}

}  // namespace

GltfPaint GltfMaterials::paintOf(int index) const {
  GltfPaint paint;
  if (index < 0 || size_t(index) >= file_.model.materials.size()) return paint;
  const tinygltf::Material& material = file_.model.materials[size_t(index)];
  const auto& pbr = material.pbrMetallicRoughness;
  openvdb::Vec3s color(1.f);
  for (int i = 0; i < 3 && pbr.baseColorFactor.size() >= 3; ++i)
    color[i] = float(pbr.baseColorFactor[size_t(i)]);
  int texture = pbr.baseColorTexture.index, set = pbr.baseColorTexture.texCoord;
  const tinygltf::ExtensionMap* extensions = &pbr.baseColorTexture.extensions;
  tinygltf::ExtensionMap ofDiffuse;
  if (const auto glossy = material.extensions.find("KHR_materials_pbrSpecularGlossiness");
      glossy != material.extensions.end() && glossy->second.IsObject()) {
    for (int i = 0; i < 3; ++i)
      color[i] = float(numberOf(memberOf(glossy->second, "diffuseFactor"), size_t(i), 1));
    texture = -1, set = 0, extensions = &ofDiffuse;
    if (const Value* diffuse = memberOf(glossy->second, "diffuseTexture")) {
      texture = int(numberOf(memberOf(*diffuse, "index"), -1)),
      set = int(numberOf(memberOf(*diffuse, "texCoord"), 0));
      const Value* inner = memberOf(*diffuse, "extensions");
      const Value* transform = inner ? memberOf(*inner, "KHR_texture_transform") : nullptr;
      if (transform) ofDiffuse["KHR_texture_transform"] = *transform;
    }
  }
  // The material "clay" of our own files (glb_writer.cpp) only says how to show a mesh without colours.
  if (color != openvdb::Vec3s(1.f) && material.name != "clay") paint.color = color;
  if (texture < 0) return paint;
  applyTransform(*extensions, paint, set);
  paint.texture = texture;
  paint.coordinates = "TEXCOORD_" + std::to_string(set);
  return paint;
}

int GltfMaterials::textureOf(int index) {
  const tinygltf::Model& model = file_.model;
  if (size_t(index) >= model.textures.size())
    throw GltfDamage("it refers to texture " + std::to_string(index) + ", it has " +
                     std::to_string(model.textures.size()));
  const tinygltf::Texture& texture = model.textures[size_t(index)];
  const size_t image = size_t(texture.source);
  const bool there = texture.source >= 0 && image < file_.images.size();
  const std::string uri = there ? file_.images[image].uri : "";
  const bool named = !uri.empty() && uri.rfind("data:", 0) != 0;
  TextureSampling sampling;
  if (texture.sampler >= 0 && size_t(texture.sampler) < model.samplers.size()) {
    const tinygltf::Sampler& sampler = model.samplers[size_t(texture.sampler)];
    sampling = {wrapOf(sampler.wrapS), wrapOf(sampler.wrapT),
                sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST};
  }
  return textures_.indexOf(std::to_string(index) + (named ? " (" + uri + ")" : ""), [&] {
    if (!there)
      throw PictureProblem(texture.extensions.empty()
                               ? "it has no picture"
                               : "its picture needs " + texture.extensions.begin()->first);
    const GltfImage& from = file_.images[image];
    if (from.bufferView >= 0) return textureOfPicture(bytesOfGltfView(model, from.bufferView), sampling);
    return textureOfPicture(bytesOfUri(path_, from.uri), sampling);
  });
}

}  // namespace slicemorph
