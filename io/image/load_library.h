#pragma once

#include <string>

namespace slicemorph {

/// A function of a plug-in, a library that is loaded when it is first needed and stays. It is looked for in the folder
/// that the environment variable SLICEMORPH_PLUGINS names and nowhere else where that is set; else beside the file
/// that this code is in (the program, or the shared library), and where `cmake --install` puts plug-ins.
/// `what`: that cannot be read without it. Throws IoError naming the file, the places looked at and the reason.
void* functionOfPlugin(const std::string& library, const char* function, const std::string& what);

}  // namespace slicemorph
