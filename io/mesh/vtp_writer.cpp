#include "io/atomic_file.h"
#include "slicemorph/io/mesh_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace slicemorph {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary VTP is written as it lies in memory");

/// The blocks of binary data behind the XML: each its size, then its bytes.
class AppendedBlocks {
 public:
  /// Attributes of a data array that is the next block.
  template <typename T>
  std::string add(const std::vector<T>& values) {
    const std::uint64_t bytes = values.size() * sizeof(T);
    const std::string where = " format=\"appended\" offset=\"" + std::to_string(data_.size()) + "\"/>\n";
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
    return where;
  }
  const std::string& data() const { return data_; }

 private:
  std::string data_;
};

/// A string as VTK has it: the codes of its letters and a zero.
std::string fieldOf(const std::string& name, const std::string& text) {
  std::string codes;
  for (const char c : text) codes += std::to_string(int(c)) + " ";
  return "<FieldData><Array type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"1\" format=\"ascii\">" +
         codes + "0</Array></FieldData>\n";
}

std::string pointsOf(const Mesh& mesh, AppendedBlocks& blocks) {
  const std::string end = "\" NumberOfComponents=\"3\"";
  if (mesh.origin == Vec3d(0.0)) return "Float32\" Name=\"Points" + end + blocks.add(mesh.points);
  std::vector<Vec3d> places;
  for (const openvdb::Vec3s& p : mesh.points) places.push_back(Vec3d(p) + mesh.origin);
  return "Float64\" Name=\"Points" + end + blocks.add(places);
}

std::string colorsOf(const Mesh& mesh, AppendedBlocks& blocks) {
  if (mesh.colors.empty()) return {};
  std::vector<std::array<std::uint8_t, 3>> colors;
  for (const openvdb::Vec3s& c : mesh.colors) {
    std::array<std::uint8_t, 3> color;
    for (int d = 0; d < 3; ++d)
      color[size_t(d)] = std::uint8_t(std::lround(std::clamp(c[d], 0.f, 1.f) * 255));
    colors.push_back(color);
  }
  return "<PointData Scalars=\"RGB\"><DataArray type=\"UInt8\" Name=\"RGB\" NumberOfComponents=\"3\"" +
         blocks.add(colors) + "</PointData>\n";
}

}  // namespace

void writeVtp(const std::string& path, const Mesh& mesh, MeshSpace space) {
  std::vector<std::int64_t> corners, ends;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) corners.push_back(t[c]);
    ends.push_back(std::int64_t(corners.size()));
  }
  AppendedBlocks blocks;
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n";
  if (space != MeshSpace::kUnsaid) xml += fieldOf("SPACE", space == MeshSpace::kRas ? "RAS" : "LPS");
  xml += "<Piece NumberOfPoints=\"" + std::to_string(mesh.points.size()) +
         "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
         std::to_string(mesh.triangles.size()) + "\">\n" + colorsOf(mesh, blocks);
  xml += "<Points><DataArray type=\"" + pointsOf(mesh, blocks) + "</Points>\n";
  xml += "<Polys><DataArray type=\"Int64\" Name=\"connectivity\"" + blocks.add(corners);
  xml += "<DataArray type=\"Int64\" Name=\"offsets\"" + blocks.add(ends) + "</Polys>\n";
  AtomicFile file(path);
  file.write(xml + "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
  file.write(blocks.data());
  file.write("\n</AppendedData>\n</VTKFile>\n");
  file.commit();
}

}  // namespace slicemorph
