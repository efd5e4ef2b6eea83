#include "io/mesh/mesh_reader.h"

#include "io/format.h"
#include "io/mesh/far_origin.h"
#include "io/mesh/file_kind.h"
#include "io/paths.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <cctype>
#include <utility>

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

/// Voxels along a mesh for which its points are exact, whatever it is voxelised with.
constexpr double kVoxelsAlong = 1024;

StoredMesh withOrigin(StoredMesh stored) {
  std::vector<openvdb::Vec3s>& points = stored.mesh.points;
  if (points.empty()) return stored;
  const openvdb::BBoxd box = boundsOf(points);
  stored.origin = farOrigin(box, box.extents()[int(box.maxExtent())] / kVoxelsAlong);
  if (stored.origin != Vec3d(0.0)) {
    stored.rests.resize(points.size(), openvdb::Vec3s(0.f));
    for (size_t i = 0; i < points.size(); ++i)
      points[i] = openvdb::Vec3s(Vec3d(points[i]) - stored.origin + Vec3d(stored.rests[i]));
  }
  stored.rests = {};
  return stored;
}

void refuseCut(const std::string& path, const StoredMesh& stored, const MeshTopology& found) {
  if (!stored.endsInLine || found.boundaryLoops == 0) return;
  throw IoError(path, "seems truncated: its last line has no end and its surface has " +
                          std::to_string(found.boundaryLoops) +
                          " holes; if it is whole, end it with a newline and the holes are filled");
}

/// The file's notes, then those of repairs.
Notes allNotes(const StoredMesh& stored, const Notes& repairs) {
  Notes notes = stored.notes;
  notes.insert(notes.end(), repairs.begin(), repairs.end());
  return notes;
}

/// Calls `make` with the mesh made ready; adds the file's name to what it throws.
template <typename Make>
auto withSolid(const std::string& path, const StoredMesh& stored, const Make& make) {
  const std::string hint = stored.endsInLine ? "; the file's last line has no end: is it cut short?" : "";
  try {
    SolidMesh mesh = prepareSolid(stored.mesh);
    refuseCut(path, stored, mesh.found);
    return make(std::move(mesh));
  } catch (const GeometryError& error) {
    throw GeometryError(path, error.what() + hint);
  }
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
  return withOrigin(std::move(stored));
}

MeshSolid solidOfFile(const std::string& path, const StoredMesh& stored, const SolidOptions& options,
                      const std::function<void(const SolidMesh&)>& check) {
  return withSolid(path, stored, [&](SolidMesh mesh) {
    refuseSheets(mesh, options);
    check(mesh);
    MeshSolid solid = solidOf(std::move(mesh), options);
    solid.notes = allNotes(stored, solid.notes);
    return solid;
  });
}

Notes checkSolid(const std::string& path, const StoredMesh& stored, const SolidOptions& options) {
  return withSolid(path, stored, [&](const SolidMesh& mesh) {
    refuseSheets(mesh, options);
    return allNotes(stored, inOneLine(mesh.notes));
  });
}

}  // namespace slicemorph
