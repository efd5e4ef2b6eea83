#include "io/mesh/texture_set.h"

#include "slicemorph/errors.h"

namespace slicemorph {

int TextureSet::indexOf(const std::string& name,
                        const std::function<std::shared_ptr<const Texture>()>& make) {
  const auto [entry, isNew] = indices_.emplace(name, -1);
  if (!isNew) return entry->second;
  const auto leaveOut = [&](const std::string& why) {
    notes_.emplace_back("mesh.textures-left-out", Severity::kWarning, "",
                        "its texture '" + name + "' is left out: " + why);
  };
  try {
    textures_.push_back(make());
    entry->second = int(textures_.size()) - 1;
  } catch (const PictureProblem& problem) {
    leaveOut(problem.what());
  } catch (const IoError& error) {
    leaveOut(error.note().text);
  }
  return entry->second;
}

void TextureSet::finish(StoredMesh& stored) {
  PolygonMesh& mesh = stored.mesh;
  stored.notes.insert(stored.notes.end(), notes_.begin(), notes_.end());
  if (textures_.empty()) {
    mesh.textureOfFace.clear(), mesh.uvs.clear();
    return;
  }
  const size_t count = textures_.size();
  mesh.textures = std::move(textures_);
  stored.colorsOf = "textures";
  stored.notes.emplace_back("mesh.textures-read", Severity::kNote, "",
                            "its colours are those of " + std::to_string(count) +
                                (count == 1 ? " texture" : " textures") +
                                ", decoded from sRGB to linear light");
}

}  // namespace slicemorph
