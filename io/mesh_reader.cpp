#include "io/mesh_reader.h"

#include "engine/errors.h"
#include "io/mesh_checks.h"
#include "io/paths.h"

#include <assimp/Importer.hpp>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace slicemorph {
namespace {

/// Adds a mesh of the scene, moved to world space.
void appendMesh(const aiMesh& part, const aiMatrix4x4& toWorld, const std::string& path, StoredMesh& stored) {
  PolygonMesh& mesh = stored.mesh;
  const size_t first = mesh.points.size();
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D p = toWorld * part.mVertices[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      std::ostringstream why;
      why << path << ": point " << first + i + 1 << " is not finite (" << p.x << ", " << p.y << ", " << p.z << ")";
      throw IoError(why.str());
    }
    mesh.points.emplace_back(p.x, p.y, p.z);
  }
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices < 3) {
      ++stored.skipped;
      continue;
    }
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= part.mNumVertices) {
        throw IoError(path + ": face " + std::to_string(f + 1) + " refers to point " +
                      std::to_string(face.mIndices[k] + std::uint64_t(1)) + ", the mesh has " +
                      std::to_string(part.mNumVertices));
      }
      mesh.corners.push_back(std::uint32_t(first + face.mIndices[k]));
    }
    mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
  }
}

/// Walks the nodes without recursion: a hostile file may nest them deeply.
void appendScene(const aiScene& scene, const std::string& path, StoredMesh& stored) {
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene.mRootNode, scene.mRootNode->mTransformation}};
  while (!open.empty()) {
    const auto [node, toWorld] = open.back();
    open.pop_back();
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
      appendMesh(*scene.mMeshes[node->mMeshes[i]], toWorld, path, stored);
    }
    for (unsigned i = node->mNumChildren; i-- > 0;) {
      open.emplace_back(node->mChildren[i], toWorld * node->mChildren[i]->mTransformation);
    }
  }
}

void import(const std::string& path, StoredMesh& stored) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode) throw IoError(path + " cannot be read: " + importer.GetErrorString());
  appendScene(*scene, path, stored);
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
    import(path, stored);
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(path + " cannot be read: " + error.what());
  }
  const bool counted = counts.points > 0;
  stored.points = counted ? counts.points : stored.mesh.points.size();
  stored.faces = counted ? counts.faces : stored.mesh.faceCount();
  const std::string extension = extensionOf(path);
  if (extension == ".stl") stored.mesh.importCopies = stored.mesh.points.size();  // the format has no shared points
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
  if (stored.endsInLine && result.found.boundaryLoops > 0) {
    throw IoError(path + " seems truncated: its last line has no end and its surface has " +
                  std::to_string(result.found.boundaryLoops) +
                  " holes; if it is whole, end it with a newline and the holes are filled");
  }
  return result;
}

}  // namespace slicemorph
