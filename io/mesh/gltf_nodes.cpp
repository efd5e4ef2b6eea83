#include "io/mesh/gltf_nodes.h"

#include "io/mesh/glb_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace slicemorph {
namespace {

/// glTF 2.0, section 3.5.3: rotation is a unit quaternion x, y, z, w.
NodeTransform transformOf(const Vec3d& translation, const double (&q)[4], const Vec3d& scale) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  NodeTransform result;
  result.linear = Mat3d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
                        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),  //
                        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y));
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) result.linear(r, c) *= scale[c];
  result.shift = translation;
  return result;
}

/// A column-major matrix of 16 numbers.
template <typename Number>
NodeTransform transformOf(const Number* matrix) {
  NodeTransform result;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) result.linear(r, c) = double(matrix[4 * c + r]);
  result.shift = Vec3d(double(matrix[12]), double(matrix[13]), double(matrix[14]));
  return result;
}

/// From a node's space to its parent's.
NodeTransform localTransformOf(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return transformOf(node.matrix.data());
  const auto vectorOf = [](const std::vector<double>& v, double otherwise) {
    return v.size() == 3 ? Vec3d(v[0], v[1], v[2]) : Vec3d(otherwise);
  };
  double q[4] = {0, 0, 0, 1};
  if (node.rotation.size() == 4) std::copy(node.rotation.begin(), node.rotation.end(), q);
  return transformOf(vectorOf(node.translation, 0), q, vectorOf(node.scale, 1));
}

/// An object of a node's extension; null: it has none.
const tinygltf::Value* nodeExtension(const tinygltf::Node& node, const char* name) {
  const auto found = node.extensions.find(name);
  return found == node.extensions.end() || !found->second.IsObject() ? nullptr : &found->second;
}

bool isHidden(const tinygltf::Node& node) {
  const tinygltf::Value* visibility = nodeExtension(node, "KHR_node_visibility");
  return visibility && visibility->Has("visible") && visibility->Get("visible").IsBool() &&
         !visibility->Get("visible").Get<bool>();
}

/// EXT_mesh_gpu_instancing: transforms of a node's copies, in the node's space; one that changes nothing where it
/// has none.
std::vector<NodeTransform> instancesOf(const tinygltf::Model& model, const tinygltf::Node& node) {
  const tinygltf::Value* extension = nodeExtension(node, "EXT_mesh_gpu_instancing");
  if (!extension) return {NodeTransform()};
  if (!extension->Has("attributes") || !extension->Get("attributes").IsObject())
    throw GltfDamage("EXT_mesh_gpu_instancing has no attributes");
  const tinygltf::Value& attributes = extension->Get("attributes");
  const auto accessorOf = [&](const char* name) {
    return attributes.Has(name) && attributes.Get(name).IsNumber() ? attributes.Get(name).GetNumberAsInt()
                                                                   : -1;
  };
  const int translation = accessorOf("TRANSLATION"), rotation = accessorOf("ROTATION"),
            scale = accessorOf("SCALE");
  const int any = translation >= 0 ? translation : rotation >= 0 ? rotation : scale;
  if (any < 0) return {NodeTransform()};
  const size_t count = countOfGltf(model, any);
  const auto read = [&](int accessor, int width, bool normalise) {
    return accessor < 0 ? GltfVectors() : readGltfVectors(model, accessor, count, width, normalise);
  };
  const GltfVectors moves = read(translation, 3, false), turns = read(rotation, 4, true),
                    sizes = read(scale, 3, false);
  std::vector<NodeTransform> instances(count);
  for (size_t i = 0; i < count; ++i) {
    double q[4] = {0, 0, 0, 1};
    double length = 0;
    for (int c = 0; rotation >= 0 && c < 4; ++c) q[c] = double(turns.at(i)[c]), length += q[c] * q[c];
    // Quaternions of bytes are not quite of unit length.
    for (int c = 0; length > 0 && c < 4; ++c) q[c] /= std::sqrt(length);
    instances[i] = transformOf(translation < 0 ? Vec3d(0.0) : Vec3d(openvdb::Vec3s(moves.at(i))), q,
                               scale < 0 ? Vec3d(1.0) : Vec3d(openvdb::Vec3s(sizes.at(i))));
  }
  return instances;
}

class NodeWalk {
 public:
  explicit NodeWalk(const tinygltf::Model& model)
      : model_(model), toWorld_(model.nodes.size()), reached_(model.nodes.size(), false) {}

