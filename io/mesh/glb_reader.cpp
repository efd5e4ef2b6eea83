#include "io/mesh/glb_accessor.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/scene_part.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

/// Extensions that change where points are. Files that require one of them are refused: they would be read
/// as another shape.
constexpr const char* kNotRead[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                    "EXT_mesh_gpu_instancing"};

std::uint32_t wordAt(std::string_view bytes, size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Checks the sizes that the header and the chunks state before they are used. Throws IoError.
void checkGlb(const std::string& path, std::string_view bytes) {
  if (bytes.size() < 12 || bytes.substr(0, 4) != "glTF") refuse(path, "is no binary glTF file");
  const std::uint64_t size = wordAt(bytes, 8);
  if (size > bytes.size())
    refuseTruncated(path, "the header says " + std::to_string(size) + " bytes, the file has " +
                              std::to_string(bytes.size()));
  for (std::uint64_t at = 12; at + 8 <= size; at += 8 + std::uint64_t(wordAt(bytes, at)))
    if (at + 8 + wordAt(bytes, at) > size) refuse(path, "is damaged: a chunk reaches beyond the end");
}

/// Image loader that decodes nothing, since textures are not read.
bool passOverImage(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*,
                   int, void*) {
  return true;
}

tinygltf::Model loadModel(const std::string& path, std::string_view bytes) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(passOverImage, nullptr);
  tinygltf::Model model;
  std::string problem, ignored;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (loader.LoadBinaryFromMemory(&model, &problem, &ignored,
                                  reinterpret_cast<const unsigned char*>(bytes.data()),
                                  unsigned(bytes.size()), folder))
    return model;
  while (!problem.empty() && isSpace(problem.back())) problem.pop_back();
  refuse(path, "cannot be read as glTF: " + (problem.empty() ? "it is damaged" : problem));
}

/// An affine map of points: linear * p + shift.
struct NodeTransform {
  Mat3d linear = Mat3d::identity();
  Vec3d shift{0, 0, 0};

  Vec3d apply(const Vec3d& p) const { return linear * p + shift; }
  NodeTransform after(const NodeTransform& inner) const {
    return {linear * inner.linear, apply(inner.shift)};
  }
};

/// From a node's space to its parent's. glTF 2.0, section 3.5.3: a column-major matrix, or translation,
/// rotation (a unit quaternion) and scale.
NodeTransform localTransformOf(const tinygltf::Node& node) {
  NodeTransform local;
  if (node.matrix.size() == 16) {
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) local.linear(r, c) = node.matrix[size_t(4 * c + r)];
    local.shift = Vec3d(node.matrix[12], node.matrix[13], node.matrix[14]);
    return local;
  }
  if (node.rotation.size() == 4) {
    const double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
    local.linear = Mat3d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
                         2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),  //
                         2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y));
  }
  if (node.scale.size() == 3)
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) local.linear(r, c) *= node.scale[size_t(c)];
  if (node.translation.size() == 3)
    local.shift = Vec3d(node.translation[0], node.translation[1], node.translation[2]);
  return local;
}

/// Triangles of a primitive, by the indices of their corners; points and lines are only counted.
struct Faces {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  size_t skipped = 0;
};

/// Splits a primitive into triangles. `mode` below 0: not stated, which means triangles (glTF
/// 2.0, section 3.7.2.1).
Faces facesOf(int mode, const std::vector<std::uint32_t>& corners) {
  Faces faces;
  const size_t n = corners.size();
  if (mode == TINYGLTF_MODE_TRIANGLES || mode < 0) {
    for (size_t i = 0; i + 2 < n; i += 3)
      faces.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (size_t i = 0; i + 2 < n; ++i)
      faces.triangles.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    for (size_t i = 1; i + 1 < n; ++i) faces.triangles.push_back({corners[i], corners[i + 1], corners[0]});
  } else if (mode == TINYGLTF_MODE_LINE) {
    faces.skipped = n / 2;
  } else if (mode == TINYGLTF_MODE_LINE_STRIP) {
    faces.skipped = n > 0 ? n - 1 : 0;
  } else {
    faces.skipped = n;
  }
  return faces;
}

