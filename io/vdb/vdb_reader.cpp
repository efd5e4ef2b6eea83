#include "slicemorph/io/vdb_reader.h"

#include "io/paths.h"
#include "io/vdb/vdb_check.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"

#include <log4cplus/logger.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/File.h>
#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <mutex>
#include <string_view>
#include <system_error>

namespace slicemorph {
namespace {

using openvdb::GridBase;
using openvdb::io::GridDescriptor;

// Versions of the format as openvdb/version.h numbers them
// (SELECTIVE_COMPRESSION, GRID_INSTANCING, NODE_MASK_COMPRESSION).
/// Since this version a grid begins with its compression flags.
constexpr unsigned kFirstWithGridCompression = 220;
/// Since this version a descriptor holds the name of the grid whose tree it shares.
constexpr unsigned kFirstWithInstances = 216;
/// The oldest whose trees are read: others wrote them before OpenVDB was public (BOOL_LEAF_OPTIMIZATION).
constexpr unsigned kFirstRead = 217;
/// Since this version the boxes of frustums are floating point (FLOAT_FRUSTUM_BBOX).
constexpr unsigned kFirstWithFloatBoxes = 221;
/// Since this version inactive values are left out.
constexpr unsigned kFirstWithMasks = 222;

/// Reads a file's parts through the members of OpenVDB's Archive that take any stream.
class Reader : public openvdb::io::Archive {
 public:
  Reader(const std::string& path, std::uint64_t size) : stream_(path, std::ios::binary), size_(size) {
    if (!stream_) throw std::system_error(errno, std::generic_category(), "it cannot be opened");
    // A read beyond the end throws, wherever in OpenVDB it happens.
    stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader(stream_);
    contents_ = stream_.tellg();
    metadata_.reset(new openvdb::io::StreamMetadata);
    metadata_->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
  }

  unsigned version() const { return fileVersion(); }
  bool hasOffsets() const { return inputHasGridOffsets(); }

  /// Reads the metadata of the file; returns the number of grids.
  std::uint32_t beginContents(openvdb::MetaMap& metadata) {
    stream_.seekg(contents_);
    Walker(stream_, size_).metadata();
    stream_.seekg(contents_);
    metadata.readMeta(stream_);
    return Walker(stream_, size_).number<std::uint32_t>();
  }

  GridDescriptor readDescriptor() {
    const auto begin = stream_.tellg();
    Walker walker(stream_, size_);
    walker.text();
    walker.text();
    if (version() >= kFirstWithInstances) walker.text();
    stream_.seekg(begin);
    GridDescriptor descriptor = readNames();
    if (!hasOffsets()) return descriptor;
    const std::int64_t here = stream_.tellg(), end = descriptor.getEndPos();
    if (descriptor.getGridPos() < here || descriptor.getBlockPos() < descriptor.getGridPos() ||
        end < descriptor.getBlockPos()) {
      throw Damaged("its table of contents is damaged");
    }
    if (std::uint64_t(end) > size_) {
      throw Damaged("it is truncated: grid '" + GridDescriptor::nameAsString(descriptor.uniqueName()) +
                    "' ends at byte " + std::to_string(end) + ", the file has " + std::to_string(size_));
    }
    return descriptor;
  }

  /// Instead of OpenVDB's own function, which refuses a whole file for one grid of an unknown type.
  GridDescriptor readNames() {
    constexpr std::string_view kHalf = "_HalfFloat";
    const std::string name = openvdb::readString(stream_);
    std::string type = openvdb::readString(stream_);
    const bool half =
        type.size() > kHalf.size() && type.compare(type.size() - kHalf.size(), kHalf.size(), kHalf) == 0;
    if (half) type.resize(type.size() - kHalf.size());
    GridDescriptor descriptor(name, type, half);
    if (version() >= kFirstWithInstances) descriptor.setInstanceParentName(openvdb::readString(stream_));
    std::int64_t positions[3];
    stream_.read(reinterpret_cast<char*>(positions), sizeof positions);
    descriptor.setGridPos(positions[0]);
    descriptor.setBlockPos(positions[1]);
    descriptor.setEndPos(positions[2]);
    return descriptor;
  }

