#include "slicemorph/io/mesh_writer.h"

#include "io/atomic_file.h"
#include "io/format.h"
#include "io/mesh/glb_writer.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace slicemorph {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "binary PLY and STL are written as they lie in memory");

std::string textOf(MeshSpace space) { return space == MeshSpace::kRas ? "SPACE=RAS" : "SPACE=LPS"; }

/// LPS to RAS: half a turn about z, which keeps the winding.
Mesh inRas(Mesh mesh) {
  for (openvdb::Vec3s& p : mesh.points) p[0] = -p[0], p[1] = -p[1];
  mesh.origin[0] = -mesh.origin[0], mesh.origin[1] = -mesh.origin[1];
  return mesh;
}

/// Builds one line of text after the other in the same memory.
class Line {
 public:
  Line& begin(char kind) {
    text_.assign(1, kind);
    return *this;
  }
  template <typename Number>
  Line& add(Number value) {
    char digits[32];
    const char* end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    text_ += ' ';
    text_.append(digits, size_t(end - digits));
    return *this;
  }
  Line& add(const openvdb::Vec3s& v) { return add(v[0]).add(v[1]).add(v[2]); }
  Line& add(const Vec3d& v) { return add(v[0]).add(v[1]).add(v[2]); }
  std::string_view end() { return text_ += '\n'; }

 private:
  std::string text_;
};

bool isFar(const Mesh& mesh) { return mesh.origin != Vec3d(0.0); }

/// A point's place as single precision has it.
openvdb::Vec3s placeOf(const Mesh& mesh, size_t i) {
  return isFar(mesh) ? openvdb::Vec3s(Vec3d(mesh.points[i]) + mesh.origin) : mesh.points[i];
}

template <typename T>
void writeRaw(AtomicFile& file, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  file.write({reinterpret_cast<const char*>(&value), sizeof value});
}

struct __attribute__((packed)) PlyFace {
  std::uint8_t count;
  std::uint32_t corners[3];
};

std::uint8_t toByte(float share) { return std::uint8_t(std::lround(std::clamp(share, 0.f, 1.f) * 255)); }

struct __attribute__((packed)) StlFacet {
  float normal[3];
  float corners[3][3];
  std::uint16_t attributes;
};

}  // namespace

void writeObj(const std::string& path, const Mesh& mesh, MeshSpace space) {
  AtomicFile file(path);
  if (space != MeshSpace::kUnsaid) file.write("# " + textOf(space) + "\n");
  Line line;
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    line.begin('v');
    if (isFar(mesh))
      line.add(Vec3d(mesh.points[i]) + mesh.origin);
    else
      line.add(mesh.points[i]);
    if (!mesh.colors.empty()) line.add(mesh.colors[i]);
    file.write(line.end());
  }
  for (const openvdb::Vec3I& t : mesh.triangles) {
    file.write(line.begin('f').add(t[0] + 1).add(t[1] + 1).add(t[2] + 1).end());
  }
  file.commit();
}

void writePly(const std::string& path, const Mesh& mesh, MeshSpace space) {
  AtomicFile file(path);
  const bool colored = !mesh.colors.empty(), far = isFar(mesh);
  const std::string number = far ? "double" : "float",
                    colors = colored ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "";
  const std::string comment = space == MeshSpace::kUnsaid ? "" : "comment " + textOf(space) + "\n";
  file.write("ply\nformat binary_little_endian 1.0\n" + comment + "element vertex " +
             std::to_string(mesh.points.size()) + "\nproperty " + number + " x\nproperty " + number +
             " y\nproperty " + number + " z\n" + colors + "element face " +
             std::to_string(mesh.triangles.size()) +
             "\nproperty list uchar uint vertex_indices\nend_header\n");
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3d place = Vec3d(mesh.points[i]) + mesh.origin;
    if (far)
      file.write({reinterpret_cast<const char*>(place.asPointer()), 24});
    else
      file.write({reinterpret_cast<const char*>(mesh.points[i].asPointer()), 12});
    if (!colored) continue;
    const openvdb::Vec3s& c = mesh.colors[i];
    writeRaw(file, std::array<std::uint8_t, 3>{toByte(c[0]), toByte(c[1]), toByte(c[2])});
  }
  for (const openvdb::Vec3I& t : mesh.triangles) writeRaw(file, PlyFace{3, {t[0], t[1], t[2]}});
  file.commit();
}

void writeStl(const std::string& path, const Mesh& mesh, MeshSpace space) {
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw IoError(path, "cannot be written: STL holds at most 2^32 - 1 triangles; use .ply");
  }
  AtomicFile file(path);
  char header[80] = "slicemorph";
  if (space != MeshSpace::kUnsaid) std::strncat(header, (" " + textOf(space)).c_str(), 20);
  file.write({header, sizeof header});
  writeRaw(file, std::uint32_t(mesh.triangles.size()));
  for (const openvdb::Vec3I& t : mesh.triangles) {
    StlFacet facet{};
    const openvdb::Vec3d a(mesh.points[t[0]]), b(mesh.points[t[1]]), c(mesh.points[t[2]]);
    openvdb::Vec3d normal = (b - a).cross(c - a);
    if (!normal.normalize(0.0)) normal = openvdb::Vec3d(0.0);
    for (int i = 0; i < 3; ++i) {
      facet.normal[i] = float(normal[i]);
      std::memcpy(facet.corners[i], placeOf(mesh, t[i]).asPointer(), sizeof facet.corners[i]);
    }
    writeRaw(file, facet);
  }
  file.commit();
}

void writeStillGlb(const std::string& path, const Mesh& mesh, MeshSpace) {
  std::vector<std::vector<openvdb::Vec3s>> colors;
  if (!mesh.colors.empty()) colors.push_back(mesh.colors);
  std::vector<openvdb::Vec3s> places(mesh.points.size());
  for (size_t i = 0; i < places.size(); ++i) places[i] = placeOf(mesh, i);
  writeGlb(path, {{0, mesh.triangles, {std::move(places)}, colors}});
}

void writeMesh(const std::string& path, const Mesh& mesh, MeshSpace space) {
  const Format* format = formatToWrite(path);
  if (!format || !format->writeMesh)
    throw InputError(path, "no mesh format that can be written has this extension; use " +
                               writableList(Contents::kMesh, ", "));
  format->writeMesh(path, space == MeshSpace::kRas ? inRas(mesh) : mesh, space);
}

}  // namespace slicemorph