/// Colours of a primitive's points, multiplied by its material's base colour.
struct GlbColors {
  std::optional<GltfVectors> ofPoints;
  std::optional<Vec3s> ofMaterial;

  bool any() const { return ofPoints || ofMaterial; }
  Vec3s at(size_t point) const {
    const Vec3s own = ofPoints ? Vec3s(ofPoints->at(point)) : Vec3s(1.f);
    return ofMaterial ? own * *ofMaterial : own;
  }
};

class GlbReader {
 public:
  GlbReader(const std::string& path, const tinygltf::Model& model) : path_(path), model_(model) {}

  /// Walks the nodes without recursion: a hostile file may nest them deeply, or in a circle.
  StoredMesh read() {
    std::vector<std::pair<int, NodeTransform>> open;
    const std::vector<int> roots = rootNodes();
    for (size_t i = roots.size(); i-- > 0;) open.emplace_back(roots[i], NodeTransform());
    std::vector<bool> seen(model_.nodes.size(), false);
    while (!open.empty()) {
      const auto [index, parent] = open.back();
      open.pop_back();
      if (index < 0 || size_t(index) >= seen.size())
        throw GltfDamage("it refers to node " + std::to_string(index) + ", it has " +
                         std::to_string(seen.size()));
      if (seen[size_t(index)]) throw GltfDamage("node " + std::to_string(index) + " has several parents");
      seen[size_t(index)] = true;
      const tinygltf::Node& node = model_.nodes[size_t(index)];
      const NodeTransform toWorld = parent.after(localTransformOf(node));
      if (node.mesh >= 0) addMesh(node, toWorld);
      for (size_t i = node.children.size(); i-- > 0;) open.emplace_back(node.children[i], toWorld);
    }
    if (stored_.colorsOf.empty()) stored_.mesh.colors.clear();
    addNotes();
    return std::move(stored_);
  }

