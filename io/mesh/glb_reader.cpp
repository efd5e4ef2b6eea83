#include "io/mesh/gltf_file.h"
#include "io/mesh/gltf_materials.h"
#include "io/mesh/gltf_nodes.h"
#include "io/mesh/gltf_vertices.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/mesh_text.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <optional>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

/// More corners than the largest files of other formats hold; copies of a mesh (instances) could make any number.
constexpr size_t kMostCorners = size_t(1) << 28;

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

/// Colours of a primitive's points, multiplied by its material's colour and picture.
struct GlbColors {
  std::optional<GltfVectors> ofPoints;
  std::optional<GltfVectors> uvs;  ///< of the picture, two numbers a point; none: no picture
  GltfPaint paint;
  int texture = -1;  ///< index among the mesh's

  bool any() const { return ofPoints || paint.color || uvs; }
  Vec3s at(size_t point) const {
    const Vec3s own = ofPoints ? Vec3s(ofPoints->at(point)) : Vec3s(1.f);
    return paint.color ? own * *paint.color : own;
  }
  openvdb::Vec2s uvAt(size_t point) const {
    if (!uvs) return openvdb::Vec2s(0.f);
    const Vec3d uv = paint.toPicture * Vec3d(uvs->at(point)[0], uvs->at(point)[1], 1);
    return openvdb::Vec2s(float(uv[0]), float(uv[1]));
  }
};

/// Where one primitive's points lie among those of all.
struct ScenePart {
  size_t first = 0;   ///< index of its first point
  size_t points = 0;  ///< how many it has
};

/// Maps the points of a skin: each is moved by the mean of its joints' transforms by its weights (glTF 2.0,
/// section 3.7.3.3).
class Skinning {
 public:
  Skinning(const GltfVertices& vertices, const std::vector<NodeTransform>& joints) : joints_(joints) {
    for (int set = 0;; ++set) {
      const std::string number = std::to_string(set);
      if (!vertices.has("JOINTS_" + number) || !vertices.has("WEIGHTS_" + number)) break;
      indices_.push_back(vertices.read("JOINTS_" + number, 4));
      weights_.push_back(vertices.read("WEIGHTS_" + number, 4, /*normalise=*/true));
    }
  }

  bool any() const { return !indices_.empty(); }

  /// Weights are divided by their sum; where that is 0 the first joint has all, as viewers do.
  NodeTransform at(size_t point) const {
    NodeTransform sum;
    sum.linear = Mat3d::zero();
    double total = 0;
    for (size_t set = 0; set < indices_.size(); ++set)
      for (int c = 0; c < 4; ++c) total += add(sum, point, set, c);
    if (!(total > 0)) return joints_.front();
    sum.linear *= 1 / total, sum.shift /= total;
    return sum;
  }

 private:
  double add(NodeTransform& sum, size_t point, size_t set, int c) const {
    const double weight = double(weights_[set].at(point)[c]);
    if (weight == 0) return 0;
    const float joint = indices_[set].at(point)[c];
    if (!(joint >= 0 && double(joint) < double(joints_.size()))) {
      std::ostringstream why;
      why << "a point hangs on joint " << joint << ", its skin has " << joints_.size();
      throw GltfDamage(why.str());
    }
    const NodeTransform& of = joints_[size_t(joint)];
    sum.linear += of.linear * weight, sum.shift += of.shift * weight;
    return weight;
  }

  const std::vector<NodeTransform>& joints_;
  std::vector<GltfVectors> indices_, weights_;
};

class GlbReader {
 public:
  GlbReader(const std::string& path, const GltfFile& file)
      : path_(path), model_(file.model), materials_(path, file) {}

  StoredMesh read() {
    for (const PlacedNode& placed : placedNodes(model_)) addMesh(placed);
    addNotes();
    materials_.finish(stored_);
    if (stored_.colorsOf.empty()) stored_.mesh.colors.clear();
    return std::move(stored_);
  }

 private:
  void addMesh(const PlacedNode& placed) {
    const tinygltf::Node& node = model_.nodes[size_t(placed.node)];
    if (size_t(node.mesh) >= model_.meshes.size())
      throw GltfDamage("it refers to mesh " + std::to_string(node.mesh) + ", it has " +
                       std::to_string(model_.meshes.size()));
    const tinygltf::Mesh& mesh = model_.meshes[size_t(node.mesh)];
    const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
    for (const tinygltf::Primitive& primitive : mesh.primitives) addPrimitive(primitive, weights, placed);
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                    const PlacedNode& placed) {
    const GltfVertices vertices(model_, primitive, weights);
    if (!vertices.has("POSITION")) return;  // glTF 2.0: nothing is to be drawn
    posed_ |= vertices.morphed();
    const GltfVectors points = vertices.read("POSITION", 3);
    const Faces faces = facesOf(primitive.mode, vertices.corners());
    const GlbColors colors = colorsOf(primitive, vertices);
    stored_.skipped += faces.skipped;
    const Skinning skin(vertices, placed.joints);
    if (!placed.joints.empty() && skin.any()) {
      skinned_ = true;
      addCopy(points, faces, colors, [&](size_t i) { return skin.at(i); });
      return;
    }
    for (const NodeTransform& place : placed.places)
      addCopy(points, faces, colors, [&](size_t) { return place; });
    copies_ += placed.places.size() - 1;
  }

