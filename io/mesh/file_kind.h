#pragma once

#include <string>
#include <string_view>

namespace slicemorph {

/// What a file's content is, whatever its name says. `name`: for messages ("a PNG picture"); empty: unknown, or
/// of no kind that is told apart. `extension`: of formats that are read as meshes, else empty.
struct FileKind {
  std::string name, extension;
};

/// Recognises files by their first bytes: pictures, archives, pages, other 3D formats, and meshes.
FileKind kindOfFile(std::string_view bytes);

/// Whether a binary STL has exactly the size that its count says: then it is one, whatever its header says.
bool isWholeStl(std::string_view bytes);

}  // namespace slicemorph
