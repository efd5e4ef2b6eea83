#include "io/mesh/glb_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace slicemorph {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "glTF's numbers are read as they lie in memory");

/// Vectors of an accessor without data; as many as points are read of a file (glb_reader.cpp).
constexpr size_t kMostZeros = size_t(1) << 28;

const tinygltf::Accessor& accessorOf(const tinygltf::Model& model, int index) {
  if (index < 0 || size_t(index) >= model.accessors.size())
    throw GltfDamage("it refers to accessor " + std::to_string(index) + ", it has " +
                     std::to_string(model.accessors.size()));
  return model.accessors[size_t(index)];
}

/// Elements of one size at a constant stride (bytes), checked to lie within their buffer.
struct Elements {
  const unsigned char* first = nullptr;
  size_t stride = 0;

  const unsigned char* at(size_t i) const { return first + i * stride; }
};

/// `offset`, `stride`, `size`: bytes; stride 0: tightly packed. Throws GltfDamage.
Elements elementsOf(const tinygltf::Model& model, int viewIndex, std::uint64_t offset, std::uint64_t stride,
                    std::uint64_t size, std::uint64_t count) {
  if (viewIndex < 0 || size_t(viewIndex) >= model.bufferViews.size())
    throw GltfDamage("it refers to buffer view " + std::to_string(viewIndex) + ", it has " +
                     std::to_string(model.bufferViews.size()));
  const tinygltf::BufferView& view = model.bufferViews[size_t(viewIndex)];
  if (view.buffer < 0 || size_t(view.buffer) >= model.buffers.size())
    throw GltfDamage("it refers to buffer " + std::to_string(view.buffer) + ", it has " +
                     std::to_string(model.buffers.size()));
  const std::vector<unsigned char>& bytes = model.buffers[size_t(view.buffer)].data;
  if (stride == 0) stride = size;
  // Files of more than 2 GiB are not read, so offsets and sizes of 2^40 and more are damage. With the limit
  // the end of the elements cannot overflow.
  const std::uint64_t most = std::uint64_t(1) << 40;
  const bool absurd =
      offset > most || count > most / std::max<std::uint64_t>(stride, 1) || view.byteOffset > most;
  if (absurd || offset + (count > 0 ? stride * (count - 1) + size : 0) > view.byteLength ||
      view.byteLength > bytes.size() || view.byteOffset > bytes.size() - view.byteLength)
    throw GltfDamage("an accessor reaches beyond its buffer");
  return {bytes.data() + view.byteOffset + offset, size_t(stride)};
}

template <typename Number>
Number loadAs(const unsigned char* at) {
  Number number;
  std::memcpy(&number, at, sizeof number);
  return number;
}

template <typename Number>
float scaledAs(const unsigned char* at, bool normalise) {
  const float value = float(loadAs<Number>(at));
  return normalise ? std::max(value / float(std::numeric_limits<Number>::max()), -1.f) : value;
}

float numberAt(const unsigned char* at, int component, bool normalise) {
  switch (component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return scaledAs<std::int8_t>(at, normalise);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return scaledAs<std::uint8_t>(at, normalise);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return scaledAs<std::int16_t>(at, normalise);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return scaledAs<std::uint16_t>(at, normalise);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return scaledAs<std::uint32_t>(at, normalise);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return loadAs<float>(at);
    default:
      throw GltfDamage("an accessor has the component type " + std::to_string(component));
  }
}

std::uint32_t indexAt(const unsigned char* at, int component) {
  switch (component) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *at;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return loadAs<std::uint16_t>(at);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return loadAs<std::uint32_t>(at);
    default:
      throw GltfDamage("indices have the component type " + std::to_string(component));
  }
}

std::uint64_t sizeOfComponent(int component) {
  const int size = tinygltf::GetComponentSizeInBytes(std::uint32_t(component));
  if (size <= 0) throw GltfDamage("an accessor has the component type " + std::to_string(component));
  return std::uint64_t(size);
}

void copyVector(const unsigned char* from, const tinygltf::Accessor& accessor, bool normalise, float* to,
                int width) {
  const size_t size = sizeOfComponent(accessor.componentType);
  for (int c = 0; c < width; ++c)
    to[c] = numberAt(from + size_t(c) * size, accessor.componentType, normalise);
}

