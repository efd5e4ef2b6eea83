#pragma once

#include "slicemorph/conventions.h"

#include <vector>

namespace tinygltf {
class Model;
class Node;
}  // namespace tinygltf

namespace slicemorph {

/// An affine map of points: linear * p + shift.
struct NodeTransform {
  Mat3d linear = Mat3d::identity();
  Vec3d shift{0, 0, 0};

  Vec3d apply(const Vec3d& p) const { return linear * p + shift; }
  NodeTransform after(const NodeTransform& inner) const {
    return {linear * inner.linear, apply(inner.shift)};
  }
  bool mirrors() const { return linear.det() < 0; }
};

/// A node of the scene that shows a mesh.
struct PlacedNode {
  int node = 0;
  std::vector<NodeTransform> places;  ///< to world space; several of EXT_mesh_gpu_instancing
  std::vector<NodeTransform> joints;  ///< of its skin: from bind pose to world space; empty: it has none
};

/// The nodes of the default scene that show meshes, in the file's order (of a file without scenes, all roots are
/// shown). Nodes that KHR_node_visibility hides are left out, with their children. Throws GltfDamage.
std::vector<PlacedNode> placedNodes(const tinygltf::Model& model);

}  // namespace slicemorph
