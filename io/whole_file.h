#pragma once

#include <string>

namespace slicemorph {

/// All bytes of a file. Throws IoError as sizeOfInput does (missing, empty, a folder, unreadable).
std::string readWholeFile(const std::string& path);

}  // namespace slicemorph