  void skipGrid(const GridDescriptor& descriptor) { descriptor.seekToEnd(stream_); }

  void checkGridMetadata() {
    const auto begin = stream_.tellg();
    Walker walker(stream_, size_);
    if (version() >= kFirstWithGridCompression) walker.number<std::uint32_t>();
    walker.metadata();
    stream_.seekg(begin);
  }

  GridBase::Ptr readHeaderOf(const GridDescriptor& descriptor) {
    GridBase::Ptr grid = begin(descriptor);
    if (!grid) return grid;
    readGridCompression(stream_);
    grid->readMeta(stream_);
    checkTransform();
    grid->readTransform(stream_);
    return grid;
  }

  GridBase::Ptr readWhole(const GridDescriptor& descriptor) {
    const auto start = checkGrid(descriptor);
    stream_.seekg(start);
    const GridBase::Ptr grid = create(descriptor);
    readGrid(grid, descriptor, stream_);
    return grid;
  }

  /// Returns where the grid starts. `later`: its leaves will be read when they are asked for. Throws Damaged.
  std::istream::pos_type checkGrid(const GridDescriptor& descriptor, bool later = false) {
    if (hasOffsets()) descriptor.seekToGrid(stream_);
    const auto start = stream_.tellg();
    const GridBase::Ptr grid = readHeaderOf(descriptor);
    if (!grid) throw Damaged("its type " + descriptor.gridType() + " is not known to this OpenVDB");
    if (!descriptor.isInstance()) checkTreeOf(*grid, later);
    return start;
  }

  std::uint32_t compressionOf(const GridDescriptor& descriptor) {
    readHeaderOf(descriptor);
    return openvdb::io::getDataCompression(stream_);
  }

 private:
  /// Names of transforms have lengths, for which OpenVDB allocates.
  void checkTransform() {
    const auto begin = stream_.tellg();
    Walker walker(stream_, size_);
    // A frustum has a box, of whole numbers in older files, a taper, a depth, and a transform within.
    const std::uint64_t box = 6 * (version() < kFirstWithFloatBoxes ? sizeof(std::int32_t) : sizeof(double));
    while (walker.typeName() == openvdb::math::NonlinearFrustumMap::mapType())
      walker.skip(box + 2 * sizeof(double));
    stream_.seekg(begin);
  }

  GridBase::Ptr begin(const GridDescriptor& descriptor) {
    if (!GridBase::isRegistered(descriptor.gridType())) return nullptr;
    if (hasOffsets()) descriptor.seekToGrid(stream_);
    checkGridMetadata();
    return create(descriptor);
  }

  static GridBase::Ptr create(const GridDescriptor& descriptor) {
    GridBase::Ptr grid = GridBase::createGrid(descriptor.gridType());
    grid->setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
    return grid;
  }

  /// Sets `storage` for the types of trees that are read; false for any other.
  static bool storageOf(const GridBase& grid, TreeStorage& storage) {
    using Types = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid,
                                    openvdb::Vec3IGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                                    openvdb::BoolGrid, openvdb::MaskGrid>;
    storage.leaves = grid.isType<openvdb::BoolGrid>()   ? LeafKind::kBools
                     : grid.isType<openvdb::MaskGrid>() ? LeafKind::kMask
                                                        : LeafKind::kValues;
    return grid.apply<Types>([&](const auto& typed) {
      using Value = typename std::decay_t<decltype(typed)>::ValueType;
      using Stored = typename openvdb::io::RealToHalf<Value>::HalfT;
      storage.valueSize = sizeof(Value);
      storage.storedSize = grid.saveFloatAsHalf() ? sizeof(Stored) : sizeof(Value);
    });
  }

