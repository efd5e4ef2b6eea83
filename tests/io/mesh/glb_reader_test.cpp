#include "io/mesh/mesh_reader.h"
#include "slicemorph/errors.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using openvdb::Vec3s;

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kFloat = 5126;

/// A glTF file built by hand: a tetrahedron that every test modifies.
struct GlbFile {
  json gltf = {{"asset", {{"version", "2.0"}}}, {"scene", 0},
               {"scenes", {{{"nodes", {0}}}}},  {"nodes", {{{"mesh", 0}}}},
               {"bufferViews", json::array()},  {"accessors", json::array()}};
  std::string data;

  template <typename Number>
  int add(const std::vector<Number>& numbers, int component, const char* type, size_t count) {
    data.resize((data.size() + 3) / 4 * 4, '\0');
    const size_t bytes = numbers.size() * sizeof(Number);
    gltf["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", bytes}});
    data.append(reinterpret_cast<const char*>(numbers.data()), bytes);
    gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size() - 1},
                                 {"componentType", component},
                                 {"count", count},
                                 {"type", type}});
    return int(gltf["accessors"].size()) - 1;
  }

  std::string bytes() const {
    json whole = gltf;
    std::string binary = data;
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    if (!whole.contains("buffers")) whole["buffers"] = {{{"byteLength", data.size()}}};
    std::string text = whole.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto number = [](size_t value) {
      const auto n = std::uint32_t(value);
      return std::string(reinterpret_cast<const char*>(&n), 4);
    };
    return "glTF" + number(2) + number(28 + text.size() + binary.size()) + number(text.size()) + "JSON" +
           text + number(binary.size()) + std::string("BIN\0", 4) + binary;
  }
};

const std::vector<float> kCorners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::vector<std::uint16_t> kFaces = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};

GlbFile tetrahedron() {
  GlbFile file;
  const int points = file.add(kCorners, kFloat, "VEC3", 4);
  const int faces = file.add(kFaces, kUnsignedShort, "SCALAR", 12);
  file.gltf["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", points}}}, {"indices", faces}}}}}};
  return file;
}

json& primitiveOf(GlbFile& file) { return file.gltf["meshes"][0]["primitives"][0]; }

StoredMesh read(const GlbFile& file) {
  const std::string path =
      (fs::temp_directory_path() / ("slicemorph_" + std::to_string(getpid()) + ".glb")).string();
  std::ofstream(path, std::ios::binary) << file.bytes();
  struct Remove {
    std::string path;
    ~Remove() { fs::remove(path); }
  } remove{path};
  return readPolygons(parseInput(path));
}

std::string refusal(const GlbFile& file) {
  try {
    read(file);
  } catch (const IoError& error) {
    return error.note().text;
  }
  return "it was read";
}

void expectPoints(const StoredMesh& mesh, const std::vector<Vec3s>& points, float slack = 1e-6f) {
  ASSERT_EQ(mesh.mesh.points.size(), points.size());
  for (size_t i = 0; i < points.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mesh.mesh.points[i][c], points[i][c], slack) << i << " " << c;
}

TEST(GlbReader, ReadsPointsAndFacesInTheFilesOrder) {
  const StoredMesh mesh = read(tetrahedron());
  expectPoints(mesh, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0);
  EXPECT_EQ(mesh.mesh.corners, std::vector<std::uint32_t>(kFaces.begin(), kFaces.end()));
  EXPECT_EQ(mesh.mesh.faceStarts, (std::vector<std::uint32_t>{0, 3, 6, 9, 12}));
  EXPECT_TRUE(mesh.mesh.colors.empty());
  EXPECT_TRUE(mesh.notes.empty());
  EXPECT_EQ(mesh.points, 4u);
  EXPECT_EQ(mesh.faces, 4u);
}

/// A child's transform is applied first, then its parent's: here a rotation by 90 degrees about z after
/// scaling and moving.
TEST(GlbReader, NodesAreAppliedFromTheInside) {
  GlbFile file = tetrahedron();
  const double half = std::sqrt(0.5);
  file.gltf["nodes"] = {{{"children", {1, 2}}, {"rotation", {0, 0, half, half}}, {"translation", {0, 0, 5}}},
                        {{"mesh", 0}, {"scale", {2, 3, 4}}, {"translation", {10, 0, 0}}},
                        {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 7, 8, 9, 1}}}};
  // (x, y, z) -> (-y, x, z + 5) of (2 x + 10, 3 y, 4 z), and of (x + 7, y + 8, 9 - z).
  expectPoints(
      read(file),
      {{0, 10, 5}, {0, 12, 5}, {-3, 10, 5}, {0, 10, 9}, {-8, 7, 14}, {-8, 8, 14}, {-9, 7, 14}, {-8, 7, 13}},
      1e-5f);
}

TEST(GlbReader, WithoutAScenesListAllRootsAreRead) {
  GlbFile file = tetrahedron();
  file.gltf.erase("scene"), file.gltf.erase("scenes");
  file.gltf["nodes"] = {{{"mesh", 0}, {"translation", {1, 0, 0}}},
                        {{"children", {0}}, {"translation", {0, 2, 0}}}};
  expectPoints(read(file), {{1, 2, 0}, {2, 2, 0}, {1, 3, 0}, {1, 2, 1}});
}