/// Calls `put(index, bytes)` for each element for which a sparse accessor of `count` elements states another value
/// (glTF 2.0, "Sparse Accessors"). `size`: of an element, bytes.
template <typename Put>
void forEachSparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor, std::uint64_t size,
                   const Put& put) {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || size_t(sparse.count) > accessor.count || sparse.indices.byteOffset < 0 ||
      sparse.values.byteOffset < 0)
    throw GltfDamage("an accessor has sparse values that make no sense");
  const std::uint64_t count = std::uint64_t(sparse.count);
  const Elements indices = elementsOf(model, sparse.indices.bufferView, size_t(sparse.indices.byteOffset), 0,
                                      sizeOfComponent(sparse.indices.componentType), count);
  const Elements values =
      elementsOf(model, sparse.values.bufferView, size_t(sparse.values.byteOffset), 0, size, count);
  for (size_t i = 0; i < count; ++i) {
    const std::uint32_t index = indexAt(indices.at(i), sparse.indices.componentType);
    if (index >= accessor.count) throw GltfDamage("an accessor has sparse values beyond its end");
    put(index, values.at(i));
  }
}

}  // namespace

std::string_view bytesOfGltfView(const tinygltf::Model& model, int index) {
  if (index < 0 || size_t(index) >= model.bufferViews.size())
    throw GltfDamage("it refers to buffer view " + std::to_string(index) + ", it has " +
                     std::to_string(model.bufferViews.size()));
  const size_t length = model.bufferViews[size_t(index)].byteLength;
  const Elements bytes = elementsOf(model, index, 0, 1, 1, length);
  return {reinterpret_cast<const char*>(bytes.first), length};
}

size_t countOfGltf(const tinygltf::Model& model, int accessor) { return accessorOf(model, accessor).count; }

GltfVectors readGltfVectors(const tinygltf::Model& model, int index, size_t count, int width,
                            bool normalise) {
  const tinygltf::Accessor& accessor = accessorOf(model, index);
  GltfVectors vectors;
  vectors.width = tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type));
  if (accessor.count != count || vectors.width < width)
    throw GltfDamage("an accessor has " + std::to_string(accessor.count) + " vectors of " +
                     std::to_string(vectors.width) + " numbers where " + std::to_string(count) + " of " +
                     std::to_string(width) + " are needed");
  normalise |= accessor.normalized;
  // Without a view all numbers are 0 but for sparse ones, so a damaged count has no data that contradicts it.
  if (accessor.bufferView < 0 && count > kMostZeros)
    throw GltfDamage("an accessor without data has " + std::to_string(count) + " vectors");
  if (accessor.bufferView >= 0) {
    const std::uint64_t size = sizeOfComponent(accessor.componentType) * std::uint64_t(vectors.width);
    const size_t view = size_t(accessor.bufferView);
    const size_t stride = view < model.bufferViews.size() ? model.bufferViews[view].byteStride : 0;
    const Elements elements =
        elementsOf(model, accessor.bufferView, accessor.byteOffset, stride, size, count);
    vectors.values.resize(count * size_t(vectors.width));
    for (size_t i = 0; i < count; ++i)
      copyVector(elements.at(i), accessor, normalise, &vectors.values[i * size_t(vectors.width)],
                 vectors.width);
  } else {
    vectors.values.resize(count * size_t(vectors.width));
  }
  if (!accessor.sparse.isSparse) return vectors;
  const std::uint64_t size = sizeOfComponent(accessor.componentType) * std::uint64_t(vectors.width);
  forEachSparse(model, accessor, size, [&](size_t i, const unsigned char* from) {
    copyVector(from, accessor, normalise, &vectors.values[i * size_t(vectors.width)], vectors.width);
  });
  return vectors;
}

std::vector<std::uint32_t> readGltfIndices(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = accessorOf(model, index);
  const Elements elements = elementsOf(model, accessor.bufferView, accessor.byteOffset, 0,
                                       sizeOfComponent(accessor.componentType), accessor.count);
  std::vector<std::uint32_t> indices(accessor.count);
  for (size_t i = 0; i < indices.size(); ++i) indices[i] = indexAt(elements.at(i), accessor.componentType);
  if (accessor.sparse.isSparse)
    forEachSparse(
        model, accessor, sizeOfComponent(accessor.componentType),
        [&](size_t i, const unsigned char* from) { indices[i] = indexAt(from, accessor.componentType); });
  return indices;
}

}  // namespace slicemorph
