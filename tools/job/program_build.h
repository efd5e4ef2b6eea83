#pragma once

#include <string>

namespace slicemorph {

/// Which program this is: its version, and the linker's identifier of its code, which another build of the same
/// version does not share. "0.1.0 (5f0c...)", or the version alone where the linker left no identifier.
std::string programBuild();

}  // namespace slicemorph
