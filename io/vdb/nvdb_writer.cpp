#include "io/vdb/nvdb_writer.h"

#include "io/atomic_file.h"
#include "slicemorph/errors.h"

#include <openvdb/openvdb.h>

#include <cerrno>
#include <cstring>
#include <vector>

// In this order: the first makes OpenVDB's types known to NanoVDB.
#include <nanovdb/util/OpenToNanoVDB.h>

#include <nanovdb/util/IO.h>

namespace slicemorph {
namespace {

/// Memory for a grid that begins as zeros: NanoVDB leaves gaps between its parts as they were.
class ZeroedBuffer {
 public:
  static ZeroedBuffer create(uint64_t size, const ZeroedBuffer* = nullptr) {
    ZeroedBuffer buffer;
    buffer.bytes_.resize((size + sizeof(Block) - 1) / sizeof(Block));
    buffer.size_ = size;
    return buffer;
  }
  uint8_t* data() { return bytes_.empty() ? nullptr : bytes_[0].bytes; }
  const uint8_t* data() const { return bytes_.empty() ? nullptr : bytes_[0].bytes; }
  uint64_t size() const { return size_; }
  void clear() { bytes_.clear(), size_ = 0; }

 private:
  struct alignas(NANOVDB_DATA_ALIGNMENT) Block {
    uint8_t bytes[NANOVDB_DATA_ALIGNMENT] = {};
  };
  std::vector<Block> bytes_;
  uint64_t size_ = 0;
};

using Handle = nanovdb::GridHandle<ZeroedBuffer>;
using HeldGrids =
    openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid,
                      openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::MaskGrid, openvdb::BoolGrid>;

Handle nanoGrid(const std::string& path, const openvdb::GridBase& grid) {
  const std::string name = "grid '" + grid.getName() + "'";
  if (!grid.transform().isLinear())
    throw InputError(path,
                     name + " has a transform that is not linear, which NanoVDB cannot hold; write a .vdb");
  Handle handle;
  const bool held =
      grid.apply<HeldGrids>([&](const auto& typed) { handle = nanovdb::openToNanoVDB<ZeroedBuffer>(typed); });
  if (!held)
    throw InputError(path,
                     name + " holds " + grid.valueType() +
                         ", which NanoVDB has no place for; leave it out with --grids, or write a .vdb");
  return handle;
}

}  // namespace

void writeNvdb(const std::string& path, const openvdb::GridCPtrVec& grids, const VdbOutput&) {
  std::vector<Handle> handles;
  for (const auto& grid : grids) handles.push_back(nanoGrid(path, *grid));
  AtomicFile file(path);
  errno = 0;
  try {
    std::ostream& stream = file.stream();
    nanovdb::io::writeGrids<ZeroedBuffer, std::vector>(stream, handles);
    stream.flush();
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(path, std::string("cannot be written: ") + (errno ? std::strerror(errno) : error.what()));
  }
  file.commit();
}

}  // namespace slicemorph
