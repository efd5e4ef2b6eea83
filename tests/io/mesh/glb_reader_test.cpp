#include "io/mesh/mesh_reader.h"
#include "slicemorph/errors.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#ifdef SLICEMORPH_MESHOPT
#include <meshoptimizer.h>
#endif
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
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

double volumeOf(const PolygonMesh& mesh) {
  double volume = 0;
  for (size_t k = 0; k < mesh.corners.size(); k += 3) {
    const auto at = [&](size_t i) { return Vec3d(mesh.points.at(mesh.corners[k + i])); };
    volume += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return volume;
}

std::string base64(const std::string& bytes) {
  static const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k)
      text += i + k < bytes.size() + 1 ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
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

/// A transform that mirrors turns the faces, so that they keep their front.
TEST(GlbReader, MirroredFacesAreTurned) {
  GlbFile file = tetrahedron();
  for (const json& mirror :
       {json({{"mesh", 0}, {"scale", {-1, 1, 1}}}),
        json({{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1}}}),
        json({{"mesh", 0}, {"scale", {-1, -1, -1}}}), json({{"mesh", 0}}),
        json({{"mesh", 0}, {"scale", {-1, -1, 1}}})}) {
    file.gltf["nodes"][0] = mirror;
    EXPECT_NEAR(volumeOf(read(file).mesh), 1.0 / 6, 1e-6) << mirror;
  }
}

/// EXT_mesh_gpu_instancing: copies in the node's space.
TEST(GlbReader, InstancesAreCopies) {
  GlbFile file = tetrahedron();
  file.gltf["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  const int moves = file.add(std::vector<float>{0, 0, 0, 5, 0, 0, 0, 6, 0}, kFloat, "VEC3", 3);
  json& node = file.gltf["nodes"][0];
  node["scale"] = {2, 2, 2};
  json& attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = moves;
  const StoredMesh three = read(file);
  expectPoints(three, {{0, 0, 0},
                       {2, 0, 0},
                       {0, 2, 0},
                       {0, 0, 2},
                       {10, 0, 0},
                       {12, 0, 0},
                       {10, 2, 0},
                       {10, 0, 2},
                       {0, 12, 0},
                       {2, 12, 0},
                       {0, 14, 0},
                       {0, 12, 2}});
  EXPECT_EQ(three.mesh.faceCount(), 12u);
  ASSERT_EQ(three.notes.size(), 1u);
  EXPECT_EQ(three.notes[0].code, "mesh.instances-applied");
  // A quarter turn about z in normalised bytes, and a mirror.
  const int turns =
      file.add(std::vector<std::int8_t>{0, 0, 90, 90, 0, 0, 0, 127, 0, 0, 0, 127}, kByte, "VEC4", 3);
  file.gltf["accessors"][turns]["normalized"] = true;
  attributes["ROTATION"] = turns;
  attributes["SCALE"] = file.add(std::vector<float>{1, 2, 3, -1, 1, 1, 1, 1, 1}, kFloat, "VEC3", 3);
  const StoredMesh turned = read(file);
  EXPECT_TRUE(turned.mesh.points[1].eq(Vec3s(0, 2, 0), 1e-5f)) << turned.mesh.points[1];
  EXPECT_TRUE(turned.mesh.points[2].eq(Vec3s(-4, 0, 0), 1e-5f)) << turned.mesh.points[2];
  EXPECT_TRUE(turned.mesh.points[3].eq(Vec3s(0, 0, 6), 1e-5f)) << turned.mesh.points[3];
  EXPECT_TRUE(turned.mesh.points[5].eq(Vec3s(8, 0, 0), 1e-5f)) << turned.mesh.points[5];
  EXPECT_NEAR(volumeOf(turned.mesh), 8.0 / 6 * (6 + 1 + 1), 1e-4);
  attributes["SCALE"] = file.add(std::vector<float>{1, 2, 3}, kFloat, "VEC3", 1);
  EXPECT_NE(refusal(file).find("1 vectors of 3 numbers where 3 of 3 are needed"), std::string::npos)
      << refusal(file);
}

/// glTF 2.0, 3.7.3: points are where their joints take them; the node's own transform counts for nothing.
TEST(GlbReader, SkinsAreAppliedInTheStoredPose) {
  GlbFile file = tetrahedron();
  const int joints = file.add(std::vector<std::uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
                              kUnsignedByte, "VEC4", 4);
  const int weights =
      file.add(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 1, 3, 0, 0, 0, 0, 0, 0}, kFloat, "VEC4", 4);
  primitiveOf(file)["attributes"]["JOINTS_0"] = joints;
  primitiveOf(file)["attributes"]["WEIGHTS_0"] = weights;
  file.gltf["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}},
                        {{"translation", {0, 0, 2}}, {"children", {2}}},
                        {{"translation", {4, 0, 0}}}};
  file.gltf["scenes"][0]["nodes"] = {0};  // joints may be outside the scene
  file.gltf["skins"] = {{{"joints", {1, 2}}}};
  const StoredMesh mesh = read(file);
  // Moved by (0 0 2), (4 0 2), a quarter and three quarters of them, and, without a weight, by the first.
  expectPoints(mesh, {{0, 0, 2}, {5, 0, 2}, {3, 1, 2}, {0, 0, 3}});
  ASSERT_EQ(mesh.notes.size(), 1u);
  EXPECT_EQ(mesh.notes[0].code, "mesh.skin-applied");
  // In the bind pose nothing moves: the matrices undo the joints' transforms.
  file.gltf["skins"][0]["inverseBindMatrices"] =
      file.add(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, -2, 1,
                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -4, 0, -2, 1},
               kFloat, "MAT4", 2);
  expectPoints(read(file), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  file.gltf["skins"][0]["joints"] = {1};
  EXPECT_NE(refusal(file).find("hangs on joint 1, its skin has 1"), std::string::npos) << refusal(file);
  file.gltf["skins"][0]["joints"] = {1, 7};
  EXPECT_NE(refusal(file).find("a skin refers to node 7"), std::string::npos) << refusal(file);
  file.gltf["nodes"][0]["skin"] = 3;
  EXPECT_NE(refusal(file).find("skin 3"), std::string::npos) << refusal(file);
}

