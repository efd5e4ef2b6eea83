#include "io/mesh/assimp_scene.h"
#include "io/mesh/obj_materials.h"
#include "io/mesh/obj_scan.h"

#include <algorithm>

namespace slicemorph {

StoredMesh readObj(const std::string& path, std::string_view bytes) {
  const ObjCounts counts = scanObj(path, bytes);
  const MaterialColors materials = readMaterialColors(path, counts.materialFiles);
  StoredMesh stored = importScene(path, &materials);
  stored.points = counts.points, stored.faces = counts.faces;
  stored.endsInLine = counts.endsInLine;
  const size_t used = counts.points - counts.unusedPoints, imported = stored.mesh.points.size();
  stored.mesh.importCopies = imported - std::min(used, imported);
  stored.mesh.importDropped = counts.unusedPoints;
  return stored;
}

}  // namespace slicemorph
