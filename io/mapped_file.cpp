#include "io/mapped_file.h"

#include "io/paths.h"
#include "slicemorph/errors.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace slicemorph {

MappedFile::MappedFile(const std::string& path) {
  const size_t size = sizeOfInput(path);
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw IoError(path, "cannot be read");
  void* at = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
  ::close(file);
  if (at == MAP_FAILED) throw IoError(path, "cannot be read");
  bytes_ = {static_cast<const char*>(at), size};
}

MappedFile::~MappedFile() { ::munmap(const_cast<char*>(bytes_.data()), bytes_.size()); }

}  // namespace slicemorph