TEST(GlbReader, HiddenNodesAreLeftOut) {
  GlbFile file = tetrahedron();
  file.gltf["extensionsRequired"] = {"KHR_node_visibility"};
  file.gltf["scenes"][0]["nodes"] = {0, 1};
  file.gltf["nodes"] = {{{"mesh", 0}}, {{"children", {2}}}, {{"mesh", 0}}};
  file.gltf["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = false;
  EXPECT_EQ(read(file).mesh.faceCount(), 4u);
  file.gltf["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = true;
  EXPECT_EQ(read(file).mesh.faceCount(), 8u);
}

TEST(GlbReader, InterleavedAndSparseWithoutData) {
  GlbFile file = tetrahedron();
  std::vector<float> rows;  // a number, the position and another number
  for (size_t i = 0; i < 4; ++i)
    rows.insert(rows.end(), {9, kCorners[3 * i], kCorners[3 * i + 1], kCorners[3 * i + 2], 9});
  const int interleaved = file.add(rows, kFloat, "VEC3", 4);
  file.gltf["bufferViews"].back()["byteStride"] = 20;
  file.gltf["accessors"][interleaved]["byteOffset"] = 4;
  primitiveOf(file)["attributes"]["POSITION"] = interleaved;
  expectPoints(read(file), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0);
  // Zeros but for three sparse values; offsets that are not stated are 0.
  const int where = file.add(std::vector<std::uint16_t>{1, 2, 3}, kUnsignedShort, "SCALAR", 3);
  const int what = file.add(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}, kFloat, "VEC3", 3);
  const auto view = [&](int accessor) { return file.gltf["accessors"][accessor]["bufferView"]; };
  file.gltf["accessors"].push_back({{"componentType", kFloat}, {"count", 4}, {"type", "VEC3"}});
  file.gltf["accessors"].back()["sparse"] = {
      {"count", 3},
      {"indices", {{"bufferView", view(where)}, {"componentType", kUnsignedShort}}},
      {"values", {{"bufferView", view(what)}}}};
  primitiveOf(file)["attributes"]["POSITION"] = file.gltf["accessors"].size() - 1;
  expectPoints(read(file), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0);
}

/// Corners may be sparse too.
TEST(GlbReader, SparseCorners) {
  GlbFile file = tetrahedron();
  const int where = file.add(std::vector<std::uint8_t>{0, 11}, kUnsignedByte, "SCALAR", 2);
  const int what = file.add(std::vector<std::uint16_t>{3, 1}, kUnsignedShort, "SCALAR", 2);
  const auto view = [&](int accessor) { return file.gltf["accessors"][accessor]["bufferView"]; };
  file.gltf["accessors"][1]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", view(where)}, {"componentType", kUnsignedByte}}},
      {"values", {{"bufferView", view(what)}}}};
  std::vector<std::uint32_t> corners(kFaces.begin(), kFaces.end());
  corners.front() = 3, corners.back() = 1;
  EXPECT_EQ(read(file).mesh.corners, corners);
}