  std::vector<PlacedNode> run() {
    walk(rootNodes(), &placed_);
    // Joints may be outside the scene.
    walk(allRoots(), nullptr);
    for (PlacedNode& placed : placed_) {
      const tinygltf::Node& node = model_.nodes[size_t(placed.node)];
      if (node.skin >= 0) placed.joints = jointsOf(node.skin);
    }
    return std::move(placed_);
  }

 private:
  struct Step {
    int node;
    NodeTransform parent;
    bool hidden;
  };

  /// Without recursion: a hostile file may nest nodes deeply, or in a circle. `shown`: receives nodes with
  /// meshes; null: places of nodes that were reached already are kept.
  void walk(const std::vector<int>& roots, std::vector<PlacedNode>* shown) {
    std::vector<Step> open;
    for (size_t i = roots.size(); i-- > 0;) open.push_back({roots[i], NodeTransform(), false});
    while (!open.empty()) {
      const Step step = open.back();
      open.pop_back();
      if (step.node < 0 || size_t(step.node) >= reached_.size())
        throw GltfDamage("it refers to node " + std::to_string(step.node) + ", it has " +
                         std::to_string(reached_.size()));
      const size_t index = size_t(step.node);
      if (reached_[index] && !shown) continue;
      if (reached_[index]) throw GltfDamage("node " + std::to_string(index) + " has several parents");
      reached_[index] = true;
      const tinygltf::Node& node = model_.nodes[index];
      toWorld_[index] = step.parent.after(localTransformOf(node));
      const bool hidden = step.hidden || isHidden(node);
      if (shown && !hidden && node.mesh >= 0) {
        PlacedNode placed{step.node, instancesOf(model_, node), {}};
        for (NodeTransform& place : placed.places) place = toWorld_[index].after(place);
        shown->push_back(std::move(placed));
      }
      for (size_t i = node.children.size(); i-- > 0;)
        open.push_back({node.children[i], toWorld_[index], hidden});
    }
  }

  /// Root nodes of the default scene; of a file without scenes, all.
  std::vector<int> rootNodes() const {
    if (model_.scenes.empty()) return allRoots();
    const size_t scene = model_.defaultScene >= 0 ? size_t(model_.defaultScene) : 0;
    if (scene >= model_.scenes.size()) throw GltfDamage("the scene that it shows does not exist");
    return model_.scenes[scene].nodes;
  }

  /// Nodes that are no other node's child.
  std::vector<int> allRoots() const {
    std::vector<bool> child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes)
      for (int c : node.children)
        if (c >= 0 && size_t(c) < child.size()) child[size_t(c)] = true;
    std::vector<int> roots;
    for (size_t i = 0; i < child.size(); ++i)
      if (!child[i]) roots.push_back(int(i));
    return roots;
  }

  /// glTF 2.0, section 3.7.3: a joint's place in the world after the inverse of its bind pose.
  std::vector<NodeTransform> jointsOf(int index) const {
    if (size_t(index) >= model_.skins.size())
      throw GltfDamage("it refers to skin " + std::to_string(index) + ", it has " +
                       std::to_string(model_.skins.size()));
    const tinygltf::Skin& skin = model_.skins[size_t(index)];
    if (skin.joints.empty()) throw GltfDamage("a skin has no joints");
    GltfVectors inverse;
    if (skin.inverseBindMatrices >= 0)
      inverse = readGltfVectors(model_, skin.inverseBindMatrices,
                                countOfGltf(model_, skin.inverseBindMatrices), 16);
    std::vector<NodeTransform> joints;
    for (size_t j = 0; j < skin.joints.size(); ++j) {
      const int node = skin.joints[j];
      if (node < 0 || size_t(node) >= toWorld_.size())
        throw GltfDamage("a skin refers to node " + std::to_string(node));
      if (skin.inverseBindMatrices >= 0 && j >= inverse.count())
        throw GltfDamage("a skin of " + std::to_string(skin.joints.size()) + " joints has " +
                         std::to_string(inverse.count()) + " matrices");
      joints.push_back(skin.inverseBindMatrices < 0
                           ? toWorld_[size_t(node)]
                           : toWorld_[size_t(node)].after(transformOf(inverse.at(j))));
    }
    return joints;
  }

  const tinygltf::Model& model_;
  std::vector<NodeTransform> toWorld_;
  std::vector<bool> reached_;
  std::vector<PlacedNode> placed_;
};

}  // namespace

std::vector<PlacedNode> placedNodes(const tinygltf::Model& model) { return NodeWalk(model).run(); }

}  // namespace slicemorph
