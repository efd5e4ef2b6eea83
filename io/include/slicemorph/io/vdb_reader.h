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

/// A VDB file, read grid by grid so that one that cannot be read leaves the others. OpenVDB's own reader
/// takes sizes in the file at their word; here they are first compared with each other and with what the file
/// can hold: those of the contents, the metadata and of trees of numbers and vectors. (Trees of other types
/// are only as safe as OpenVDB is.) Everything throws IoError naming the file.
class VdbFile {
 public:
  /// Reads the table of contents; a truncated file is refused here.
  explicit VdbFile(const std::string& path);
  ~VdbFile();

  const std::vector<VdbEntry>& entries() const;
  unsigned fileVersion() const;
  std::string libraryVersion() const;  ///< for example "10.0"

  /// Metadata and transform only, for a look at the class; null for grid types this OpenVDB does not know.
  openvdb::GridBase::Ptr readHeader(size_t index) const;
  openvdb::GridBase::Ptr read(size_t index) const;
  /// As read(), but values are mapped from the file (no copy of it is made) and read where they are first
  /// looked at: the file must not change as long as the grid lives.
  openvdb::GridBase::Ptr readDelayed(size_t index) const;

  /// Of the file, not of its grids.
  const openvdb::MetaMap& metadata() const;
  /// Flags of openvdb::io of the first grid; of the file where it has none.
  std::uint32_t compression() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slicemorph
