#include "io/image/load_library.h"

#include "slicemorph/errors.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>

namespace slicemorph {

void* functionOf(const std::string& library, const char* environment, const char* function,
                 const std::string& what) {
  std::error_code ignored;
  const auto beside = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / library;
  const char* prescribed = std::getenv(environment);
  void* loaded = dlopen(prescribed ? prescribed : beside.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* found = loaded ? dlsym(loaded, function) : nullptr;
  if (!found) throw IoError(what + " cannot be read: " + dlerror());
  return found;
}

}  // namespace slicemorph
