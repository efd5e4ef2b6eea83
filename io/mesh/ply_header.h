#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

/// A number type of a PLY file.
struct PlyType {
  int size = 0;  ///< bytes
  bool real = false, isSigned = false;
};

struct PlyProperty {
  std::string name;
  PlyType count;  ///< type of a list's length; of size 0: it is no list
  PlyType type;   ///< type of the value, or of one item of the list
  bool isList() const { return count.size > 0; }
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  bool text = false, bigEndian = false;
  std::vector<PlyElement> elements;  ///< in the order of the body
  size_t size = 0;                   ///< bytes up to the body
};

/// Parses the header. `bytes`: a whole file. Throws IoError naming `path` for a header that is cut
/// short or damaged.
PlyHeader readPlyHeader(const std::string& path, std::string_view bytes);

}  // namespace slicemorph
