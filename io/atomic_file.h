#pragma once

#include <string>
#include <string_view>

namespace slicemorph {

/// A file that appears whole or not at all: written as `.name.tmp-PID` in the same folder, flushed to the disk and
/// renamed by commit(). Until then, and after any failure, there is no file; the temporary is removed.
/// Every call throws IoError naming the file and the system's reason (no space left, read-only ...).
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  void commit();

 private:
  void writeThrough(std::string_view bytes);
  void discard() noexcept;
  [[noreturn]] void fail(const char* what);

  std::string path_, temporary_;
  std::string buffer_;
  int descriptor_ = -1;
};

}  // namespace slicemorph
