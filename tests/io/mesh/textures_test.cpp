#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "io/image/png_writer.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/picture_texture.h"
#include "slicemorph/errors.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using openvdb::Vec2d;
using openvdb::Vec3s;

/// IEC 61966-2-1, of a byte.
double linear(double byte) {
  const double s = byte / 255;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

using Bytes = std::array<int, 3>;

/// A BMP of 24 bits. `at(x, y)`: bytes of the pixel, from the upper left.
std::string bmp(int width, int height, const std::function<Bytes(int, int)>& at) {
  const auto number = [](std::uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), 4);
  };
  const int row = (3 * width + 3) / 4 * 4;
  std::string bytes = "BM" + number(std::uint32_t(54 + row * height)) + number(0) + number(54) + number(40) +
                      number(std::uint32_t(width)) + number(std::uint32_t(height)) + number(1 | 24 << 16) +
                      number(0) + number(0) + number(0) + number(0) + number(0) + number(0);
  for (int y = height - 1; y >= 0; --y) {
    std::string line;
    for (int x = 0; x < width; ++x)
      for (const int c : {2, 1, 0}) line += char(at(x, y)[size_t(c)]);
    line.resize(size_t(row), '\0');
    bytes += line;
  }
  return bytes;
}

/// Smooth: the bytes are whole at every pixel's centre.
Bytes ramp(int x, int y) { return {30 + 3 * x, 40 + 2 * y, 200 - x - y}; }
constexpr int kRamp = 64;

/// The colour that a ramp has at (u, v) from its upper left; its byte values change evenly.
Vec3d rampAt(const Vec2d& uv) {
  const double x = std::clamp(uv[0] * kRamp - 0.5, 0.0, kRamp - 1.0),
               y = std::clamp(uv[1] * kRamp - 0.5, 0.0, kRamp - 1.0);
  return {linear(30 + 3 * x), linear(40 + 2 * y), linear(200 - x - y)};
}

class Textures : public ::testing::Test {
 protected:
  void SetUp() override {
    openvdb::initialize();
    fs::create_directory(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return (folder_ / name).string();
  }
  StoredMesh read(const std::string& name) const {
    return readPolygons(parseInput((folder_ / name).string()));
  }

  const fs::path folder_ = fs::temp_directory_path() / ("slicemorph_textures_" + std::to_string(getpid()));
};

/// The unit cube whose six faces each have the whole picture: v of OBJ goes up.
std::string cubeObj() {
  std::string text = "mtllib m.mtl\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
  for (int n = 0; n < 8; ++n)
    text +=
        "v " + std::to_string(n & 1) + " " + std::to_string(n >> 1 & 1) + " " + std::to_string(n >> 2) + "\n";
  text += "usemtl skin\n";
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"}) {
    text += "f";
    for (int k = 0; k < 4; ++k) text += " " + std::string(1, face[2 * k]) + "/" + std::to_string(k + 1);
    text += "\n";
  }
  return text;
}

constexpr double kVoxel = 1.0 / 40;

FloatGrid::Ptr cubeLevelSet(const PolygonMesh& mesh) { return voxelise(repairMesh(mesh).mesh, kVoxel); }

/// A point on a face, and its coordinates on the picture from the upper left, after the corners in cubeObj.
struct OnFace {
  Vec3s point;
  Vec2d uv;
};

OnFace onFace(const PolygonMesh& mesh, size_t face, double s, double t) {
  const std::uint32_t first = mesh.faceStarts[face];
  const auto corner = [&](std::uint32_t k) { return Vec3d(mesh.points[mesh.corners[first + k]]); };
  return {Vec3s(corner(0) + (corner(1) - corner(0)) * s + (corner(3) - corner(0)) * t), {s, 1 - t}};
}

