#include "io/vdb/vdb_check.h"

#include <openvdb/Metadata.h>
#include <openvdb/io/Compression.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {
namespace {

namespace vdb = openvdb::io;

/// Entries of a node at each level of OpenVDB's usual tree (log2 of the sides: 5, 4, 3), and the voxels along
/// a side of a child of the root.
constexpr size_t kUpper = 32 * 32 * 32, kLower = 16 * 16 * 16, kLeaf = 8 * 8 * 8;
constexpr std::int32_t kRootStep = 4096;
constexpr std::uint64_t kOriginBytes = 3 * sizeof(std::int32_t);

/// Of a leaf.
constexpr std::uint64_t kMaskBytes = kLeaf / 8;

/// Types of metadata whose size is not that of their type; OpenVDB has no names as long as that.
constexpr std::string_view kText = "string", kLeafList = "__delayedload";
constexpr size_t kMostTypeName = 64;

/// OpenVDB reads as many bytes as its type has, whatever size is stated, and takes what follows for the next entry.
void checkSizeOf(const std::string& type, std::uint64_t bytes) {
  if (type == kText || type == kLeafList || !openvdb::Metadata::isRegisteredType(type)) return;
  if (bytes != openvdb::Metadata::createMetadata(type)->size())
    throw Damaged("its metadata of the type " + type + " have " + std::to_string(bytes) + " bytes");
}

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
    for (std::uint32_t i = 0; i < tiles; ++i) walker_.skip(kOriginBytes + storage_.valueSize + 1);
    for (std::uint32_t i = 0; i < children; ++i) {
      origin(i > 0);
      upperNode();
    }
    // The leaves' values follow the topology of the whole tree, each after a copy of the leaf's mask.
    for (size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
      leafValues(leaves_[leaf]);
      if (storage_.listed && storage_.leaves == LeafKind::kValues && storage_.saysWhatIsLeftOut)
        checkListed(leaf);
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

  /// An entry is a child or an active tile: of one that is both, OpenVDB's iterators take the child's address for a value.
  template <size_t N>
  static void checkApart(const Mask<N>& children, const Mask<N>& active) {
    if ((children & active).any()) throw Damaged("its tree is damaged");
  }

  /// Values of a node: of older files children have none.
  template <size_t N>
  size_t storedIn(const Mask<N>& children) const {
    return storage_.saysWhatIsLeftOut ? N : N - children.count();
  }

  void upperNode() {
    const auto children = std::make_unique<Mask<kUpper>>(mask<kUpper>());
    const auto active = std::make_unique<Mask<kUpper>>(mask<kUpper>());
    checkApart(*children, *active);
    values(active->count(), storedIn(*children));
    for (size_t i = children->count(); i > 0; --i) lowerNode();
  }

  void lowerNode() {
    const Mask<kLower> children = mask<kLower>(), active = mask<kLower>();
    checkApart(children, active);
    values(active.count(), storedIn(children));
    for (size_t i = children.count(); i > 0; --i) leaves_.push_back(std::uint16_t(mask<kLeaf>().count()));
  }

  void leafValues(size_t active) {
    // Whoever cannot seek takes this copy of the mask for the number of values.
    if (mask<kLeaf>().count() != active) throw Damaged("its tree is damaged");
    if (storage_.leaves != LeafKind::kValues)
      return walker_.skip(kOriginBytes + (storage_.leaves == LeafKind::kBools ? kLeaf / 8 : 0));
    if (!storage_.saysWhatIsLeftOut) {
      walker_.skip(kOriginBytes);
      if (walker_.number<std::int8_t>() > 1)
        throw Damaged("its leaves have several buffers, which are not read");
    }
    values(active, kLeaf);
  }

  /// Skips what readCompressedValues of openvdb/io/Compression.h reads.
  void values(size_t active, size_t all) {
    if (!storage_.saysWhatIsLeftOut) return chunk(all * std::uint64_t(storage_.storedSize));
    const auto kind = walker_.number<std::int8_t>();
    if (kind < vdb::NO_MASK_OR_INACTIVE_VALS || kind > vdb::NO_MASK_AND_ALL_VALS)
      throw Damaged("its tree is damaged");
    const bool one = kind == vdb::NO_MASK_AND_ONE_INACTIVE_VAL || kind == vdb::MASK_AND_ONE_INACTIVE_VAL;
    const bool two = kind == vdb::MASK_AND_TWO_INACTIVE_VALS;
    walker_.skip(storage_.valueSize * (one ? 1u : two ? 2u : 0u));
    if (two || kind == vdb::MASK_AND_ONE_INACTIVE_VAL || kind == vdb::MASK_AND_NO_INACTIVE_VALS)
      walker_.skip(all / 8);
    const bool mayMask = storage_.compression & vdb::COMPRESS_ACTIVE_MASK;
    if (!mayMask && kind != vdb::NO_MASK_AND_ALL_VALS) throw Damaged("its tree is damaged");
    kind_ = kind;
    chunk((mayMask && kind != vdb::NO_MASK_AND_ALL_VALS ? active : all) * std::uint64_t(storage_.storedSize));
  }

  /// Whoever reads a leaf's values later finds them by this list, not by the sizes that stand before them.
  void checkListed(size_t leaf) const {
    const bool kindIsListed = storage_.compression & vdb::COMPRESS_ACTIVE_MASK;
    if ((kindIsListed && storage_.listed->getMask(leaf) != kind_) ||
        (isPacked() && chunkBytes_ > 0 &&
         storage_.listed->getCompressedSize(leaf) != std::int64_t(chunkBytes_)))
      throw Damaged("its list of leaves does not fit them");
  }

  bool isPacked() const { return storage_.compression & (vdb::COMPRESS_BLOSC | vdb::COMPRESS_ZIP); }

  void chunk(std::uint64_t bytes) {
    chunkBytes_ = 0;
    if (!isPacked()) return walker_.skip(bytes);
    if (bytes == 0 && storage_.storedSize < storage_.valueSize)
      return;  // half floats: of no values not even the size is stored
    const auto stored = walker_.number<std::int64_t>();
    const std::uint64_t size = stored < 0 ? std::uint64_t(0) - std::uint64_t(stored) : std::uint64_t(stored);
    if (stored <= 0 ? size != bytes : size > mostCompressed(bytes)) throw Damaged("its values are damaged");
    chunkBytes_ = sizeof stored + size;
    if (stored > 0 && storage_.compression & vdb::COMPRESS_BLOSC) return walker_.blosc(size);
    walker_.skip(size);
  }

  Walker& walker_;
  TreeStorage storage_;
  std::array<std::int32_t, 3> last_{};
  std::vector<std::uint16_t> leaves_;
  // Of the values that were passed last.
  std::int8_t kind_ = 0;
  std::uint64_t chunkBytes_ = 0;  ///< with the size before them; 0: not packed
};

}  // namespace

