#pragma once

#include <openvdb/io/DelayedLoadMetadata.h>

#include <cstdint>
#include <istream>
#include <stdexcept>
#include <string>

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
  /// The name of a type, or what begins it.
  std::string typeName();
  /// Data that blosc packed: it believes what its own header, the first 16 bytes, says of their size.
  void blosc(std::uint64_t size);

 private:
  void take(std::uint64_t count);
  /// OpenVDB's list of leaves (DelayedLoadMetadata), for which its reader allocates what the list says.
  void leafList();
  void packedList(std::uint64_t whole, std::uint32_t packed);

  std::istream& stream_;
  std::uint64_t size_, left_;
};

/// What leaves hold.
enum class LeafKind {
  kValues,  ///< numbers
  kBools,   ///< a bit a voxel beside the mask
  kMask,    ///< the mask alone
};

/// How the values of a tree of the usual shape (5, 4, 3) are stored.
struct TreeStorage {
  LeafKind leaves = LeafKind::kValues;
  unsigned valueSize = 4;         ///< bytes of a value in memory: tiles and inactive values
  unsigned storedSize = 4;        ///< bytes of an active value: 2 for half floats
  std::uint32_t compression = 0;  ///< flags of openvdb::io
  /// Where each leaf's values lie, as the grid's metadata list it for whoever reads them later; null: they are read now.
  const openvdb::io::DelayedLoadMetadata* listed = nullptr;
  bool saysWhatIsLeftOut = true;  ///< before the values of each node; since version 222
};

/// Walks a tree from its topology to its last value and throws Damaged where a size does not fit.
/// (OpenVDB's reader copies "uncompressed" chunks of whatever length the file states, beyond the end of its
/// buffers, before it compares the sizes.) For files of version 217 or later; the stream must be at the
/// start of the topology.
void checkTree(Walker& walker, const TreeStorage& storage);

}  // namespace slicemorph
