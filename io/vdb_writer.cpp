#include "io/vdb_writer.h"

#include "engine/errors.h"
#include "io/atomic_file.h"
#include "io/vdb_reader.h"

#include <openvdb/io/Archive.h>

#include <array>
#include <cstdint>
#include <sstream>
#include <string_view>

namespace slicemorph {
namespace {

constexpr const char* kCreator = "slicemorph 0.1.0";

/// In the file: magic number (8), file version (4), library version (2 x 4), grid offsets (1), then the identifier.
constexpr size_t kIdentifierAt = 21, kIdentifierSize = 36;

class Writer : public openvdb::io::Archive {
 public:
  std::string bytes(const openvdb::GridBase::ConstPtr& grid, const openvdb::MetaMap& metadata) const {
    std::ostringstream stream(std::ios::binary);
    stream.exceptions(std::ios::failbit | std::ios::badbit);
    write(stream, openvdb::GridCPtrVec{grid}, /*seekable=*/true, metadata);
    return std::move(stream).str();
  }
};

/// FNV-1a, started anew for each half of the identifier.
std::uint64_t hashOf(std::string_view bytes, std::uint64_t hash) {
  for (unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3ULL;
  return hash;
}

/// A UUID of version 8 (RFC 9562: made by the application) from a hash of everything behind it.
std::string identifierOf(std::string_view content) {
  constexpr const char* digits = "0123456789abcdef";
  const std::array<std::uint64_t, 2> halves{hashOf(content, 0xcbf29ce484222325ULL),
                                            hashOf(content, 0x84222325cbf29ce4ULL)};
  std::string text = "xxxxxxxx-xxxx-8xxx-8xxx-xxxxxxxxxxxx";
  size_t nibble = 0;
  for (char& c : text) {
    if (c != 'x') continue;
    c = digits[halves[nibble / 16] >> (nibble % 16 * 4) & 15];
    ++nibble;
  }
  return text;
}

void replaceIdentifier(std::string& bytes) {
  const std::string identifier = identifierOf(std::string_view(bytes).substr(kIdentifierAt + kIdentifierSize));
  bytes.replace(kIdentifierAt, kIdentifierSize, identifier);
}

openvdb::MetaMap sequenceMetadata(const SurfaceOutput& options) {
  openvdb::MetaMap metadata;
  metadata.insertMeta("creator", openvdb::StringMetadata(kCreator));
  metadata.insertMeta("fps", openvdb::FloatMetadata(float(options.framesPerSecond)));
  metadata.insertMeta("frame", openvdb::Int32Metadata(options.frame));
  return metadata;
}

}  // namespace

void writeVdb(const std::string& path, const FloatGrid& levelSet, const SurfaceOutput& options) {
  initialiseVdb();
  AtomicFile file(path);
  const openvdb::MetaMap metadata = sequenceMetadata(options);
  std::string bytes;
  try {
    // The grid shares the caller's tree and has metadata of its own.
    FloatGrid::Ptr grid = FloatGrid::create(openvdb::ConstPtrCast<openvdb::FloatTree>(levelSet.treePtr()));
    grid->insertMeta(levelSet);
    grid->setTransform(levelSet.transform().copy());
    grid->setName("surface");
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    grid->setCreator(kCreator);
    grid->setSaveFloatAsHalf(options.halfFloat);
    grid->insertMeta("fps", *metadata["fps"]);
    grid->insertMeta("frame", *metadata["frame"]);
    bytes = Writer().bytes(grid, metadata);
  } catch (const std::exception& error) {
    throw IoError(path + " cannot be written: " + error.what());
  }
  replaceIdentifier(bytes);
  file.write(bytes);
  file.commit();
}

}  // namespace slicemorph
