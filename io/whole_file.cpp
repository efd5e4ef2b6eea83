#include "io/whole_file.h"

#include "io/paths.h"
#include "slicemorph/errors.h"

#include <fstream>

namespace slicemorph {

std::string readWholeFile(const std::string& path) {
  std::string bytes(sizeOfInput(path), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), std::streamsize(bytes.size()))) throw IoError(path, "cannot be read");
  return bytes;
}

}  // namespace slicemorph
