#include "io/vdb/vdb_check.h"

#include <openvdb/io/Compression.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <memory>
#include <vector>

namespace slicemorph {
namespace {

namespace vdb = openvdb::io;

/// Entries of a node at each level of OpenVDB's usual tree (log2 of the sides: 5, 4, 3), and the voxels along
/// a side of a child of the root.
constexpr size_t kUpper = 32 * 32 * 32, kLower = 16 * 16 * 16, kLeaf = 8 * 8 * 8;
constexpr std::int32_t kRootStep = 4096;

template <size_t N>
using Mask = std::bitset<N>;

/// Upper bound of a compressed size: to incompressible data blosc adds at most 16 bytes and zlib about 0.1 %.
constexpr std::uint64_t mostCompressed(std::uint64_t bytes) { return bytes + bytes / 64 + 64; }

class TreeWalker {
 public:
  TreeWalker(Walker& walker, const TreeStorage& storage) : walker_(walker), storage_(storage) {}

  void run() {
    if (walker_.number<std::int32_t>() != 1) throw Damaged("its tree is damaged");
    walker_.skip(storage_.valueSize);  // background
    const auto tiles = walker_.number<std::uint32_t>(), children = walker_.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < tiles; ++i) walker_.skip(3 * sizeof(std::int32_t) + storage_.valueSize + 1);
    for (std::uint32_t i = 0; i < children; ++i) {
      origin(i > 0);
      upperNode();
    }
    // The leaves' values follow the topology of the whole tree, each after a copy of the leaf's mask.
    for (const std::uint16_t active : leaves_) {
      walker_.skip(kLeaf / 8);
      values(active, kLeaf);
    }
  }

 private:
  void origin(bool hasLast) {
    std::array<std::int32_t, 3> at{};
    walker_.load(at.data(), sizeof at);
    for (std::int32_t v : at) {
      if (v % kRootStep != 0) throw Damaged("its tree is damaged");
    }
    // OpenVDB writes origins in ascending order; of two equal ones its reader would lose one.
    if (hasLast && !(last_ < at)) throw Damaged("its tree is damaged");
    last_ = at;
  }

  template <size_t N>
  Mask<N> mask() {
    static_assert(sizeof(Mask<N>) == N / 8);
    Mask<N> bits;
    walker_.load(&bits, sizeof bits);
    return bits;
  }

  void upperNode() {
    const auto children = std::make_unique<Mask<kUpper>>(mask<kUpper>());
    const auto active = std::make_unique<Mask<kUpper>>(mask<kUpper>());
    values(active->count(), kUpper);
    for (size_t i = children->count(); i > 0; --i) lowerNode();
  }

  void lowerNode() {
    const Mask<kLower> children = mask<kLower>(), active = mask<kLower>();
    values(active.count(), kLower);
    for (size_t i = children.count(); i > 0; --i) leaves_.push_back(std::uint16_t(mask<kLeaf>().count()));
  }

  /// Skips what readCompressedValues of openvdb/io/Compression.h reads.
  void values(size_t active, size_t all) {
    const auto kind = walker_.number<std::int8_t>();
    if (kind < vdb::NO_MASK_OR_INACTIVE_VALS || kind > vdb::NO_MASK_AND_ALL_VALS)
      throw Damaged("its tree is damaged");
    const bool one = kind == vdb::NO_MASK_AND_ONE_INACTIVE_VAL || kind == vdb::MASK_AND_ONE_INACTIVE_VAL;
    const bool two = kind == vdb::MASK_AND_TWO_INACTIVE_VALS;
    walker_.skip(storage_.valueSize * (one ? 1u : two ? 2u : 0u));
    if (two || kind == vdb::MASK_AND_ONE_INACTIVE_VAL || kind == vdb::MASK_AND_NO_INACTIVE_VALS)
      walker_.skip(all / 8);
    const bool masked = storage_.compression & vdb::COMPRESS_ACTIVE_MASK && kind != vdb::NO_MASK_AND_ALL_VALS;
    chunk((masked ? active : all) * std::uint64_t(storage_.storedSize));
  }

  void chunk(std::uint64_t bytes) {
    if (!(storage_.compression & (vdb::COMPRESS_BLOSC | vdb::COMPRESS_ZIP))) return walker_.skip(bytes);
    if (bytes == 0 && storage_.storedSize < storage_.valueSize)
      return;  // half floats: of no values not even the size is stored
    const auto stored = walker_.number<std::int64_t>();
    const std::uint64_t size = stored < 0 ? std::uint64_t(0) - std::uint64_t(stored) : std::uint64_t(stored);
    if (stored <= 0 ? size != bytes : size > mostCompressed(bytes)) throw Damaged("its values are damaged");
    walker_.skip(size);
  }

  Walker& walker_;
  TreeStorage storage_;
  std::array<std::int32_t, 3> last_{};
  std::vector<std::uint16_t> leaves_;
};

}  // namespace

Walker::Walker(std::istream& stream, std::uint64_t size)
    : stream_(stream), left_(size - std::min(size, std::uint64_t(stream.tellg()))) {}

void Walker::load(void* target, std::uint64_t count) {
  take(count);
  stream_.read(static_cast<char*>(target), std::streamsize(count));
}

void Walker::skip(std::uint64_t count) {
  take(count);
  // A seek discards the stream's buffer, so short parts are read over.
  if (count < 1 << 16) {
    stream_.ignore(std::streamsize(count));
  } else {
    stream_.seekg(std::streamoff(count), std::ios::cur);
  }
}

void Walker::metadata() {
  for (auto count = number<std::uint32_t>(); count > 0; --count) {
    text();
    text();
    text();
  }
}

void Walker::take(std::uint64_t count) {
  if (count > left_) throw Damaged("it is truncated or damaged");
  left_ -= count;
}

void checkTree(Walker& walker, const TreeStorage& storage) { TreeWalker(walker, storage).run(); }

}  // namespace slicemorph