TEST(GlbReader, TextFilesHaveTheirDataBesideThemOrInside) {
  GlbFile file = tetrahedron();
  const fs::path folder = fs::temp_directory_path() / ("slicemorph_gltf_" + std::to_string(getpid()));
  fs::create_directory(folder);
  const std::string path = (folder / "t.gltf").string();
  const auto readText = [&](const std::string& uri) {
    file.gltf["buffers"] = {{{"byteLength", file.data.size()}, {"uri", uri}}};
    std::ofstream(path, std::ios::binary) << "\xef\xbb\xbf" << file.gltf.dump(2);
    return readPolygons(parseInput(path));
  };
  std::ofstream(folder / "the data.bin", std::ios::binary) << file.data << "and more";
  expectPoints(readText("the%20data.bin"), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0);
  const std::string inside = "data:application/octet-stream;base64," + base64(file.data);
  EXPECT_EQ(readText(inside).mesh.corners, std::vector<std::uint32_t>(kFaces.begin(), kFaces.end()));
  const auto refusalOf = [&](const std::string& uri) {
    try {
      readText(uri);
    } catch (const IoError& error) {
      return std::string(error.what());
    }
    return std::string("it was read");
  };
  EXPECT_EQ(refusalOf("gone.bin"), (folder / "gone.bin").string() + ": no such file");
  EXPECT_NE(refusalOf("data:application/octet-stream;base64,AA*A").find("no base64"), std::string::npos);
  EXPECT_NE(refusalOf("data:application/octet-stream;base64,AAAA").find("is to have 72 bytes, there are 3"),
            std::string::npos);
  // The same data in a GLB as a second buffer.
  GlbFile second = tetrahedron();
  second.gltf["buffers"] = {{{"byteLength", second.data.size()}},
                            {{"byteLength", second.data.size()}, {"uri", inside}}};
  for (json& view : second.gltf["bufferViews"]) view["buffer"] = 1;
  std::fill(second.data.begin(), second.data.end(), '\x7f');
  EXPECT_EQ(read(second).mesh.corners, std::vector<std::uint32_t>(kFaces.begin(), kFaces.end()));
  fs::remove_all(folder);
}