TEST(GlbReader, StripsAndFansAreWoundAsTheStandardSays) {
  const std::vector<std::uint8_t> order = {3, 1, 2, 0, 3};
  for (const auto& [mode, corners] : std::vector<std::pair<int, std::vector<std::uint32_t>>>{
           {5, {3, 1, 2, 1, 0, 2, 2, 0, 3}}, {6, {1, 2, 3, 2, 0, 3, 0, 3, 3}}, {4, {3, 1, 2}}}) {
    GlbFile file = tetrahedron();
    primitiveOf(file)["indices"] = file.add(order, kUnsignedByte, "SCALAR", order.size());
    primitiveOf(file)["mode"] = mode;
    EXPECT_EQ(read(file).mesh.corners, corners) << mode;
  }
  GlbFile lines = tetrahedron();
  primitiveOf(lines)["mode"] = 1;
  EXPECT_EQ(read(lines).skipped, 6u);
  GlbFile plain = tetrahedron();
  primitiveOf(plain).erase("indices");
  EXPECT_EQ(read(plain).mesh.corners, (std::vector<std::uint32_t>{0, 1, 2}));
}

/// KHR_mesh_quantization: normalised integers are divided by the largest value of their type.
TEST(GlbReader, QuantisedPointsAreRead) {
  GlbFile file = tetrahedron();
  std::vector<std::int16_t> shorts;
  for (float c : kCorners) shorts.push_back(std::int16_t(c * -32767));
  const int accessor = file.add(shorts, kShort, "VEC3", 4);
  file.gltf["accessors"][accessor]["normalized"] = true;
  file.gltf["extensionsRequired"] = {"KHR_mesh_quantization"};
  file.gltf["nodes"][0]["scale"] = {-3, -3, -3};
  primitiveOf(file)["attributes"]["POSITION"] = accessor;
  const StoredMesh mesh = read(file);
  expectPoints(mesh, {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}});
  EXPECT_TRUE(mesh.notes.empty());
  const int bytes =
      file.add(std::vector<std::int8_t>{0, 0, 0, 0, 5, 0, 0, 0, 0, -6, 0, 0, 0, 0, 7, 0}, kByte, "VEC3", 4);
  file.gltf["bufferViews"].back()["byteStride"] = 4;
  file.gltf["nodes"][0].erase("scale");
  primitiveOf(file)["attributes"]["POSITION"] = bytes;
  expectPoints(read(file), {{0, 0, 0}, {5, 0, 0}, {0, -6, 0}, {0, 0, 7}});
}

TEST(GlbReader, SparseValuesArePutIn) {
  GlbFile file = tetrahedron();
  const int where = file.add(std::vector<std::uint8_t>{1, 3}, kUnsignedByte, "SCALAR", 2);
  const int what = file.add(std::vector<float>{4, 0, 0, 0, 0, 6}, kFloat, "VEC3", 2);
  const auto view = [&](int accessor) { return file.gltf["accessors"][accessor]["bufferView"]; };
  file.gltf["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", view(where)}, {"componentType", kUnsignedByte}, {"byteOffset", 0}}},
      {"values", {{"bufferView", view(what)}, {"byteOffset", 0}}}};
  expectPoints(read(file), {{0, 0, 0}, {4, 0, 0}, {0, 1, 0}, {0, 0, 6}}, 0);
  file.data[size_t(file.gltf["bufferViews"][2]["byteOffset"])] = 4;
  EXPECT_NE(refusal(file).find("beyond its end"), std::string::npos) << refusal(file);
}

/// glTF 2.0, 3.7.2.2: morph targets are applied by their weights, those of the node before those of the mesh.
TEST(GlbReader, MorphTargetsAreAppliedByTheirDefaultWeights) {
  GlbFile file = tetrahedron();
  primitiveOf(file)["targets"] = {{{"POSITION", file.add(std::vector<float>(12, 1), kFloat, "VEC3", 4)}},
                                  {{"POSITION", file.add(std::vector<float>(12, 10), kFloat, "VEC3", 4)}}};
  EXPECT_TRUE(read(file).notes.empty());
  file.gltf["meshes"][0]["weights"] = {0, 0.5};
  const StoredMesh mesh = read(file);
  expectPoints(mesh, {{5, 5, 5}, {6, 5, 5}, {5, 6, 5}, {5, 5, 6}});
  ASSERT_EQ(mesh.notes.size(), 1u);
  EXPECT_EQ(mesh.notes[0].code, "mesh.morph-targets-applied");
  file.gltf["nodes"][0]["weights"] = {2, 0};
  expectPoints(read(file), {{2, 2, 2}, {3, 2, 2}, {2, 3, 2}, {2, 2, 3}});
}

