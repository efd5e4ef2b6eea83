#include "io/mesh/mesh_reader.h"

#include "io/mesh/mesh_checks.h"
#include "io/mesh/mesh_text.h"
#include "io/mesh/obj_materials.h"
#include "io/mesh/ply_reader.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

const Vec3s kWhite(1.f);

[[noreturn]] void refuseNotFinite(const std::string& path, const std::string& what, const Vec3s& v) {
  std::ostringstream why;
  why << path << ": " << what << " is not finite (" << v[0] << ", " << v[1] << ", " << v[2] << ")";
  throw IoError(why.str());
}

bool isFinite(const Vec3s& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

/// What colours a part of a scene.
struct PartColors {
  const aiColor4D* ofPoints = nullptr;
  std::optional<Vec3s> ofMaterial;  ///< multiplies those of points

  bool any() const { return ofPoints || ofMaterial; }
  Vec3s at(unsigned point) const {
    const Vec3s own = ofPoints ? Vec3s(ofPoints[point].r, ofPoints[point].g, ofPoints[point].b) : kWhite;
    return ofMaterial ? own * *ofMaterial : own;
  }
};

/// Takes what assimp has read, part by part.
class SceneReader {
 public:
  /// `diffuse`: of OBJ, colours by the name of the material.
  SceneReader(const std::string& path, const std::map<std::string, Vec3s>& diffuse)
      : path_(path), extension_(extensionOf(path)), diffuse_(diffuse) {}

  /// Walks the nodes without recursion: a hostile file may nest them deeply.
  StoredMesh read(const aiScene& scene) {
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{
        {scene.mRootNode, scene.mRootNode->mTransformation}};
    while (!open.empty()) {
      const auto [node, toWorld] = open.back();
      open.pop_back();
      for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        const aiMesh& part = *scene.mMeshes[node->mMeshes[i]];
        const aiMaterial* material =
            part.mMaterialIndex < scene.mNumMaterials ? scene.mMaterials[part.mMaterialIndex] : nullptr;
        const size_t first = addPoints(part, toWorld);
        addFaces(part, first, material ? colorsOf(part, *material) : PartColors());
        stored_.textured |= material && material->GetTextureCount(aiTextureType_DIFFUSE) > 0;
      }
      for (unsigned i = node->mNumChildren; i-- > 0;) {
        open.emplace_back(node->mChildren[i], toWorld * node->mChildren[i]->mTransformation);
      }
    }
    if (stored_.colorsOf.empty()) stored_.mesh.colors.clear();
    return std::move(stored_);
  }

 private:
  PartColors colorsOf(const aiMesh& part, const aiMaterial& material) const {
    PartColors colors;
    if (extension_ != ".obj" && extension_ != ".glb") return colors;
    colors.ofPoints = part.mColors[0];
    if (extension_ == ".glb") {
      aiColor4D base;
      if (material.Get(AI_MATKEY_BASE_COLOR, base) != AI_SUCCESS) return colors;
      const Vec3s color(base.r, base.g, base.b);
      // Clay is what our own files without colours are shown in.
      if (color != kWhite && material.GetName() != aiString("clay")) colors.ofMaterial = color;
    } else if (!colors.ofPoints) {
      const auto found = diffuse_.find(std::string(trimmed(material.GetName().C_Str())));
      if (found != diffuse_.end()) colors.ofMaterial = found->second;
    }
    return colors;
  }

  /// Moved to world space. Returns the index of the first.
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
    if (colors.any() && stored_.colorsOf != "points")
      stored_.colorsOf = colors.ofPoints ? "points" : "materials";
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices < 3) {
        ++stored_.skipped;
        continue;
      }
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const unsigned point = face.mIndices[k];
        if (point >= part.mNumVertices) {
          throw IoError(path_ + ": face " + std::to_string(f + 1) + " refers to point " +
                        std::to_string(point + std::uint64_t(1)) + ", the mesh has " +
                        std::to_string(part.mNumVertices));
        }
        mesh.corners.push_back(std::uint32_t(first + point));
        mesh.colors.push_back(colors.at(point));
        if (!isFinite(mesh.colors.back()))
          refuseNotFinite(path_, "the colour of point " + std::to_string(first + point + 1),
                          mesh.colors.back());
      }
      mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
    }
  }

  const std::string& path_;
  const std::string extension_;
  const std::map<std::string, Vec3s>& diffuse_;
  StoredMesh stored_;
};

StoredMesh import(const std::string& path, const std::map<std::string, Vec3s>& diffuse) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode) throw IoError(path + " cannot be read: " + importer.GetErrorString());
  return SceneReader(path, diffuse).read(*scene);
}

}  // namespace

bool isMeshExtension(const std::string& extension) {
  return extension == ".obj" || extension == ".ply" || extension == ".stl" || extension == ".off" ||
         extension == ".glb";
}

StoredMesh readPolygons(const std::string& path) {
  const MeshCounts counts = checkMeshFile(path);
  StoredMesh stored;
  try {
    stored = extensionOf(path) == ".ply" ? readPly(path)
                                         : import(path, readMaterialColors(path, counts.materialFiles));
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(path + " cannot be read: " + error.what());
  }
  const bool counted = counts.points > 0;
  stored.points = counted ? counts.points : stored.mesh.points.size();
  stored.faces = counted ? counts.faces : stored.mesh.faceCount();
  const std::string extension = extensionOf(path);
  if (extension == ".stl")
    stored.mesh.importCopies = stored.mesh.points.size();  // the format has no shared points
  if (extension == ".obj") {
    const size_t used = counts.points - counts.unusedPoints, imported = stored.mesh.points.size();
    stored.mesh.importCopies = imported - std::min(used, imported);
    stored.mesh.importDropped = counts.unusedPoints;
  }
  stored.endsInLine = counts.endsInLine;
  return stored;
}

RepairedMesh closeSurface(const std::string& path, const StoredMesh& stored) {
  const std::string hint = stored.endsInLine ? "; the file's last line has no end: is it cut short?" : "";
  RepairedMesh result;
  try {
    result = repairMesh(stored.mesh);
  } catch (const GeometryError& error) {
    throw GeometryError(path + ": " + error.what() + hint);
  }
  if (stored.textured) result.notes.insert(result.notes.begin(), "its textures are not read");
  if (stored.endsInLine && result.found.boundaryLoops > 0) {
    throw IoError(path + " seems truncated: its last line has no end and its surface has " +
                  std::to_string(result.found.boundaryLoops) +
                  " holes; if it is whole, end it with a newline and the holes are filled");
  }
  return result;
}

}  // namespace slicemorph
