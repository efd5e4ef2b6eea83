#pragma once

#include <cstdint>
#include <istream>
#include <stdexcept>

namespace slicemorph {

/// A file that is damaged or cannot be understood; the message does not name it.
struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Steps through parts of a stream whose sizes the file states. Throws Damaged where a part would reach
/// beyond `size`, the size of the whole stream in bytes.
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

/// Walks a tree from its topology to its last value and throws Damaged where a size does not fit.
/// (OpenVDB's reader copies "uncompressed" chunks of whatever length the file states, beyond the end of its
/// buffers, before it compares the sizes.) For files of version 222 or later; the stream must be at the
/// start of the topology.
void checkTree(Walker& walker, const TreeStorage& storage);

}  // namespace slicemorph