  /// Adds the faces once. `placeOf`: a point's transform to world space. Mirrored faces are turned (glTF 2.0,
  /// section 3.7.4: the determinant of the transform decides which side is the front).
  template <typename PlaceOf>
  void addCopy(const GltfVectors& points, const Faces& faces, const GlbColors& colors,
               const PlaceOf& placeOf) {
    PolygonMesh& mesh = stored_.mesh;
    if (faces.triangles.empty()) return;
    if (mesh.corners.size() + 3 * faces.triangles.size() > kMostCorners ||
        mesh.points.size() + points.count() > kMostCorners)
      refuse(path_, "has more than " + std::to_string(kMostCorners / 1000000) +
                        " million points or corners, the most that is read");
    const ScenePart part{mesh.points.size(), points.count()};
    for (size_t i = 0; i < points.count(); ++i) {
      stored_.addPoint(placeOf(i).apply(Vec3d(Vec3s(points.at(i)))));
      if (!isFinite(mesh.points.back()))
        refuseNotFinite(path_, "point " + std::to_string(mesh.points.size()), mesh.points.back());
    }
    if (colors.any() && stored_.colorsOf != "points")
      stored_.colorsOf = colors.ofPoints ? "points" : "materials";
    const bool turned = points.count() > 0 && placeOf(0).mirrors();
    for (size_t f = 0; f < faces.triangles.size(); ++f) {
      const auto& [a, b, c] = faces.triangles[f];
      for (const std::uint32_t point : {a, turned ? c : b, turned ? b : c}) addCorner(part, f, point, colors);
      mesh.faceStarts.push_back(std::uint32_t(mesh.corners.size()));
      mesh.textureOfFace.push_back(colors.texture);
    }
  }

  void addCorner(const ScenePart& part, size_t face, std::uint32_t point, const GlbColors& colors) {
    PolygonMesh& mesh = stored_.mesh;
    if (point >= part.points) refuseCorner(path_, face, point, part.points);
    mesh.corners.push_back(std::uint32_t(part.first + point));
    mesh.colors.push_back(colors.at(point));
    mesh.uvs.push_back(colors.uvAt(point));
    if (!isFinite(mesh.colors.back()))
      refuseNotFinite(path_, "the colour of point " + std::to_string(mesh.corners.back() + 1),
                      mesh.colors.back());
  }

  GlbColors colorsOf(const tinygltf::Primitive& primitive, const GltfVertices& vertices) {
    GlbColors colors;
    if (vertices.has("COLOR_0")) {
      if (const size_t there = vertices.countOf("COLOR_0"); there != vertices.count())
        refuse(path_, "is damaged: a mesh of " + std::to_string(vertices.count()) + " points has " +
                          std::to_string(there) + " colours");
      colors.ofPoints = vertices.read("COLOR_0", 3, /*normalise=*/true);
    }
    colors.paint = materials_.paintOf(primitive.material);
    if (colors.paint.texture < 0 || !vertices.has(colors.paint.coordinates)) return colors;
    colors.texture = materials_.textureOf(colors.paint.texture);
    if (colors.texture >= 0) colors.uvs = vertices.read(colors.paint.coordinates, 2);
    return colors;
  }

  void addNotes() {
    const auto note = [&](const char* code, const std::string& text) {
      stored_.notes.emplace_back(code, Severity::kNote, "", text);
    };
    if (posed_)
      note("mesh.morph-targets-applied", "its morph targets are applied with their default weights");
    if (skinned_)
      note("mesh.skin-applied", "its bones are applied in the pose in which the file stores them");
    if (copies_ > 0)
      note("mesh.instances-applied",
           "it has " + std::to_string(copies_ + 1) + " copies of meshes (EXT_mesh_gpu_instancing)");
  }

  const std::string& path_;
  const tinygltf::Model& model_;
  GltfMaterials materials_;
  StoredMesh stored_;
  size_t copies_ = 0;
  bool posed_ = false, skinned_ = false;
};

}  // namespace

/// Reads glTF 2.0 in both containers, .glb and .gltf.
StoredMesh readGlb(const std::string& path, std::string_view bytes) {
  try {
    const GltfFile file = readGltfFile(path, bytes);
    return GlbReader(path, file).read();
  } catch (const GltfDamage& damage) {
    refuse(path, std::string("is damaged: ") + damage.what());
  }
}

}  // namespace slicemorph