 private:
  /// Root nodes of the default scene; of a file without scenes, all nodes that are no other node's child.
  std::vector<int> rootNodes() const {
    if (!model_.scenes.empty()) {
      const size_t scene = model_.defaultScene >= 0 ? size_t(model_.defaultScene) : 0;
      if (scene >= model_.scenes.size()) throw GltfDamage("the scene that it shows does not exist");
      return model_.scenes[scene].nodes;
    }
    std::vector<bool> child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes)
      for (int c : node.children)
        if (c >= 0 && size_t(c) < child.size()) child[size_t(c)] = true;
    std::vector<int> roots;
    for (size_t i = 0; i < child.size(); ++i)
      if (!child[i]) roots.push_back(int(i));
    return roots;
  }

  void addMesh(const tinygltf::Node& node, const NodeTransform& toWorld) {
    if (size_t(node.mesh) >= model_.meshes.size())
      throw GltfDamage("it refers to mesh " + std::to_string(node.mesh) + ", it has " +
                       std::to_string(model_.meshes.size()));
    const tinygltf::Mesh& mesh = model_.meshes[size_t(node.mesh)];
    const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
    skinned_ |= node.skin >= 0;
    for (const tinygltf::Primitive& primitive : mesh.primitives) addPrimitive(primitive, weights, toWorld);
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                    const NodeTransform& toWorld) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return;  // glTF 2.0: nothing is to be drawn
    const size_t count = countOfGltf(model_, position->second), first = stored_.mesh.points.size();
    if (model_.accessors[size_t(position->second)].bufferView < 0) throw GltfDamage("a mesh has no points");
    addPoints(posed(primitive, position->second, weights, count), toWorld);
    std::vector<std::uint32_t> corners;
    if (primitive.indices >= 0) {
      corners = readGltfIndices(model_, primitive.indices);
    } else {
      for (size_t i = 0; i < count; ++i) corners.push_back(std::uint32_t(i));
    }
    const Faces faces = facesOf(primitive.mode, corners);
    stored_.skipped += faces.skipped;
    addFaces(faces, first, count, colorsOf(primitive, count));
  }

  /// Points in the node's space, with morph targets applied by their default weights.
  GltfVectors posed(const tinygltf::Primitive& primitive, int accessor, const std::vector<double>& weights,
                    size_t count) {
    GltfVectors points = readGltfVectors(model_, accessor, count, 3);
    for (size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t) {
      const auto target = primitive.targets[t].find("POSITION");
      if (weights[t] == 0 || target == primitive.targets[t].end()) continue;
      const GltfVectors moves = readGltfVectors(model_, target->second, count, 3);
      for (size_t i = 0; i < count; ++i)
        for (size_t c = 0; c < 3; ++c)
          points.values[i * size_t(points.width) + c] += float(weights[t]) * moves.at(i)[c];
      posed_ = true;
    }
    return points;
  }

  void addPoints(const GltfVectors& points, const NodeTransform& toWorld) {
    for (size_t i = 0; i < points.count(); ++i) {
      const float* p = points.at(i);
      stored_.mesh.points.emplace_back(toWorld.apply(Vec3d(p[0], p[1], p[2])));
      if (!isFinite(stored_.mesh.points.back()))
        refuseNotFinite(path_, "point " + std::to_string(stored_.mesh.points.size()),
                        stored_.mesh.points.back());
    }
  }

  GlbColors colorsOf(const tinygltf::Primitive& primitive, size_t count) {
    GlbColors colors;
    if (const auto found = primitive.attributes.find("COLOR_0"); found != primitive.attributes.end()) {
      if (const size_t there = countOfGltf(model_, found->second); there != count)
        refuse(path_, "is damaged: a mesh of " + std::to_string(count) + " points has " +
                          std::to_string(there) + " colours");
      colors.ofPoints = readGltfVectors(model_, found->second, count, 3, /*normalise=*/true);
    }
    if (primitive.material < 0 || size_t(primitive.material) >= model_.materials.size()) return colors;
    const tinygltf::Material& material = model_.materials[size_t(primitive.material)];
    const std::vector<double>& base = material.pbrMetallicRoughness.baseColorFactor;
    stored_.textured |= material.pbrMetallicRoughness.baseColorTexture.index >= 0;
    if (base.size() < 3) return colors;
    const Vec3s color{float(base[0]), float(base[1]), float(base[2])};
    // The material "clay" of our own files (glb_writer.cpp) only says how to show a mesh without colours.
    if (color != Vec3s(1.f) && material.name != "clay") colors.ofMaterial = color;
    return colors;
  }

  void addFaces(const Faces& faces, size_t first, size_t count, const GlbColors& colors) {
    PolygonMesh& mesh = stored_.mesh;
    noteColors(stored_, colors);
    for (size_t f = 0; f < faces.triangles.size(); ++f) {
      for (const std::uint32_t point : faces.triangles[f])
        addCorner(path_, mesh, {first, count}, f, point, colors);
      mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
    }
  }

  void addNotes() {
    if (posed_)
      stored_.notes.emplace_back("mesh.morph-targets-applied", Severity::kNote, "",
                                 "its morph targets are applied with their default weights");
    if (skinned_)
      stored_.notes.emplace_back("mesh.skin-left-out", Severity::kNote, "",
                                 "its bones are not applied: the mesh is taken as it was modelled");
    for (const std::string& name : model_.extensionsRequired)
      if (name != "KHR_mesh_quantization" && name.rfind("KHR_materials_", 0) != 0 &&
          name.rfind("KHR_texture_", 0) != 0 && name.rfind("EXT_texture_", 0) != 0)
        stored_.notes.emplace_back("mesh.extension-left-out", Severity::kWarning, "",
                                   "it needs the glTF extension " + name + ", which is not read");
  }

  const std::string& path_;
  const tinygltf::Model& model_;
  StoredMesh stored_;
  bool posed_ = false, skinned_ = false;
};

}  // namespace

StoredMesh readGlb(const std::string& path, std::string_view bytes) {
  checkGlb(path, bytes);
  const tinygltf::Model model = loadModel(path, bytes);
  for (const std::string& name : model.extensionsRequired)
    if (std::find(std::begin(kNotRead), std::end(kNotRead), name) != std::end(kNotRead))
      refuse(path, "needs the glTF extension " + name + ", which is not read; export it without");
  try {
    return GlbReader(path, model).read();
  } catch (const GltfDamage& damage) {
    refuse(path, std::string("is damaged: ") + damage.what());
  }
}

}  // namespace slicemorph
