#pragma once

#include "io/mesh/mesh_reader.h"
#include "io/mesh/picture_texture.h"

#include <functional>
#include <map>
#include <string>

namespace slicemorph {

/// The textures of one mesh file: each is decoded once, when a face has it; those that cannot be read are told once.
class TextureSet {
 public:
  /// Index among the mesh's textures of that with a name; -1: it cannot be read. `make`: decodes it where it is new;
  /// may throw PictureProblem or IoError.
  int indexOf(const std::string& name, const std::function<std::shared_ptr<const Texture>()>& make);

  /// Puts the textures into the mesh, which has lists of its faces' textures and its corners' coordinates already, and
  /// adds the notes.
  void finish(StoredMesh& stored);

 private:
  std::map<std::string, int> indices_;
  std::vector<std::shared_ptr<const Texture>> textures_;
  Notes notes_;
};

}  // namespace slicemorph
