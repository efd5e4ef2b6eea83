#include "slicemorph/io/vdb_writer.h"

#include "io/atomic_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_reader.h"

#include <openvdb/io/Archive.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ostream>
#include <set>
#include <string_view>
#include <vector>

namespace slicemorph {
namespace {

constexpr const char* kCreator = "slicemorph 0.1.0";

/// Byte offset and length of the file's identifier. Before it: magic number (8 bytes), file version (4),
/// library version (2 x 4) and whether there are grid offsets (1).
constexpr size_t kIdentifierAt = 21, kIdentifierSize = 36;

class Writer : public openvdb::io::Archive {
 public:
  explicit Writer(std::uint32_t compression) { setCompression(compression); }
  using openvdb::io::Archive::write;
};

/// Two 64-bit FNV-1a hashes of the same bytes, with different start values: 128 bits.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (unsigned char byte : bytes)
      for (std::uint64_t& half : halves_) half = (half ^ byte) * 0x100000001b3ULL;
  }
  /// A UUID of version 8 (RFC 9562: made by the application).
  std::string identifier() const {
    constexpr const char* digits = "0123456789abcdef";
    std::string text = "xxxxxxxx-xxxx-8xxx-8xxx-xxxxxxxxxxxx";
    size_t nibble = 0;
    for (char& c : text) {
      if (c != 'x') continue;
      c = digits[halves_[nibble / 16] >> (nibble % 16 * 4) & 15];
      ++nibble;
    }
    return text;
  }

 private:
  std::array<std::uint64_t, 2> halves_{0xcbf29ce484222325ULL, 0x84222325cbf29ce4ULL};
};

/// Whether metadata of this name tells of where the values of an input were, which no longer holds: statistics of its
/// file, boxes, and regions of interest that programs mark.
bool isStale(const std::string& name) {
  if (name.compare(0, 5, "file_") == 0) return true;
  static const std::set<std::string> words{"roi",    "bbox",    "bounds",   "extent", "extents",
                                           "region", "regions", "checksum", "hash"};
  std::string word;
  for (char c : name + "/") {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      word += char(std::tolower(static_cast<unsigned char>(c)));
    } else {
      if (words.count(word)) return true;
      word.clear();
    }
  }
  return false;
}

void removeStale(openvdb::MetaMap& metadata) {
  std::vector<std::string> stale;
  for (auto item = metadata.beginMeta(); item != metadata.endMeta(); ++item)
    if (isStale(item->first)) stale.push_back(item->first);
  for (const std::string& name : stale) metadata.removeMeta(name);
}

/// A grid that shares the tree of `grid`, with our creator and without what no longer holds; statistics OpenVDB writes
/// anew.
openvdb::GridBase::Ptr stamped(const openvdb::GridBase& grid) {
  const openvdb::GridBase::Ptr copy = openvdb::ConstPtrCast<openvdb::GridBase>(grid.copyGrid());
  removeStale(*copy);
  copy->setCreator(kCreator);
  return copy;
}

}  // namespace

void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput& options) {
  initialiseVdb();
  AtomicFile file(path);
  openvdb::MetaMap metadata = options.metadata;
  removeStale(metadata);
  metadata.insertMeta("creator", openvdb::StringMetadata(kCreator));
  metadata.insertMeta("fps", openvdb::FloatMetadata(float(options.framesPerSecond)));
  metadata.insertMeta("frame", openvdb::Int32Metadata(options.frame));
  errno = 0;
  try {
    openvdb::GridCPtrVec stampedGrids;
    for (const auto& grid : grids) stampedGrids.push_back(stamped(*grid));
    std::ostream& stream = file.stream();
    Writer(options.compression).write(stream, stampedGrids, /*seekable=*/true, metadata);
    stream.flush();
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(path, std::string("cannot be written: ") + (errno ? std::strerror(errno) : error.what()));
  }
  Hash hash;
  file.read(kIdentifierAt + kIdentifierSize, [&](std::string_view bytes) { hash.add(bytes); });
  file.overwrite(kIdentifierAt, hash.identifier());
  file.commit();
}

}  // namespace slicemorph
