#pragma once

#include "io/image/nrrd_header.h"

namespace slicemorph {

/// The bytes of an NRRD file's numbers, `bytes` of them in all, in the machine's byte order and as numbers even where
/// they are stored as text. `path`: of the header, for errors. Throws IoError where a file is missing, or is seen to be
/// cut short before it is read.
ByteReader openNrrdData(const std::string& path, const NrrdData& data, RawType type, std::uint64_t bytes);

}  // namespace slicemorph
