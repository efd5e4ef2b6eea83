#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// Registers OpenVDB's types and silences its log, which goes to stdout. Call before any VDB or grid is made;
/// may be called often and from any thread.
void initialiseVdb();

/// One grid of a VDB file, as its table of contents lists it.
struct VdbEntry {
  std::string name;  ///< `density`; `density[1]` for the second of several grids of one name
  std::string type;  ///< of the tree, for example `Tree_float_5_4_3`
  bool halfFloat = false;
};

/// A VDB file, read grid by grid, so that one that cannot be read does not affect the others. OpenVDB's own
/// reader trusts the sizes in a file; here the sizes of the contents, of metadata and of trees of numbers and
/// vectors are first checked against each other and against the file's size. (Trees of other types are only
/// as safe as OpenVDB is.) Everything throws IoError naming the file.
class VdbFile {
 public:
  /// Reads the table of contents; a truncated file is refused here.
  explicit VdbFile(const std::string& path);
  /// Grids in memory, as if they were a file's: what reads them gets copies that share their trees, which must not change
  /// as long as this lives. `name`: for messages.
  VdbFile(const std::string& name, const openvdb::GridPtrVec& grids);
  ~VdbFile();

  bool inMemory() const;
  const std::vector<VdbEntry>& entries() const;
  unsigned fileVersion() const;
  std::string libraryVersion() const;  ///< for example "10.0"

  /// Reads metadata and transform only; null for grid types that this OpenVDB does not know.
  openvdb::GridBase::Ptr readHeader(size_t index) const;
  openvdb::GridBase::Ptr read(size_t index) const;
  /// As read(), but values are mapped from the file (no copy of it is made) and loaded when they are first
  /// accessed: the file must not change as long as the grid lives.
  openvdb::GridBase::Ptr readDelayed(size_t index) const;

  /// Metadata of the file, not of its grids.
  const openvdb::MetaMap& metadata() const;
  /// Compression flags (openvdb::io) of the first grid of a known type; COMPRESS_NONE where there is none or
  /// the file has no grid offsets.
  std::uint32_t compression() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slicemorph
