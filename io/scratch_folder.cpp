#include "io/scratch_folder.h"

#include "slicemorph/errors.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace slicemorph {

ScratchFolder::ScratchFolder()
    : path_((std::filesystem::temp_directory_path() / "slicemorph-XXXXXX").string()) {
  // POSIX: mkdtemp makes a new folder with the mode 0700 and never takes an existing one.
  if (!::mkdtemp(path_.data())) throw IoError(path_, std::string("cannot be made: ") + std::strerror(errno));
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace slicemorph
