#include "io/mesh/mesh_reader.h"

#include "io/format.h"
#include "io/mesh/file_kind.h"
#include "io/paths.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <cctype>

namespace slicemorph {
namespace {

/// Bytes. Reading takes some ten times a file's size of memory.
constexpr std::uint64_t kLargestMeshFile = std::uint64_t(2) << 30;

/// Throws IoError for a file whose content is of another kind than its name says.
void checkKind(const std::string& path, std::string_view bytes) {
  const std::string own = extensionOf(path);
  if (own == ".stl" && isWholeStl(bytes)) return;
  const FileKind kind = kindOfFile(bytes);
  if (kind.name.empty() || kind.extension == own) return;
  std::string known = own.substr(1);
  for (char& c : known) c = char(std::toupper(c));
  throw IoError(path, "is no " + known + " mesh: by its content it is " + kind.name +
                          (kind.extension.empty() ? "" : "; name it " + kind.extension));
}

}  // namespace

StoredMesh readPolygons(const InputSpec& input) {
  const std::string& path = input.path;
  if (sizeOfInput(path) > kLargestMeshFile)
    throw IoError(path, "is larger than 2 GiB, the most that is read of a mesh");
  const std::string bytes = readWholeFile(path);
  checkKind(path, bytes);
  StoredMesh stored;
  try {
    stored = input.format->readMesh(path, bytes);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(path, std::string("cannot be read: ") + error.what());
  }
  if (stored.points == 0) {
    stored.points = stored.mesh.points.size();
    stored.faces = stored.mesh.faceCount();
  }
  return stored;
}

RepairedMesh closeSurface(const std::string& path, const StoredMesh& stored) {
  const std::string hint = stored.endsInLine ? "; the file's last line has no end: is it cut short?" : "";
  RepairedMesh result;
  try {
    result = repairMesh(stored.mesh);
  } catch (const GeometryError& error) {
    throw GeometryError(path, error.what() + hint);
  }
  if (stored.endsInLine && result.found.boundaryLoops > 0) {
    throw IoError(path, "seems truncated: its last line has no end and its surface has " +
                            std::to_string(result.found.boundaryLoops) +
                            " holes; if it is whole, end it with a newline and the holes are filled");
  }
  Notes notes = stored.notes;
  notes.insert(notes.end(), result.notes.begin(), result.notes.end());
  result.notes = std::move(notes);
  return result;
}

}  // namespace slicemorph