/// Packed by Draco's own encoder, with fine positions: they come back within its step, in any order.
TEST(GlbReader, DracoIsUnpacked) {
  GlbFile file = tetrahedron();
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(4);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int colors = builder.AddAttribute(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8);
  for (std::uint32_t f = 0; f < 4; ++f) {
    const auto corner = [&](size_t k) { return &kCorners[3 * kFaces[3 * f + k]]; };
    const auto color = [&](size_t k) {
      std::array<std::uint8_t, 3> bytes;
      for (size_t c = 0; c < 3; ++c) bytes[c] = std::uint8_t(255 - 51 * corner(k)[c]);
      return bytes;
    };
    const auto a = color(0), b = color(1), c = color(2);
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(f), corner(0), corner(1), corner(2));
    builder.SetAttributeValuesForFace(colors, draco::FaceIndex(f), a.data(), b.data(), c.data());
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 16);
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  const int packed =
      file.add(std::vector<char>(buffer.data(), buffer.data() + buffer.size()), kByte, "SCALAR", 1);
  const json view = file.gltf["accessors"][packed]["bufferView"];
  file.gltf["accessors"] = {{{"componentType", kFloat}, {"count", mesh->num_points()}, {"type", "VEC3"}},
                            {{"componentType", kUnsignedShort}, {"count", 12}, {"type", "SCALAR"}},
                            {{"componentType", kUnsignedByte},
                             {"count", mesh->num_points()},
                             {"type", "VEC3"},
                             {"normalized", true}}};
  primitiveOf(file) = {{"attributes", {{"POSITION", 0}, {"COLOR_0", 2}}}, {"indices", 1}};
  primitiveOf(file)["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", 0}, {"COLOR_0", 1}}}};
  file.gltf["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const StoredMesh read = slicemorph::read(file);
  ASSERT_EQ(read.mesh.faceCount(), 4u);
  EXPECT_NEAR(volumeOf(read.mesh), 1.0 / 6, 1e-4);
  EXPECT_EQ(read.colorsOf, "points");
  for (size_t k = 0; k < 12; ++k)
    EXPECT_TRUE(read.mesh.colors[k].eq(Vec3s(1.f) - 0.2f * read.mesh.points[read.mesh.corners[k]], 1e-4f))
        << k;
  // Damaged and cut data are refused, and data of another mesh.
  const size_t at = size_t(file.gltf["bufferViews"][size_t(view)]["byteOffset"]);
  for (size_t i = at; i < file.data.size(); i += 3) {
    GlbFile damaged = file;
    damaged.data[i] = char(~damaged.data[i]);
    refusal(damaged);
  }
  GlbFile cut = file;
  cut.gltf["bufferViews"][size_t(view)]["byteLength"] = buffer.size() / 2;
  EXPECT_NE(refusal(cut).find("KHR_draco_mesh_compression"), std::string::npos) << refusal(cut);
  file.gltf["accessors"][0]["count"] = 3;
  EXPECT_NE(refusal(file).find("Draco packs 4 points of a mesh of 3"), std::string::npos) << refusal(file);
}

