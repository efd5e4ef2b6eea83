#pragma once

#include <string>
#include <string_view>

namespace slicemorph {

/// The bytes of a file, of which only those that are looked at are read.
class MappedFile {
 public:
  /// Throws IoError as sizeOfInput does (missing, empty, a folder, unreadable).
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::string_view bytes() const { return bytes_; }

 private:
  std::string_view bytes_;
};

}  // namespace slicemorph
