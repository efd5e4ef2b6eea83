#include "io/mesh/glb_writer.h"

#include "engine/numerics/readable.h"
#include "io/atomic_file.h"
#include "io/mesh/vertex_normals.h"
#include "slicemorph/errors.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3s;
using Points = std::vector<Vec3s>;

static_assert(sizeof(Vec3s) == 12 && sizeof(openvdb::Vec3I) == 12,
              "vectors are written as they lie in memory");

Points minus(const Points& a, const Points& b) {
  Points difference(a.size());
  for (size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
  return difference;
}

std::string frameName(int number) {
  char name[32];
  std::snprintf(name, sizeof name, "frame.%04d", number);
  return name;
}

/// Colours clamped to 0 to 1, as glTF requires.
Points within01(Points colors) {
  for (Vec3s& c : colors)
    for (int i = 0; i < 3; ++i) c[i] = std::clamp(c[i], 0.f, 1.f);
  return colors;
}

bool colorsChange(const MovingMesh& m) {
  return std::any_of(m.colors.begin(), m.colors.end(), [&](const Points& c) { return c != m.colors[0]; });
}

/// Bytes of indices and vertices: per vertex and frame three floats for the position and three for the
/// normal; three for the colour, in each frame only where colours change.
double sizeOf(const std::vector<MovingMesh>& meshes) {
  double bytes = 0;
  for (const MovingMesh& m : meshes) {
    const size_t vectors = 2 * m.points.size() + (colorsChange(m) ? m.colors.size() : !m.colors.empty());
    bytes += 12.0 * double(m.triangles.size()) + 12.0 * double(vectors) * double(m.points.front().size());
  }
  return bytes;
}

class GlbBuilder {
 public:
  /// `numbers`: of all frames.
  GlbBuilder(double framesPerSecond, const GlbSpace& space, std::vector<int> numbers, size_t bytes)
      : framesPerSecond_(framesPerSecond), numbers_(std::move(numbers)) {
    model_.asset.version = "2.0";
    model_.asset.generator = "slicemorph";
    model_.buffers.resize(1);
    bytes_().reserve(bytes + bytes / 64 + 4096);
    addScene(space);
  }

  void add(const MovingMesh& moving) {
    const size_t frameCount = numbers_.size(), count = moving.points.size(), last = moving.first + count - 1;
    const bool still = count == 1;
    const std::string name =
        count == frameCount
            ? "morph"
            : frameName(numbers_[moving.first]) + (still ? "" : "-" + frameName(numbers_[last]).substr(6));
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = materialOf(moving.colors.empty() ? "clay" : "colors");
    primitive.indices = addIndices(moving.triangles);
    const Points& base = moving.points.front();
    const Points normals = vertexNormals(moving.triangles, base);
    primitive.attributes["POSITION"] = addVectors(base, true);
    primitive.attributes["NORMAL"] = addVectors(normals, false);
    const Points colors = moving.colors.empty() ? Points() : within01(moving.colors.front());
    if (!colors.empty()) primitive.attributes["COLOR_0"] = addVectors(colors, false);
    const bool changing = colorsChange(moving);
    tinygltf::Value::Array names;
    for (size_t i = 1; i < count; ++i) {
      const Points& points = moving.points[i];
      primitive.targets.push_back(
          {{"POSITION", addVectors(minus(points, base), true)},
           {"NORMAL", addVectors(minus(vertexNormals(moving.triangles, points, &normals), normals), false)}});
      if (changing)
        primitive.targets.back()["COLOR_0"] = addVectors(minus(within01(moving.colors[i]), colors), false);
      names.push_back(tinygltf::Value(frameName(numbers_[moving.first + i])));
    }
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(std::move(primitive));
    if (!still) {
      mesh.weights.assign(count - 1, 0.0);
      mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(names)}});
    }
    model_.meshes.push_back(std::move(mesh));

    tinygltf::Node node;
    node.name = name;
    node.mesh = int(model_.meshes.size()) - 1;
    if (moving.first > 0) node.scale = {0, 0, 0};
    model_.nodes.push_back(std::move(node));
    const int index = int(model_.nodes.size()) - 1;
    parent_().push_back(index);
    if (!still) animateWeights(index, moving.first, count);
    if (count < frameCount) animateVisibility(index, moving.first, count, frameCount);
  }

  tinygltf::Model finish() {
    if (!animation_.channels.empty()) {
      animation_.name = "morph";
      model_.animations.push_back(std::move(animation_));
    }
    return std::move(model_);
  }

 private:
  std::vector<unsigned char>& bytes_() { return model_.buffers[0].data; }
  std::vector<int>& parent_() { return hasRoot_ ? model_.nodes[0].children : model_.scenes[0].nodes; }

  /// Index of a material, which is made where it is missing: "clay", a neutral brown chosen by eye, or
  /// "colors", white, which shows vertex colours unchanged. Both are rough and not metallic; glTF's default
  /// is a metal.
  int materialOf(const std::string& name) {
    for (size_t i = 0; i < model_.materials.size(); ++i)
      if (model_.materials[i].name == name) return int(i);
    tinygltf::Material material;
    material.name = name;
    if (name == "clay") material.pbrMetallicRoughness.baseColorFactor = {0.62, 0.47, 0.36, 1};
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.7;
    model_.materials.push_back(std::move(material));
    return int(model_.materials.size()) - 1;
  }

  void addScene(const GlbSpace& space) {
    model_.scenes.resize(1);
    model_.defaultScene = 0;
    hasRoot_ = space.zUp || space.metres != 1;
    if (!hasRoot_) return;
    tinygltf::Node root;
    root.name = "world";
    if (space.zUp) root.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
    if (space.metres != 1) root.scale = {space.metres, space.metres, space.metres};
    model_.nodes.push_back(std::move(root));
    model_.scenes[0].nodes.push_back(0);
  }

  int addAccessor(const void* data, size_t size, size_t count, int type, int componentType, int target) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes_().size();
    view.byteLength = size;
    view.target = target;
    const auto* first = static_cast<const unsigned char*>(data);
    bytes_().insert(bytes_().end(), first, first + size);
    model_.bufferViews.push_back(std::move(view));
    tinygltf::Accessor accessor;
    accessor.bufferView = int(model_.bufferViews.size()) - 1;
    accessor.byteOffset = 0;
    accessor.count = count;
    accessor.type = type;
    accessor.componentType = componentType;
    model_.accessors.push_back(std::move(accessor));
    return int(model_.accessors.size()) - 1;
  }

  int addIndices(const std::vector<openvdb::Vec3I>& triangles) {
    return addAccessor(triangles.data(), triangles.size() * 12, triangles.size() * 3, TINYGLTF_TYPE_SCALAR,
                       TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  }

  /// `bounded`: state the smallest and largest value, which glTF requires of positions.
  int addVectors(const Points& vectors, bool bounded) {
    const int index = addAccessor(vectors.data(), vectors.size() * 12, vectors.size(), TINYGLTF_TYPE_VEC3,
                                  TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TARGET_ARRAY_BUFFER);
    if (!bounded) return index;
    Vec3s low = vectors.front(), high = low;
    for (const Vec3s& v : vectors)
      low = openvdb::math::minComponent(low, v), high = openvdb::math::maxComponent(high, v);
    model_.accessors[size_t(index)].minValues = {low[0], low[1], low[2]};
    model_.accessors[size_t(index)].maxValues = {high[0], high[1], high[2]};
    return index;
  }

  int addNumbers(const std::vector<float>& numbers, int type = TINYGLTF_TYPE_SCALAR) {
    return addAccessor(numbers.data(), numbers.size() * 4,
                       numbers.size() / (type == TINYGLTF_TYPE_VEC3 ? 3 : 1), type,
                       TINYGLTF_COMPONENT_TYPE_FLOAT, 0);
  }

  /// Adds the times of frames, in seconds, ascending. Returns the accessor.
  int addTimes(const std::vector<size_t>& frames) {
    std::vector<float> times;
    times.reserve(frames.size());
    for (size_t frame : frames)
      times.push_back(float(double(numbers_[frame] - numbers_[0]) / framesPerSecond_));
    const int index = addNumbers(times);
    model_.accessors[size_t(index)].minValues = {times.front()};
    model_.accessors[size_t(index)].maxValues = {times.back()};
    return index;
  }

  void animate(int node, const char* path, const char* interpolation, int times, int values) {
    tinygltf::AnimationSampler sampler;
    sampler.input = times;
    sampler.output = values;
    sampler.interpolation = interpolation;
    animation_.samplers.push_back(std::move(sampler));
    tinygltf::AnimationChannel channel;
    channel.sampler = int(animation_.samplers.size()) - 1;
    channel.target_node = node;
    channel.target_path = path;
    animation_.channels.push_back(std::move(channel));
  }

  void animateWeights(int node, size_t first, size_t count) {
    std::vector<size_t> frames(count);
    std::vector<float> weights(count * (count - 1), 0.f);
    for (size_t i = 0; i < count; ++i) {
      frames[i] = first + i;
      if (i > 0) weights[i * (count - 1) + i - 1] = 1;
    }
    const int times = addTimes(frames);
    animate(node, "weights", "LINEAR", times, addNumbers(weights));
  }

  void animateVisibility(int node, size_t first, size_t count, size_t frameCount) {
    std::vector<size_t> frames{first};
    std::vector<float> scales{1, 1, 1};
    if (first > 0) {
      frames.insert(frames.begin(), 0);
      scales.insert(scales.begin(), 3, 0.f);
    }
    if (first + count < frameCount) {
      frames.push_back(first + count);
      scales.insert(scales.end(), 3, 0.f);
    }
    const int times = addTimes(frames);
    animate(node, "scale", "STEP", times, addNumbers(scales, TINYGLTF_TYPE_VEC3));
  }

  double framesPerSecond_;
  std::vector<int> numbers_;
  bool hasRoot_ = false;
  tinygltf::Model model_;
  tinygltf::Animation animation_;
};