  /// The stream must be right after the grid's transform.
  void checkTreeOf(const GridBase& grid, bool later) {
    TreeStorage storage;
    if (version() < kFirstRead)
      throw Damaged("its format is of version " + std::to_string(version()) + ", before " +
                    std::to_string(kFirstRead) + "; write it again with a newer OpenVDB");
    if (!storageOf(grid, storage)) throw Damaged("trees of its type, " + grid.type() + ", are not read");
    if (later)
      storage.listed =
          dynamic_cast<const openvdb::io::DelayedLoadMetadata*>(grid[GridBase::META_FILE_DELAYED_LOAD].get());
    storage.saysWhatIsLeftOut = version() >= kFirstWithMasks;
    storage.compression = openvdb::io::getDataCompression(stream_);
    Walker walker(stream_, size_);
    checkTree(walker, storage);
  }

  std::ifstream stream_;
  std::uint64_t size_;
  std::istream::pos_type contents_;
  openvdb::io::StreamMetadata::Ptr metadata_;
};

/// What error messages are about, and how they say that it failed.
struct Attempt {
  std::string about, failure;
};

/// Runs `action`; whatever OpenVDB, Boost or the standard library throw becomes an IoError.
template <typename Action>
auto guarded(const Attempt& attempt, const Action& action) {
  const auto fail = [&](const std::string& why) {
    return IoError(attempt.about, attempt.failure + ": " + why);
  };
  try {
    return action();
  } catch (const IoError&) {
    throw;
  } catch (const std::ios_base::failure&) {
    throw fail("it is truncated or damaged: the file ends inside the data");
  } catch (const std::bad_alloc&) {
    throw fail("it is damaged, or larger than the memory");
  } catch (const std::exception& error) {
    throw fail(error.what());
  }
}

std::vector<VdbEntry> entriesOf(const std::vector<GridDescriptor>& descriptors) {
  std::map<std::string, size_t> total, seen;
  for (const GridDescriptor& d : descriptors) ++total[d.gridName()];
  std::vector<VdbEntry> entries;
  for (const GridDescriptor& d : descriptors) {
    const std::string suffix =
        total[d.gridName()] > 1 ? "[" + std::to_string(seen[d.gridName()]++) + "]" : "";
    entries.push_back({d.gridName() + suffix, d.gridType(), d.saveFloatAsHalf()});
  }
  return entries;
}

}  // namespace

void initialiseVdb() {
  static std::once_flag once;
  std::call_once(once, [] {
    openvdb::initialize();
    log4cplus::Logger::getInstance(LOG4CPLUS_TEXT("openvdb")).setLogLevel(log4cplus::OFF_LOG_LEVEL);
  });
}

struct VdbFile::Impl {
  std::string path;
  std::uint64_t size = 0;
  unsigned fileVersion = 0;
  std::string libraryVersion;
  openvdb::MetaMap metadata;
  std::uint32_t compression = openvdb::io::COMPRESS_NONE;
  std::vector<GridDescriptor> descriptors;
  std::vector<VdbEntry> entries;
  bool inMemory = false;
  std::vector<GridBase::Ptr>
      streamed;  // all grids of memory, or of a file without offsets, which is read in order

  void readContents() {
    Reader reader(path, size);
    fileVersion = reader.version();
    const auto library = reader.libraryVersion();
    libraryVersion = std::to_string(library.first) + "." + std::to_string(library.second);
    for (auto count = reader.beginContents(metadata); count > 0; --count) {
      descriptors.push_back(reader.readDescriptor());
      if (reader.hasOffsets()) {
        reader.skipGrid(descriptors.back());
      } else {
        streamed.push_back(reader.readWhole(descriptors.back()));
      }
    }
    entries = entriesOf(descriptors);
    for (const GridDescriptor& d : descriptors)
      if (reader.hasOffsets() && GridBase::isRegistered(d.gridType())) {
        compression = Reader(path, size).compressionOf(d);
        break;
      }
  }