TEST(GlbReader, ColoursOfPointsAreMultipliedWithTheMaterials) {
  GlbFile file = tetrahedron();
  const int colors = file.add(std::vector<std::uint16_t>{65535, 0, 0, 65535, 0, 65535, 0, 65535, 13107, 13107,
                                                         13107, 65535, 65535, 65535, 65535, 65535},
                              kUnsignedShort, "VEC4", 4);
  file.gltf["accessors"][colors]["normalized"] = true;
  primitiveOf(file)["attributes"]["COLOR_0"] = colors;
  primitiveOf(file)["material"] = 0;
  file.gltf["materials"] = {
      {{"name", "paint"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1, 1, 1}}}}}};
  const StoredMesh mesh = read(file);
  EXPECT_EQ(mesh.colorsOf, "points");
  ASSERT_EQ(mesh.mesh.colors.size(), 12u);
  const std::vector<Vec3s> expected = {{0.5f, 0, 0}, {0, 1, 0}, {0.1f, 0.2f, 0.2f}, {0.5f, 1, 1}};
  for (size_t k = 0; k < 12; ++k)
    EXPECT_TRUE(mesh.mesh.colors[k].eq(expected[kFaces[k]], 1e-6f)) << k << " " << mesh.mesh.colors[k];
  primitiveOf(file)["attributes"].erase("COLOR_0");
  EXPECT_EQ(read(file).colorsOf, "materials");
  EXPECT_EQ(read(file).mesh.colors[5], Vec3s(0.5f, 1, 1));
  file.gltf["materials"][0]["name"] = "clay";  // the material of our own files without colours
  EXPECT_EQ(read(file).colorsOf, "");
}

TEST(GlbReader, PicturesAreNotLookedInto) {
  GlbFile file = tetrahedron();
  file.add(std::vector<std::uint8_t>{1, 2, 3, 4}, kUnsignedByte, "SCALAR", 4);
  file.gltf["images"] = {{{"bufferView", file.gltf["bufferViews"].size() - 1}, {"mimeType", "image/png"}},
                         {{"uri", "there_is_none.png"}}};
  file.gltf["textures"] = {{{"source", 0}}, {{"source", 1}}};
  file.gltf["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}}};
  primitiveOf(file)["material"] = 0;
  EXPECT_TRUE(read(file).textured);
}

TEST(GlbReader, DamageIsNamed) {
  const auto with = [](const auto& change) {
    GlbFile file = tetrahedron();
    change(file);
    return refusal(file);
  };
#define EXPECT_REFUSED(part, ...)                                  \
  {                                                                \
    const std::string why = with([](GlbFile& f) { __VA_ARGS__; }); \
    EXPECT_NE(why.find(part), std::string::npos) << why;           \
  }
  EXPECT_REFUSED("reaches beyond its buffer", f.gltf["accessors"][0]["count"] = 5)
  EXPECT_REFUSED("reaches beyond its buffer", f.gltf["accessors"][0]["byteOffset"] = 4)
  // An offset and a length whose sum wraps round to a small number.
  EXPECT_REFUSED("reaches beyond its buffer", f.gltf["bufferViews"][0]["byteOffset"] = 4096;
                 f.gltf["bufferViews"][0]["byteLength"] = 18446744073709547520u + 8)
  EXPECT_REFUSED("reaches beyond its buffer", f.gltf["bufferViews"][0]["byteLength"] = 47)
  EXPECT_REFUSED("face 1 refers to point 10", f.data[48] = 9)
  EXPECT_REFUSED("point 2 is not finite", f.data.replace(12, 4, std::string("\0\0\xc0\x7f", 4)))
  EXPECT_REFUSED("accessor 7", primitiveOf(f)["attributes"]["POSITION"] = 7)
  EXPECT_REFUSED("mesh 3", f.gltf["nodes"][0]["mesh"] = 3)
  EXPECT_REFUSED("node 4", f.gltf["nodes"][0]["children"] = {4})
  EXPECT_REFUSED("node 0 has several parents", f.gltf["nodes"][0]["children"] = {0})
  EXPECT_REFUSED("a mesh of 4 points has 3 colours",
                 primitiveOf(f)["attributes"]["COLOR_0"] = f.add(std::vector<float>(9, 1), kFloat, "VEC3", 3))
  EXPECT_REFUSED("KHR_draco_mesh_compression", f.gltf["extensionsRequired"] = {"KHR_draco_mesh_compression"})
  EXPECT_REFUSED("EXT_mesh_gpu_instancing", f.gltf["extensionsRequired"] = {"EXT_mesh_gpu_instancing"})
#undef EXPECT_REFUSED
  // Cut anywhere, and one byte changed anywhere: refused or read, never a crash.
  const std::string whole = tetrahedron().bytes();
  const std::string path =
      (fs::temp_directory_path() / ("slicemorph_cut_" + std::to_string(getpid()) + ".glb")).string();
  const auto attempt = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    try {
      readPolygons(parseInput(path));
    } catch (const IoError& error) {
      EXPECT_EQ(error.note().about, path);
      return true;
    }
    return false;
  };
  for (size_t size = 1; size < whole.size(); ++size) EXPECT_TRUE(attempt(whole.substr(0, size))) << size;
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string bytes = whole;
    bytes[i] = "\x7f\xff\x39"[i % 3];
    attempt(bytes);
  }
  fs::remove(path);
}

}  // namespace
}  // namespace slicemorph
