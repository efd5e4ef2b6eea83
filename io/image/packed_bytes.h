#pragma once

#include <zlib.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace slicemorph {

/// A file's bytes from an offset on, as they lie there or unpacked from a zlib or gzip stream.
class PackedBytes {
 public:
  /// Throws IoError, naming the file, where it cannot be read.
  PackedBytes(const std::string& path, std::uint64_t from, bool packed);
  ~PackedBytes();
  PackedBytes(const PackedBytes&) = delete;
  PackedBytes& operator=(const PackedBytes&) = delete;

  /// The next bytes; returns how many there were: less where the file or its stream ends, or is damaged.
  size_t read(void* to, size_t bytes);
  /// Reads what is left. Returns whether the packed stream ends as it should.
  bool endsWell();
  /// Length of the packed stream as far as it was read.
  size_t packedBytes() const { return size_t(stream_.total_in); }

 private:
  std::ifstream file_;
  bool packed_;
  int state_ = Z_OK;
  std::vector<char> in_;
  z_stream stream_ = {};
};

}  // namespace slicemorph