  GridBase::Ptr readDelayed(size_t index) const {
    // Only openvdb::io::File can read with delay, and it has to know the types of all grids of the file.
    const bool known = std::all_of(descriptors.begin(), descriptors.end(), [](const GridDescriptor& d) {
      return GridBase::isRegistered(d.gridType());
    });
    if (!streamed.empty() || !known || descriptors.at(index).isInstance()) return readConnected(index);
    Reader(path, size).checkGrid(descriptors[index], /*later=*/true);
    openvdb::io::File file(path);
    file.setCopyMaxBytes(0);
    file.open(/*delayLoad=*/true);
    return file.readGrid(GridDescriptor::nameAsString(descriptors[index].uniqueName()));
  }

  GridBase::Ptr readOwn(size_t index) const {
    if (inMemory) return streamed.at(index)->copyGrid();
    return streamed.empty() ? Reader(path, size).readWhole(descriptors.at(index)) : streamed.at(index);
  }

  /// Reads a grid; an instance gets the tree of the grid that it shares one with.
  GridBase::Ptr readConnected(size_t index) const {
    const GridBase::Ptr grid = readOwn(index);
    if (!descriptors[index].isInstance()) return grid;
    for (size_t i = 0; i < descriptors.size(); ++i) {
      const bool parent = descriptors[i].uniqueName() == descriptors[index].instanceParentName();
      if (!parent || descriptors[i].isInstance() ||
          descriptors[i].gridType() != descriptors[index].gridType())
        continue;
      grid->setTree(readOwn(i)->baseTreePtr());
      return grid;
    }
    throw Damaged("the grid whose tree it shares is missing");
  }

  Attempt attempt(size_t index) const {
    return {path, "grid '" + entries.at(index).name + "' cannot be read"};
  }
};

VdbFile::VdbFile(const std::string& path) : impl_(std::make_unique<Impl>()) {
  initialiseVdb();
  impl_->path = path;
  impl_->size = sizeOfInput(path);
  guarded({path, "cannot be read as a VDB file"}, [&] { impl_->readContents(); });
}

VdbFile::VdbFile(const std::string& name, const openvdb::GridPtrVec& grids)
    : impl_(std::make_unique<Impl>()) {
  initialiseVdb();
  impl_->path = name, impl_->inMemory = true;
  impl_->fileVersion = openvdb::OPENVDB_FILE_VERSION;
  impl_->libraryVersion = std::to_string(openvdb::OPENVDB_LIBRARY_MAJOR_VERSION) + "." +
                          std::to_string(openvdb::OPENVDB_LIBRARY_MINOR_VERSION);
  impl_->compression = VdbOutput().compression;
  impl_->streamed = grids;
  for (const GridBase::Ptr& grid : grids)
    impl_->descriptors.emplace_back(grid->getName(), grid->type(), grid->saveFloatAsHalf());
  impl_->entries = entriesOf(impl_->descriptors);
}

VdbFile::~VdbFile() = default;

bool VdbFile::inMemory() const { return impl_->inMemory; }
const std::vector<VdbEntry>& VdbFile::entries() const { return impl_->entries; }
unsigned VdbFile::fileVersion() const { return impl_->fileVersion; }
std::string VdbFile::libraryVersion() const { return impl_->libraryVersion; }

GridBase::Ptr VdbFile::readHeader(size_t index) const {
  return guarded(impl_->attempt(index), [&] {
    return impl_->streamed.empty()
               ? Reader(impl_->path, impl_->size).readHeaderOf(impl_->descriptors.at(index))
               : impl_->streamed.at(index);
  });
}

GridBase::Ptr VdbFile::read(size_t index) const {
  return guarded(impl_->attempt(index), [&] { return impl_->readConnected(index); });
}

GridBase::Ptr VdbFile::readDelayed(size_t index) const {
  return guarded(impl_->attempt(index), [&] { return impl_->readDelayed(index); });
}

const openvdb::MetaMap& VdbFile::metadata() const { return impl_->metadata; }
std::uint32_t VdbFile::compression() const { return impl_->compression; }

}  // namespace slicemorph
