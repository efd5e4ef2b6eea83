#include "io/mesh/gltf_meshopt.h"

#include "io/mesh/glb_accessor.h"

#include <nlohmann/json.hpp>

#include <limits>

#ifdef SLICEMORPH_MESHOPT
#include <meshoptimizer.h>
#endif

namespace slicemorph {

#ifdef SLICEMORPH_MESHOPT

/// Bytes of a vertex buffer that one packed byte can hold at most: where 16 values in a row are equal, 2 bits say so.
/// (Of indices a triangle takes at least one byte.)
constexpr std::uint64_t kMostUnpacked = 64;

bool canReadMeshopt() { return true; }

std::string unpackMeshopt(const nlohmann::json& extension, std::string_view packed) {
  const auto damaged = [](const std::string& what) {
    return GltfDamage(std::string("what its ") + kMeshoptExtension + " packs cannot be unpacked: " + what);
  };
  const auto whole = [&](const char* key) {
    const nlohmann::json& value = extension.at(key);
    if (!value.is_number_unsigned()) throw damaged(std::string("its '") + key + "' is no whole number");
    return value.get<std::uint64_t>();
  };
  const std::uint64_t count = whole("count"), stride = whole("byteStride");
  const auto mode = extension.at("mode").get<std::string>(), filter = extension.value("filter", "NONE");
  const bool attributes = mode == "ATTRIBUTES";
  const std::uint64_t most = std::numeric_limits<std::uint32_t>::max() / 2;
  if (stride == 0 || stride > 256 || count > most / stride || (attributes && stride % 4 != 0) ||
      (!attributes && stride != 2 && stride != 4))
    throw damaged(std::to_string(count) + " elements of " + std::to_string(stride) + " bytes");
  if (attributes && count * stride / kMostUnpacked > packed.size())
    throw damaged(std::to_string(packed.size()) + " bytes cannot hold " + std::to_string(count) +
                  " elements of " + std::to_string(stride) + " bytes");
  if (!attributes && count / 3 > packed.size())
    throw damaged(std::to_string(packed.size()) + " bytes cannot hold " + std::to_string(count) + " indices");
  std::string bytes(count * stride, '\0');
  const auto* from = reinterpret_cast<const unsigned char*>(packed.data());
  int problem = 0;
  if (attributes)
    problem = meshopt_decodeVertexBuffer(bytes.data(), count, stride, from, packed.size());
  else if (mode == "TRIANGLES" && count % 3 == 0)
    problem = meshopt_decodeIndexBuffer(bytes.data(), count, stride, from, packed.size());
  else if (mode == "INDICES")
    problem = meshopt_decodeIndexSequence(bytes.data(), count, stride, from, packed.size());
  else
    throw damaged("mode " + mode);
  if (problem != 0) throw damaged("error " + std::to_string(problem) + " of its decoder");
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  else if (filter == "QUATERNION" && stride == 8)
    meshopt_decodeFilterQuat(bytes.data(), count, stride);
  else if (filter == "EXPONENTIAL" && stride % 4 == 0)
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  else if (filter != "NONE")
    throw damaged("filter " + filter + " of " + std::to_string(stride) + " bytes");
  return bytes;
}

#else

bool canReadMeshopt() { return false; }

std::string unpackMeshopt(const nlohmann::json&, std::string_view) {
  throw GltfDamage(std::string("this build does not read ") + kMeshoptExtension);
}

#endif

}  // namespace slicemorph
