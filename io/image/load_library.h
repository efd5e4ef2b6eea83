#pragma once

#include <string>

namespace slicemorph {

/// A function of a plug-in: a shared library that is loaded when it is first needed and never unloaded. If
/// the environment variable SLICEMORPH_PLUGINS is set, only the folder that it names is searched; else the
/// folder of the file that this code is in (the program or the shared library) and those where `cmake
/// --install` puts plug-ins.
/// `what`: for the message, what cannot be read without the plug-in. Throws IoError naming the file, the
/// folders searched and the reason.
void* functionOfPlugin(const std::string& library, const char* function, const std::string& what);

}  // namespace slicemorph
