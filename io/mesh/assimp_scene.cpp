#include "io/mesh/assimp_scene.h"

#include "io/mesh/scene_part.h"

#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include <optional>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

/// Colour of points without one, where other points of the file have colours.
const Vec3s kSceneWhite(1.f);

/// Source of a part's colours: its points, else its material, else white.
struct PartColors {
  const aiColor4D* ofPoints = nullptr;
  std::optional<Vec3s> ofMaterial;

  bool any() const { return ofPoints || ofMaterial; }
  Vec3s at(unsigned point) const {
    if (ofPoints) return Vec3s(ofPoints[point].r, ofPoints[point].g, ofPoints[point].b);
    return ofMaterial ? *ofMaterial : kSceneWhite;
  }
};

class SceneReader {
 public:
  SceneReader(const std::string& path, const MaterialColors* materials)
      : path_(path), materials_(materials) {}

  /// Walks the nodes without recursion: a hostile file may nest them deeply.
  StoredMesh read(const aiScene& scene) {
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{
        {scene.mRootNode, scene.mRootNode->mTransformation}};
    while (!open.empty()) {
      const auto [node, toWorld] = open.back();
      open.pop_back();
      for (unsigned i = 0; i < node->mNumMeshes; ++i) addPart(scene, node->mMeshes[i], toWorld);
      for (unsigned i = node->mNumChildren; i-- > 0;)
        open.emplace_back(node->mChildren[i], toWorld * node->mChildren[i]->mTransformation);
    }
    if (stored_.colorsOf.empty()) stored_.mesh.colors.clear();
    return std::move(stored_);
  }

 private:
  void addPart(const aiScene& scene, unsigned index, const aiMatrix4x4& toWorld) {
    const aiMesh& part = *scene.mMeshes[index];
    const aiMaterial* material =
        part.mMaterialIndex < scene.mNumMaterials ? scene.mMaterials[part.mMaterialIndex] : nullptr;
    const size_t first = addPoints(part, toWorld);
    addFaces(part, first, material ? colorsOf(part, *material) : PartColors());
    stored_.textured |= material && material->GetTextureCount(aiTextureType_DIFFUSE) > 0;
  }

  PartColors colorsOf(const aiMesh& part, const aiMaterial& material) const {
    PartColors colors;
    if (!materials_) return colors;
    colors.ofPoints = part.mColors[0];
    if (colors.ofPoints) return colors;
    const auto found = materials_->find(std::string(trimmed(material.GetName().C_Str())));
    if (found != materials_->end()) colors.ofMaterial = found->second;
    return colors;
  }

  /// Adds the part's points, moved to world space. Returns the index of the first.
  size_t addPoints(const aiMesh& part, const aiMatrix4x4& toWorld) {
    std::vector<Vec3s>& points = stored_.mesh.points;
    const size_t first = points.size();
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D p = toWorld * part.mVertices[i];
      points.emplace_back(p.x, p.y, p.z);
      if (!isFinite(points.back()))
        refuseNotFinite(path_, "point " + std::to_string(first + i + 1), points.back());
    }
    return first;
  }

  void addFaces(const aiMesh& part, size_t first, const PartColors& colors) {
    PolygonMesh& mesh = stored_.mesh;
    noteColors(stored_, colors);
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices < 3) {
        ++stored_.skipped;
        continue;
      }
      for (unsigned k = 0; k < face.mNumIndices; ++k)
        addCorner(path_, mesh, {first, part.mNumVertices}, f, face.mIndices[k], colors);
      mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
    }
  }

  const std::string& path_;
  const MaterialColors* materials_;
  StoredMesh stored_;
};

}  // namespace

StoredMesh importScene(const std::string& path, const MaterialColors* materials) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode)
    throw IoError(path, std::string("cannot be read: ") + importer.GetErrorString());
  return SceneReader(path, materials).read(*scene);
}

}  // namespace slicemorph
