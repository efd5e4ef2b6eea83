#include "io/image/load_library.h"

#include "slicemorph/errors.h"

#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

// Folder of the installed plug-ins: its absolute path, and its path relative to the folders of the program
// and of the library, by which an installation that was moved still finds them.
#ifndef SLICEMORPH_PLUGIN_FOLDER
#define SLICEMORPH_PLUGIN_FOLDER ""
#endif
#ifndef SLICEMORPH_PLUGIN_FROM_PROGRAM
#define SLICEMORPH_PLUGIN_FROM_PROGRAM "../lib/slicemorph"
#endif
#ifndef SLICEMORPH_PLUGIN_FROM_LIBRARY
#define SLICEMORPH_PLUGIN_FROM_LIBRARY "slicemorph"
#endif

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// Folder of the program or shared library that this code is in; empty where the system does not say.
fs::path ownFolder() {
  static const char here = 0;
  Dl_info info = {};
  link_map* map = nullptr;
  if (!dladdr1(&here, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP)) return {};
  std::error_code ignored;
  // The link map has an empty name for the program itself, and argv[0] need not lead to it.
  const bool program = !map || !map->l_name || !*map->l_name;
  return (program ? fs::read_symlink("/proc/self/exe", ignored) : fs::canonical(map->l_name, ignored))
      .parent_path();
}

std::vector<fs::path> pluginFolders() {
  if (const char* prescribed = std::getenv("SLICEMORPH_PLUGINS"); prescribed && *prescribed)
    return {prescribed};
  std::vector<fs::path> folders;
  const auto add = [&](const fs::path& folder) {
    const fs::path plain = folder.lexically_normal();
    if (std::find(folders.begin(), folders.end(), plain) == folders.end()) folders.push_back(plain);
  };
  if (const fs::path own = ownFolder(); !own.empty()) {
    add(own);
    add(own / SLICEMORPH_PLUGIN_FROM_LIBRARY);
    add(own / SLICEMORPH_PLUGIN_FROM_PROGRAM);
  }
  if (*SLICEMORPH_PLUGIN_FOLDER) add(SLICEMORPH_PLUGIN_FOLDER);
  return folders;
}

}  // namespace

void* functionOfPlugin(const std::string& library, const char* function, const std::string& what) {
  std::string searched;
  for (const fs::path& folder : pluginFolders()) {
    std::error_code ignored;
    const fs::path file = folder / library;
    searched += (searched.empty() ? "" : ", ") + folder.string();
    if (!fs::exists(file, ignored)) continue;
    void* loaded = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* found = loaded ? dlsym(loaded, function) : nullptr;
    if (found) return found;
    throw IoError(file.string(), what + " cannot be read: the plug-in cannot be loaded: " + dlerror());
  }
  throw IoError(library, what + " cannot be read: the plug-in is missing; looked in " + searched +
                             "; SLICEMORPH_PLUGINS can name its folder");
}

}  // namespace slicemorph
