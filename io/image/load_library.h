#pragma once

#include <string>

namespace slicemorph {

/// A function of a library that lies beside the program, or where an environment variable says. It stays
/// loaded. `what`: that cannot be read without it. Throws IoError.
void* functionOf(const std::string& library, const char* environment, const char* function,
                 const std::string& what);

}  // namespace slicemorph
