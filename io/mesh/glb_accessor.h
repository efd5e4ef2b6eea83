#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace tinygltf {
class Model;
}

namespace slicemorph {

/// A part of a glTF file that is damaged or missing; the message names no file.
struct GltfDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Vectors of an accessor (glTF 2.0, section 3.6.2), one after the other.
struct GltfVectors {
  int width = 1;  ///< numbers of a vector
  std::vector<float> values;

  size_t count() const { return values.size() / size_t(width); }
  const float* at(size_t i) const { return values.data() + i * size_t(width); }
};

/// Reads an accessor of any component type as floats. Integers that the accessor marks as normalised, or all
/// integers with `normalise`, are divided by the largest value of their type; sparse values are applied.
/// Throws GltfDamage where there are not `count` vectors of at least `width` numbers, or where they reach
/// beyond their buffer.
GltfVectors readGltfVectors(const tinygltf::Model& model, int accessor, size_t count, int width,
                            bool normalise = false);

/// Reads an accessor of unsigned integers, for example the corners of faces. Throws GltfDamage.
std::vector<std::uint32_t> readGltfIndices(const tinygltf::Model& model, int accessor);

/// The bytes of a buffer view. Throws GltfDamage.
std::string_view bytesOfGltfView(const tinygltf::Model& model, int view);

/// Number of elements of an accessor. Throws GltfDamage where there is no such accessor.
size_t countOfGltf(const tinygltf::Model& model, int accessor);

}  // namespace slicemorph