#ifdef SLICEMORPH_MESHOPT
/// Packed by meshoptimizer's own encoders; the other buffer is a place for readers that do not unpack, without data.
TEST(GlbReader, MeshoptIsUnpacked) {
  GlbFile file = tetrahedron();
  std::vector<unsigned char> points(meshopt_encodeVertexBufferBound(4, 12)),
      faces(meshopt_encodeIndexBufferBound(12, 4));
  points.resize(meshopt_encodeVertexBuffer(points.data(), points.size(), kCorners.data(), 4, 12));
  const std::vector<std::uint32_t> corners(kFaces.begin(), kFaces.end());
  faces.resize(meshopt_encodeIndexBuffer(faces.data(), faces.size(), corners.data(), 12));
  file.data.clear();
  file.gltf["bufferViews"] = json::array(), file.gltf["accessors"] = json::array();
  const auto pack = [&](const std::vector<unsigned char>& bytes, const char* mode, size_t count,
                        size_t stride, int component, const char* type) {
    const int accessor = file.add(bytes, component, type, count);
    json& view = file.gltf["bufferViews"].back();
    view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                     {"byteOffset", view["byteOffset"]},
                                                     {"byteLength", bytes.size()},
                                                     {"byteStride", stride},
                                                     {"count", count},
                                                     {"mode", mode}};
    view["buffer"] = 1, view["byteOffset"] = 0, view["byteLength"] = count * stride;
    return accessor;
  };
  primitiveOf(file)["attributes"]["POSITION"] = pack(points, "ATTRIBUTES", 4, 12, kFloat, "VEC3");
  primitiveOf(file)["indices"] = pack(faces, "TRIANGLES", 12, 2, kUnsignedShort, "SCALAR");
  file.gltf["buffers"] = {{{"byteLength", file.data.size()}}, {{"byteLength", 1000}}};
  file.gltf["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  file.gltf["extensionsRequired"] = {"EXT_meshopt_compression"};
  const StoredMesh mesh = read(file);
  expectPoints(mesh, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0);
  EXPECT_NEAR(volumeOf(mesh.mesh), 1.0 / 6, 1e-6);
  EXPECT_TRUE(mesh.notes.empty());
  GlbFile cut = file;
  cut.gltf["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["byteLength"] = 20;
  EXPECT_NE(refusal(cut).find("EXT_meshopt_compression"), std::string::npos) << refusal(cut);
  cut = file;
  cut.gltf["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["filter"] = "OCTAHEDRAL";
  EXPECT_NE(refusal(cut).find("filter OCTAHEDRAL"), std::string::npos) << refusal(cut);
}
#endif

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

/// Faces without texture coordinates have no use for it.
TEST(GlbReader, PicturesAreNotLookedIntoWithoutNeed) {
  GlbFile file = tetrahedron();
  file.add(std::vector<std::uint8_t>{1, 2, 3, 4}, kUnsignedByte, "SCALAR", 4);
  file.gltf["images"] = {{{"bufferView", file.gltf["bufferViews"].size() - 1}, {"mimeType", "image/png"}},
                         {{"uri", "there_is_none.png"}}};
  file.gltf["textures"] = {{{"source", 0}}, {{"source", 1}}};
  file.gltf["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}}};
  primitiveOf(file)["material"] = 0;
  const StoredMesh mesh = read(file);
  EXPECT_TRUE(mesh.mesh.textures.empty());
  EXPECT_TRUE(mesh.notes.empty()) << mesh.notes[0].text;
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
  EXPECT_REFUSED("'byteLength' is no whole number", f.gltf["bufferViews"][0]["byteLength"] = -1)
  EXPECT_REFUSED("face 1 refers to point 10", f.data[48] = 9)
  EXPECT_REFUSED("point 2 is not finite", f.data.replace(12, 4, std::string("\0\0\xc0\x7f", 4)))
  EXPECT_REFUSED("accessor 7", primitiveOf(f)["attributes"]["POSITION"] = 7)
  EXPECT_REFUSED("mesh 3", f.gltf["nodes"][0]["mesh"] = 3)
  EXPECT_REFUSED("node 4", f.gltf["nodes"][0]["children"] = {4})
  EXPECT_REFUSED("node 0 has several parents", f.gltf["nodes"][0]["children"] = {0})
  EXPECT_REFUSED("a mesh of 4 points has 3 colours",
                 primitiveOf(f)["attributes"]["COLOR_0"] = f.add(std::vector<float>(9, 1), kFloat, "VEC3", 3))
  EXPECT_REFUSED("needs the glTF extension ACME_bent_space, which is not read",
                 f.gltf["extensionsRequired"] = json::array({"KHR_materials_unlit", "ACME_bent_space"}))
  EXPECT_REFUSED("is glTF of version 1.0", f.gltf["asset"]["version"] = "1.0")
  EXPECT_REFUSED("an accessor without data has 1000000000", f.gltf["accessors"][0].erase("bufferView");
                 f.gltf["accessors"][0]["count"] = 1000000000)
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
