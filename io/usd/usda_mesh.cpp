#include "io/usd/usda_mesh.h"

#include "io/atomic_file.h"
#include "io/mesh/vertex_normals.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/mesh_writer.h"

#include <cerrno>
#include <cstring>

namespace slicemorph {

// A writer of the table of formats; see formats.cpp.
void writeUsda(const std::string& path, const Mesh& mesh, MeshSpace space);

namespace {

using openvdb::Vec3s;
using Vectors = std::vector<Vec3s>;

/// An attribute of a Mesh that changes with time, in the order of their names.
struct MeshAttribute {
  const char *type, *name;
  bool optional;   ///< left out where no frame has values
  bool perVertex;  ///< a primvar of which there is one at each point
};

constexpr MeshAttribute kAttributes[] = {
    {"float3[]", "extent", true, false},          {"int[]", "faceVertexCounts", false, false},
    {"int[]", "faceVertexIndices", false, false}, {"normal3f[]", "normals", true, true},
    {"point3f[]", "points", false, false},        {"color3f[]", "primvars:displayColor", true, true},
    {"vector3f[]", "velocities", true, false}};
constexpr size_t kAttributeCount = std::size(kAttributes);
constexpr const char* kIndent = "        ";
constexpr size_t kPart = size_t(1) << 20;  // bytes that are copied at once

template <typename Items, typename Add>
std::string listOf(const Items& items, Add add) {
  std::string text = "[";
  for (size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += ", ";
    add(text, items[i]);
  }
  return text + "]";
}

std::string vectorList(const Vectors& vectors) {
  return listOf(vectors, [](std::string& text, const Vec3s& v) { addVector(text, v); });
}

/// Values that not every frame has: where it has none but points, there is no value.
std::string vectorsAt(const Vectors& vectors, const Vectors& points) {
  return vectors.size() == points.size() ? vectorList(vectors) : "None";
}

/// Whether an attribute's value says nothing.
bool isNothing(const std::string& value) { return value == "None" || value == "[]"; }

std::string extentOf(const Vectors& points) {
  openvdb::BBoxd box;
  for (const Vec3s& p : points) box.expand(Vec3d(p));
  return usdaExtent(box);
}

/// The value of an attribute of the table; one after the other, as each text is large. `points`: the mesh's, which may
/// be moved.
std::string valueOf(size_t attribute, const Mesh& mesh, const Vectors& points, const Vectors& velocities) {
  switch (attribute) {
    case 0:
      return extentOf(points);
    case 1:
      return listOf(mesh.triangles, [](std::string& text, const openvdb::Vec3I&) { text += '3'; });
    case 2:
      return listOf(mesh.triangles, [](std::string& text, const openvdb::Vec3I& t) {
        for (int i = 0; i < 3; ++i) text += i ? ", " : "", addNumber(text, t[i]);
      });
    case 3:
      return vectorList(vertexNormals(mesh.triangles, points));
    case 4:
      return vectorList(points);
    case 5:
      return vectorsAt(mesh.colors, points);
    default:
      return vectorsAt(velocities, points);
  }
}

/// The stage up to the mesh's attributes.
std::string beginOf(const std::string& path, const UsdaStage& stage,
                    const std::optional<std::pair<int, int>>& frames, const Vec3d& origin) {
  const std::string name = usdaNameOfFile(path);
  std::string text = usdaHeader(stage, name, frames) + "def Xform \"" + name +
                     "\" (\n    kind = \"component\"\n)\n{\n    def Mesh \"surface\"\n    {\n";
  text += std::string(kIndent) + "uniform token subdivisionScheme = \"none\"\n";
  if (origin == Vec3d(0.0)) return text;
  text += std::string(kIndent) + "double3 xformOp:translate = ";
  addVector(text, origin);
  return text + "\n" + kIndent + "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
}

constexpr const char* kEnd = "    }\n}\n";

std::string declared(const MeshAttribute& attribute) {
  return std::string(kIndent) + attribute.type + " " + attribute.name;
}

/// Of primvars: that there is one at each point.
std::string perVertex(const char* indent) {
  return std::string(" (\n") + indent + "    interpolation = \"vertex\"\n" + indent + ")";
}

}  // namespace

void writeUsdaMesh(const std::string& path, const Mesh& mesh, const UsdaStage& stage) {
  AtomicFile file(path);
  file.write(beginOf(path, stage, std::nullopt, mesh.origin));
  for (size_t a = 0; a < kAttributeCount; ++a) {
    const std::string value = valueOf(a, mesh, mesh.points, {});
    if (kAttributes[a].optional && isNothing(value)) continue;
    file.write(declared(kAttributes[a]) + " = ");
    file.write(value);
    file.write((kAttributes[a].perVertex ? perVertex(kIndent) : "") + "\n");
  }
  file.write(kEnd);
  file.commit();
}

void writeUsda(const std::string& path, const Mesh& mesh, MeshSpace space) {
  UsdaStage stage;
  // Scans and contours are in millimetres, and their z points up.
  if (space != MeshSpace::kUnsaid) stage.metres = 1e-3, stage.zUp = true;
  writeUsdaMesh(path, mesh, stage);
}

/// The samples of an attribute, as text.
struct UsdaMeshWriter::Samples {
  explicit Samples(const std::string& file)
      : path(file), stream(file, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc) {}