/// Colours of surface points are the texture's, in linear light, at 1,000 places that are so far from the cube's edges,
/// where the picture is another one, that their voxels are on one face.
TEST_F(Textures, ColoursAreThePicturesBetweenTheFewPointsOfACube) {
  write("m.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd skin.bmp\n");
  write("skin.bmp", bmp(kRamp, kRamp, ramp));
  write("c.obj", cubeObj());
  const StoredMesh stored = read("c.obj");
  EXPECT_EQ(stored.colorsOf, "textures");
  ASSERT_EQ(stored.notes.size(), 1u);
  EXPECT_EQ(stored.notes[0].code, "mesh.textures-read");
  const auto colors = colorsAround(*cubeLevelSet(stored.mesh), stored.mesh);
  ASSERT_TRUE(colors);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> inner(0.1, 0.9);
  for (int i = 0; i < 1000; ++i) {
    const OnFace place = onFace(stored.mesh, size_t(i % 6), inner(random), inner(random));
    const Vec3s color = colorsAt(*colors, {place.point})[0];
    const Vec3d expected = rampAt(place.uv);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(color[c], expected[c], 1.0 / 255) << place.point << " " << c;
  }
}

/// Detail finer than a voxel is averaged, in linear light: black and white pixels at random are grey, not either.
TEST_F(Textures, DetailFinerThanVoxelsIsAveraged) {
  write("m.mtl", "newmtl skin\nmap_Kd skin.bmp\n");
  std::mt19937 random(5);
  write("skin.bmp", bmp(1024, 1024, [&](int, int) {
          const int v = random() % 2 ? 255 : 0;
          return Bytes{v, v, v};
        }));
  write("c.obj", cubeObj());
  const StoredMesh stored = read("c.obj");
  const auto colors = colorsAround(*cubeLevelSet(stored.mesh), stored.mesh);
  // A voxel has 25 by 25 pixels; of n independent ones the mean has the deviation 0.5 / sqrt(n), here 0.02. Samples
  // that overlap do not reach that; at the edges they come from half the square.
  size_t far = 0, all = 0;
  double sum = 0;
  for (auto value = colors->cbeginValueOn(); value; ++value, ++all) {
    sum += double((*value)[0]);
    far += std::abs((*value)[0] - 0.5f) > 0.15f;
  }
  EXPECT_NEAR(sum / double(all), 0.5, 0.005);
  EXPECT_LT(double(far), 0.03 * double(all));
}

TEST_F(Textures, OptionsOfMapKd) {
  write("c.obj", cubeObj());
  fs::create_directory(folder_ / "maps");
  write("maps/a skin.bmp", bmp(kRamp, kRamp, ramp));
  write("skin.bmp", bmp(kRamp, kRamp, ramp));
  const auto uvsOf = [&](const std::string& map) {
    write("m.mtl", "newmtl skin\nKd 0.5 1 1\nmap_Kd " + map + "\n");
    const StoredMesh mesh = read("c.obj");
    EXPECT_EQ(mesh.colorsOf, "textures") << map << (mesh.notes.empty() ? "" : mesh.notes[0].text);
    EXPECT_EQ(mesh.mesh.colors[0], Vec3s(0.5f, 1, 1));
    return mesh.mesh.uvs;
  };
  const auto plain = uvsOf("skin.bmp");
  EXPECT_EQ(plain[0], openvdb::Vec2s(0, 1));
  EXPECT_EQ(plain[2], openvdb::Vec2s(1, 0));
  EXPECT_EQ(uvsOf("maps/a skin.bmp"), plain);
  EXPECT_EQ(uvsOf("maps\\a skin.bmp"), plain);
  EXPECT_EQ(uvsOf("C:\\work\\of\\others\\skin.bmp"), plain);
  EXPECT_EQ(uvsOf("-blendu on -clamp off -mm 0 1 -bm .5 skin.bmp"), plain);
  const auto moved = uvsOf("-s 2 3 1 -o 0.25 0.5 -t 1 maps/a skin.bmp");
  EXPECT_EQ(moved[0], openvdb::Vec2s(0.25f, 0.5f));   // (0, 0), up
  EXPECT_EQ(moved[2], openvdb::Vec2s(2.25f, -2.5f));  // (1, 1)
  // Black under a texture would hide it.
  write("m.mtl", "newmtl skin\nKd 0 0 0\nmap_Kd skin.bmp\n");
  EXPECT_EQ(read("c.obj").mesh.colors[0], Vec3s(1.f));
}