Walker::Walker(std::istream& stream, std::uint64_t size)
    : stream_(stream), size_(size), left_(size - std::min(size, std::uint64_t(stream.tellg()))) {}

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
    const std::string type = typeName();
    const std::uint64_t bytes = number<std::uint32_t>();
    if (bytes > left_) throw Damaged("it is truncated or damaged");
    checkSizeOf(type, bytes);
    const std::uint64_t after = left_ - bytes;
    if (type == kLeafList && bytes > 0) leafList();
    if (left_ < after) throw Damaged("its list of leaves is damaged");
    skip(left_ - after);
  }
}

void Walker::leafList() {
  // Every leaf has a mask in the file.
  const auto leaves = number<std::uint32_t>();
  if (leaves > size_ / kMaskBytes) throw Damaged("its list of leaves is damaged");
  // What each leaves out, then how many bytes its values take, which may be missing.
  packedList(leaves * sizeof(std::int8_t), number<std::uint32_t>());
  const auto bytes = number<std::uint32_t>();
  if (bytes != ~std::uint32_t(0)) packedList(leaves * sizeof(std::int64_t), bytes);
}

void Walker::packedList(std::uint64_t whole, std::uint32_t packed) {
  if (packed == 0) return skip(whole);
  blosc(packed);
}

void Walker::blosc(std::uint64_t size) {
  std::array<std::uint32_t, 4> header{};
  if (size < sizeof header) throw Damaged("its packed data are damaged");
  load(header.data(), sizeof header);
  if (header[3] != size) throw Damaged("its packed data are damaged");
  skip(size - sizeof header);
}

std::string Walker::typeName() {
  const auto length = number<std::uint32_t>();
  std::string name(std::min<size_t>(length, kMostTypeName), '\0');
  load(name.data(), name.size());
  skip(length - name.size());
  return name;
}

void Walker::take(std::uint64_t count) {
  if (count > left_) throw Damaged("it is truncated or damaged");
  left_ -= count;
}

void checkTree(Walker& walker, const TreeStorage& storage) { TreeWalker(walker, storage).run(); }

}  // namespace slicemorph
