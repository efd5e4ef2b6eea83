#pragma once

#include <cstdint>
#include <istream>
#include <stdexcept>

namespace slicemorph {

/// A file whose sizes contradict each other; the message says how, without the file's name.
struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Steps over parts of a stream without believing their sizes: none may reach beyond `size`, the whole
/// stream's.
class Walker {
 public:
  Walker(std::istream& stream, std::uint64_t size);

  template <typename T>
  T number() {
    T value{};
    load(&value, sizeof value);
    return value;
  }
  void load(void* target, std::uint64_t count);
  void skip(std::uint64_t count);
  void text() { skip(number<std::uint32_t>()); }
  void metadata();

 private:
  void take(std::uint64_t count);

  std::istream& stream_;
  std::uint64_t left_;
};

/// How the values of a float or double tree of the usual shape (5, 4, 3) are stored.
struct TreeStorage {
  unsigned valueSize = 4;         ///< bytes of a value in memory: tiles and inactive values
  unsigned storedSize = 4;        ///< bytes of an active value: 2 for half floats
  std::uint32_t compression = 0;  ///< flags of openvdb::io
};

/// Walks a tree from its topology to its last value and throws Damaged where a size does not fit. OpenVDB's
/// reader reads "uncompressed" chunks of whatever length the file states over the end of its buffers before
/// it compares. For files of version 222 or later; the stream stands at the topology.
void checkTree(Walker& walker, const TreeStorage& storage);

}  // namespace slicemorph
