#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>

namespace slicemorph {

/// A file that appears whole or not at all: written as `.name.tmp-PID` in the same folder, flushed to the
/// disk and renamed by commit(). Until then, and after any failure, `path` is as it was before; the
/// temporary file is removed. Every call throws IoError naming the file and the system's reason (no space
/// left, read-only ...).
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  /// For writers that seek back to fill in values later; not to be mixed with write(). Throws
  /// as write() does.
  std::ostream& stream();
  /// Reads back everything from byte `offset` on, in parts; the stream has to be flushed before.
  void read(std::uint64_t offset, const std::function<void(std::string_view)>& part);
  void overwrite(std::uint64_t offset, std::string_view bytes);
  void commit();

 private:
  void writeThrough(std::string_view bytes);
  void discard() noexcept;
  [[noreturn]] void fail(const char* what);

  std::string path_, temporary_;
  std::string buffer_;
  std::string failure_;  ///< why it failed; empty where it has not
  int descriptor_ = -1;
  class StreamBuffer;
  std::unique_ptr<StreamBuffer> streamBuffer_;
  std::unique_ptr<std::ostream> stream_;

  friend void removeOpenFiles() noexcept;
  void list();
  void unlist() noexcept;
  AtomicFile *before_ = nullptr, *after_ = nullptr;  ///< in the list of all files that are being written
};

/// Removes the temporary files of all that this process is writing, for when it ends in the middle: where an exception
/// has nowhere to go. It needs no memory. What another thread begins or commits meanwhile may stay.
void removeOpenFiles() noexcept;

/// Removes what a process (its number) that was killed left of `path` half written, if it left anything.
void removeUnfinished(const std::string& path, long process) noexcept;

/// Writes a text file, whole or not at all. Throws IoError.
void writeTextFile(const std::string& path, const std::string& text);

}  // namespace slicemorph