/// What cannot be read is named once and the material's colour taken.
TEST_F(Textures, TexturesThatCannotBeReadAreNamed) {
  write("c.obj", cubeObj());
  const auto noteOf = [&](const std::string& bytes) {
    write("m.mtl", "newmtl skin\nKd 0.5 1 1\nmap_Kd skin.png\n");
    if (!bytes.empty()) write("skin.png", bytes);
    const StoredMesh mesh = read("c.obj");
    EXPECT_EQ(mesh.colorsOf, "materials");
    EXPECT_TRUE(mesh.mesh.textures.empty() && mesh.mesh.uvs.empty() && mesh.mesh.textureOfFace.empty());
    EXPECT_EQ(mesh.mesh.colors, std::vector<Vec3s>(24, Vec3s(0.5f, 1, 1)));
    EXPECT_EQ(mesh.notes.size(), 1u);
    return mesh.notes.empty() ? "" : mesh.notes[0].code + ": " + mesh.notes[0].text;
  };
  const auto expect = [&](const std::string& bytes, const std::string& part) {
    const std::string note = noteOf(bytes);
    EXPECT_NE(note.find("mesh.textures-left-out: its texture '"), std::string::npos) << note;
    EXPECT_NE(note.find(part), std::string::npos) << note;
  };
  expect("", "no such file");
  expect("RIFF....WEBPVP8 ", "it is no PNG, JPEG, BMP, GIF or TGA picture");
  const std::string whole = bmp(4, 4, ramp);
  expect(whole.substr(0, 30), "it is damaged");
  // A picture that claims a huge size is refused before it is decoded.
  std::string huge = whole;
  huge.replace(18, 4, std::string("\0\0\x01\0", 4)), huge.replace(22, 4, std::string("\0\0\x01\0", 4));
  expect(huge, "4294967296 pixels");
  expect(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\0\0\0\1\0\0\x08\2\0\0\0", 29), "4294967296 pixels");
  std::string bare = cubeObj();
  for (size_t at = 0; (at = bare.find("\nvt", at)) != bare.npos;) bare.replace(at, 3, "\n#");
  write("skin.png", whole);
  write("c.obj", bare);
  EXPECT_EQ(read("c.obj").notes.at(0).code, "mesh.texture-coordinates-missing");
}

/// PNG of our own writer: floats become sRGB bytes and come back as linear light.
TEST(PictureTexture, IsDecodedFromSrgb) {
  Picture picture{16, 2, {}};
  for (int i = 0; i < 32; ++i)
    picture.rgba.insert(picture.rgba.end(), {float(i) / 31, 0.5f, 1 - float(i) / 31, 1});
  const auto texture = textureOfPicture(encodePng(picture), {TextureWrap::kClamp, TextureWrap::kClamp, true});
  ASSERT_EQ(texture->width(), 16);
  ASSERT_EQ(texture->height(), 2);
  // A byte of sRGB is at most 2.4 / 1.055 / 255 of linear light wide; rounding is half of it.
  for (int i = 0; i < 32; ++i) {
    const Vec3s color = texture->at({(i % 16 + 0.5) / 16, (i / 16 + 0.5) / 2});
    EXPECT_NEAR(color[0], double(i) / 31, 1.2 / 255);
    EXPECT_NEAR(color[1], 0.5, 1.2 / 255);
    EXPECT_NEAR(color[2], 1 - double(i) / 31, 1.2 / 255);
  }
}

TEST(Texture, IsWrappedAndBilinear) {
  std::vector<std::uint16_t> texels(12, 0);
  for (int i = 0; i < 4; ++i) texels[size_t(3 * i)] = std::uint16_t(i * 13107);  // red 0, 0.2, 0.4, 0.6
  const auto red = [&](const TextureSampling& sampling, double u, double texel = 1) {
    return double(Texture(4, 1, texels, sampling).at({u, 0.5}, texel)[0]);
  };
  const TextureSampling repeat, mirror{TextureWrap::kMirror, TextureWrap::kMirror},
      clamp{TextureWrap::kClamp, TextureWrap::kClamp},
      squares{TextureWrap::kRepeat, TextureWrap::kRepeat, true};
  EXPECT_NEAR(red(repeat, 0.375), 0.2, 1e-6);
  EXPECT_NEAR(red(repeat, 0.5), 0.3, 1e-6);
  EXPECT_NEAR(red(repeat, 0), 0.3, 1e-6);  // between the last and the first
  EXPECT_NEAR(red(repeat, -0.625), 0.2, 1e-6);
  EXPECT_NEAR(red(repeat, 7.375), 0.2, 1e-6);
  EXPECT_NEAR(red(mirror, 1.125), 0.6, 1e-6);
  EXPECT_NEAR(red(mirror, -0.375), 0.2, 1e-6);
  EXPECT_NEAR(red(clamp, 3), 0.6, 1e-6);
  EXPECT_NEAR(red(clamp, -3), 0, 1e-6);
  EXPECT_NEAR(red(squares, 0.49), 0.2, 1e-6);
  EXPECT_NEAR(red(squares, 0.51), 0.4, 1e-6);
  EXPECT_NEAR(red(clamp, 0.25, 2), 0.1, 1e-5);  // halved: 0.1, 0.5
  EXPECT_NEAR(red(clamp, 0.5, 4), 0.3, 1e-5);
  EXPECT_TRUE(std::isfinite(red(repeat, 1e300)) && std::isfinite(red(repeat, NAN)));
  EXPECT_THROW(Texture(4, 2, texels), InputError);
}

/// A square in the plane z = 0 of a GLB with a picture.
std::string squareGlb(const json& material, const json& sampler, const std::vector<float>& uvs,
                      const std::string& picture) {
  std::string data;
  json gltf = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0}}}}},
               {"nodes", {{{"mesh", 0}}}}};
  const auto view = [&](const void* from, size_t size) {
    data.resize((data.size() + 3) / 4 * 4, '\0');
    gltf["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", size}});
    data.append(static_cast<const char*>(from), size);
    return gltf["bufferViews"].size() - 1;
  };
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const std::vector<std::uint8_t> corners = {0, 1, 2, 0, 2, 3};
  gltf["accessors"] = {
      {{"bufferView", view(points.data(), 48)}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
      {{"bufferView", view(uvs.data(), 32)}, {"componentType", 5126}, {"count", 4}, {"type", "VEC2"}},
      {{"bufferView", view(corners.data(), 6)}, {"componentType", 5121}, {"count", 6}, {"type", "SCALAR"}}};
  gltf["images"] = {{{"bufferView", view(picture.data(), picture.size())}, {"mimeType", "image/png"}}};
  gltf["samplers"] = {sampler};
  gltf["textures"] = {{{"source", 0}, {"sampler", 0}}};
  gltf["materials"] = {material};
  gltf["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}, {"indices", 2}, {"material", 0}}}}}};
  gltf["buffers"] = {{{"byteLength", data.size()}}};
  std::string text = gltf.dump();
  text.resize((text.size() + 3) / 4 * 4, ' '), data.resize((data.size() + 3) / 4 * 4, '\0');
  const auto number = [](size_t value) {
    const auto n = std::uint32_t(value);
    return std::string(reinterpret_cast<const char*>(&n), 4);
  };
  return "glTF" + number(2) + number(28 + text.size() + data.size()) + number(text.size()) + "JSON" + text +
         number(data.size()) + std::string("BIN\0", 4) + data;
}

TEST_F(Textures, OfGlb) {
  const std::vector<float> uvs = {0, 1, 1, 1, 1, 0, 0, 0};
  const std::string picture = bmp(kRamp, kRamp, ramp);
  const json plain = {
      {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {0.5, 1, 1, 1}}}}};
  write("s.glb", squareGlb(plain, {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}, uvs, picture));
  const StoredMesh stored = read("s.glb");
  EXPECT_EQ(stored.colorsOf, "textures");
  EXPECT_EQ(stored.notes.at(0).code, "mesh.textures-read");
  const PolygonMesh& mesh = stored.mesh;
  EXPECT_EQ(mesh.colors, std::vector<Vec3s>(6, Vec3s(0.5f, 1, 1)));
  EXPECT_EQ(mesh.textureOfFace, (std::vector<int>{0, 0}));
  EXPECT_EQ(mesh.uvs[2], openvdb::Vec2s(1, 0));
  ASSERT_EQ(mesh.textures.size(), 1u);
  // Squares of one colour; clamped along u, mirrored along v.
  const auto at = [&](double u, double v) { return double(mesh.textures[0]->at({u, v})[0]); };
  EXPECT_NEAR(at(0.01, 0.5), linear(30), 1e-4);
  EXPECT_NEAR(at(7, 0.5), linear(30 + 3 * 63), 1e-4);
  EXPECT_NEAR(double(mesh.textures[0]->at({0.5, 1.01})[1]), linear(40 + 2 * 63), 1e-4);
  // KHR_texture_transform: scaled, turned anticlockwise on the picture (v goes down), moved.
  json turned = plain;
  turned["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.25, 0.5}}, {"rotation", std::acos(-1) / 2}, {"scale", {2, 3}}};
  write("s.glb", squareGlb(turned, json::object(), uvs, picture));
  const auto moved = read("s.glb").mesh.uvs;
  // (0, 1) -> (0, 3) -> (3, 0) -> (3.25, 0.5); (1, 1) -> (2, 3) -> (3, -2).
  EXPECT_TRUE(moved[0].eq(openvdb::Vec2s(3.25f, 0.5f), 1e-5f)) << moved[0];
  EXPECT_TRUE(moved[1].eq(openvdb::Vec2s(3.25f, -1.5f), 1e-5f)) << moved[1];
  // The specification's own example: the lower left quadrant of the picture, turned clockwise.
  turned["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 1}}, {"rotation", std::acos(-1) / 2}, {"scale", {0.5, 0.5}}};
  write("s.glb", squareGlb(turned, json::object(), uvs, picture));
  const auto quadrant = read("s.glb").mesh.uvs;
  EXPECT_TRUE(quadrant[0].eq(openvdb::Vec2s(0.5f, 1), 1e-5f)) << quadrant[0];  // of (0, 1)
  EXPECT_TRUE(quadrant[2].eq(openvdb::Vec2s(0, 0.5f), 1e-5f)) << quadrant[2];  // of (1, 0)
  json glossy = {{"extensions",
                  {{"KHR_materials_pbrSpecularGlossiness",
                    {{"diffuseFactor", {1, 0.5, 1, 1}}, {"diffuseTexture", {{"index", 0}}}}}}}};
  write("s.glb", squareGlb(glossy, json::object(), uvs, picture));
  EXPECT_EQ(read("s.glb").mesh.colors[0], Vec3s(1, 0.5f, 1));
  EXPECT_EQ(read("s.glb").mesh.textures.size(), 1u);
  write("s.glb", squareGlb(plain, json::object(), uvs, "no picture at all"));
  EXPECT_EQ(read("s.glb").notes.at(0).code, "mesh.textures-left-out");
  EXPECT_EQ(read("s.glb").colorsOf, "materials");
}

}  // namespace
}  // namespace slicemorph
