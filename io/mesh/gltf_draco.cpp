#include "io/mesh/gltf_draco.h"

#include <draco/compression/decode.h>

#include <limits>

namespace slicemorph {
namespace {

/// The largest value of an integer type, by which normalised numbers are divided; 0: no integers.
double largestOf(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return std::numeric_limits<std::int8_t>::max();
    case draco::DT_UINT8:
      return std::numeric_limits<std::uint8_t>::max();
    case draco::DT_INT16:
      return std::numeric_limits<std::int16_t>::max();
    case draco::DT_UINT16:
      return std::numeric_limits<std::uint16_t>::max();
    case draco::DT_INT32:
      return std::numeric_limits<std::int32_t>::max();
    case draco::DT_UINT32:
      return std::numeric_limits<std::uint32_t>::max();
    default:
      return 0;
  }
}

DracoMesh::Attribute attributeOf(const draco::PointAttribute& from, size_t points) {
  DracoMesh::Attribute to;
  to.vectors.width = from.num_components();
  to.vectors.values.resize(points * size_t(to.vectors.width));
  for (size_t i = 0; i < points; ++i)
    if (!from.ConvertValue(from.mapped_index(draco::PointIndex(std::uint32_t(i))),
                           std::int8_t(to.vectors.width), &to.vectors.values[i * size_t(to.vectors.width)]))
      throw GltfDamage("an attribute that Draco packs cannot be unpacked");
  // Those that Draco itself marks as normalised it has divided already.
  to.most = from.normalized() ? 0 : largestOf(from.data_type());
  return to;
}

}  // namespace

DracoMesh unpackDraco(std::string_view packed) {
  draco::DecoderBuffer buffer;
  buffer.Init(packed.data(), packed.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    throw GltfDamage("what its KHR_draco_mesh_compression packs cannot be unpacked: " +
                     std::string(decoded.status().error_msg()));
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  DracoMesh result;
  result.points = mesh->num_points();
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f)
    for (int k = 0; k < 3; ++k) result.corners.push_back(mesh->face(draco::FaceIndex(f))[k].value());
  for (int a = 0; a < mesh->num_attributes(); ++a) {
    const draco::PointAttribute& attribute = *mesh->attribute(a);
    if (attribute.num_components() < 1 || attribute.num_components() > 16) continue;
    result.attributes[int(attribute.unique_id())] = attributeOf(attribute, result.points);
  }
  return result;
}

}  // namespace slicemorph
