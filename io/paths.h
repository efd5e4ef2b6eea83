#pragma once

#include <cstdint>
#include <string>

namespace slicemorph {

/// Lower case, with the dot; empty: there is none.
std::string extensionOf(const std::string& path);

/// Size of a file that is there to be read. Throws IoError for a missing, empty or unreadable one and for
/// folders and devices.
std::uint64_t sizeOfInput(const std::string& path);

/// An input of the command line: `file.vdb:grid` is a file and the name of a grid. A file whose whole name
/// exists is taken as that, whatever colons are in it.
struct InputName {
  std::string path;
  std::string grid;  ///< empty: none is named
};
InputName splitInput(const std::string& input);

/// Whether an input is a numbered sequence of VDB files, `name.####.vdb` or `name.####.vdb:grid`, and its two
/// parts.
bool isSequenceInput(const std::string& input);
InputName splitSequenceInput(const std::string& input);

}  // namespace slicemorph
