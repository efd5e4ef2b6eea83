#pragma once

#include <bzlib.h>
#include <zlib.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace slicemorph {

/// How bytes lie in a file: as they are, as zlib or gzip streams, as bzip2 streams.
enum class PackedAs { kPlain, kDeflate, kBzip2 };

/// A file's bytes from an offset on, unpacked.
class PackedBytes {
 public:
  /// Throws IoError, naming the file, where it cannot be read.
  PackedBytes(const std::string& path, std::uint64_t from, PackedAs as);
  ~PackedBytes();
  PackedBytes(const PackedBytes&) = delete;
  PackedBytes& operator=(const PackedBytes&) = delete;

  /// The next bytes; returns how many there were: less where the file or its stream ends, or is damaged.
  size_t read(void* to, size_t bytes);
  /// Passes over bytes; whether there were as many.
  bool skip(std::uint64_t bytes);
  /// Reads what is left. Returns whether the packed stream ends as it should.
  bool endsWell();
  /// Length of the packed stream as far as it was read.
  size_t packedBytes() const { return size_t(deflated_.total_in); }

 private:
  /// Unpacks some bytes; returns how many.
  size_t inflated(char* to, size_t room);
  size_t unzipped(char* to, size_t room);
  /// Begins the next stream where one follows that which ended.
  bool restart();

  std::ifstream file_;
  PackedAs as_;
  bool more_ = true, ended_ = false;  ///< the stream goes on; it ended as it should
  std::vector<char> in_;
  size_t at_ = 0, there_ = 0;  ///< of in_: what is not yet unpacked
  z_stream deflated_ = {};
  bz_stream zipped_ = {};
};

}  // namespace slicemorph