/// `name`: names the file in error messages.
void write(const std::vector<MovingMesh>& meshes, double framesPerSecond, const GlbSpace& space,
           std::vector<int> numbers, const std::string& name, std::ostream& stream) {
  const auto nothing = [](const MovingMesh& m) { return m.triangles.empty(); };
  if (std::all_of(meshes.begin(), meshes.end(), nothing))
    throw IoError(name, std::string("cannot be written: ") +
                            (meshes.size() > 1 ? "no frame has a surface" : "there is no surface"));
  const double bytes = sizeOf(meshes);
  if (bytes > 0.99 * double(std::numeric_limits<std::uint32_t>::max()))
    throw IoError(name,
                  "cannot be written: it would have " + readableBytes(bytes) +
                      " and .glb holds at most 4 GiB; use fewer frames, a lower --resolution or a file a "
                      "frame (name.####.glb)");
  if (numbers.empty()) {
    numbers.resize(meshes.back().first + meshes.back().points.size());
    std::iota(numbers.begin(), numbers.end(), 1);
  }
  GlbBuilder builder(framesPerSecond, space, std::move(numbers), size_t(bytes));
  for (const MovingMesh& mesh : meshes)
    if (!nothing(mesh)) builder.add(mesh);
  const tinygltf::Model model = builder.finish();
  if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, true))
    throw IoError(name, "cannot be written as glTF");
  stream.flush();
}

}  // namespace

void writeGlb(const std::string& path, const std::vector<MovingMesh>& meshes, double framesPerSecond,
              const GlbSpace& space, const std::vector<int>& numbers) {
  AtomicFile file(path);
  write(meshes, framesPerSecond, space, numbers, path, file.stream());
  file.commit();
}

std::string encodeGlb(const std::vector<MovingMesh>& meshes, double framesPerSecond, const GlbSpace& space) {
  std::ostringstream stream;
  write(meshes, framesPerSecond, space, {}, "a .glb", stream);
  return stream.str();
}

}  // namespace slicemorph
