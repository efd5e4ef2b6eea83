#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace slicemorph {

constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

/// Whether the program was built with meshoptimizer.
bool canReadMeshopt();

/// Unpacks a buffer view. `extension`: the view's EXT_meshopt_compression; `packed`: the bytes that it names.
/// Throws GltfDamage.
std::string unpackMeshopt(const nlohmann::json& extension, std::string_view packed);

}  // namespace slicemorph