  void add(int number, const std::string& value) {
    errno = 0;
    stream << kIndent << "    " << number << ": " << value << ",\n";
    if (!stream.flush()) throw IoError(path, std::string("cannot be written: ") + std::strerror(errno));
    given = given || !isNothing(value);
  }

  void copyTo(AtomicFile& file) {
    stream.seekg(0);
    std::vector<char> part(kPart);
    while (stream.read(part.data(), std::streamsize(part.size())) || stream.gcount() > 0)
      file.write({part.data(), size_t(stream.gcount())});
    if (!stream.eof()) throw IoError(path, "cannot be read");
  }

  std::string path;
  std::fstream stream;
  bool given = false;  ///< a frame has a value
};

UsdaMeshWriter::UsdaMeshWriter(const std::string& path, const UsdaStage& stage) : path_(path), stage_(stage) {
  for (size_t a = 0; a < kAttributeCount; ++a)
    samples_.push_back(std::make_unique<Samples>(scratch_.file(std::to_string(a))));
}

UsdaMeshWriter::~UsdaMeshWriter() = default;

void UsdaMeshWriter::add(int number, const Mesh& mesh, const std::vector<Vec3s>& velocities) {
  frames_ = {frames_ ? frames_->first : number, number};
  if (!origin_ && !mesh.points.empty()) origin_ = mesh.origin;
  Vectors moved;
  if (origin_ && mesh.origin != *origin_)
    for (const Vec3s& p : mesh.points) moved.emplace_back(Vec3d(p) + (mesh.origin - *origin_));
  const Vectors& points = moved.empty() ? mesh.points : moved;
  for (size_t a = 0; a < kAttributeCount; ++a) samples_[a]->add(number, valueOf(a, mesh, points, velocities));
}

void UsdaMeshWriter::commit() {
  AtomicFile file(path_);
  file.write(beginOf(path_, stage_, frames_, origin_.value_or(Vec3d(0.0))));
  for (size_t a = 0; a < kAttributeCount; ++a) {
    if (kAttributes[a].optional && !samples_[a]->given) continue;
    if (kAttributes[a].perVertex) file.write(declared(kAttributes[a]) + perVertex(kIndent) + "\n");
    file.write(declared(kAttributes[a]) + ".timeSamples = {\n");
    samples_[a]->copyTo(file);
    file.write(std::string(kIndent) + "}\n");
  }
  file.write(kEnd);
  file.commit();
}

}  // namespace slicemorph
