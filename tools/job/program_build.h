#pragma once

#include <string>

namespace slicemorph {

/// The program's version and the linker's build id, which differs between builds of one version: "0.1.0
/// (5f0c...)", or the version alone where the linker wrote no id.
std::string programBuild();

}  // namespace slicemorph
