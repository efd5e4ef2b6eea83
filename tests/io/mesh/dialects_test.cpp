#include "io/mesh/mesh_reader.h"
#include "slicemorph/errors.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

/// Mesh files as programs and people write them: each variant of one cube must give the cube, and what is no mesh
/// of its name must be refused by name.
namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using openvdb::Vec3s;

using Faces = std::vector<std::vector<std::uint32_t>>;

const std::vector<Vec3s> kCube = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0},
                                  {0, 0, 3}, {1, 0, 3}, {1, 2, 3}, {0, 2, 3}};
const Faces kQuads = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

StoredMesh read(const std::string& name, const std::string& bytes) {
  const fs::path path = fs::temp_directory_path() / ("slicemorph_" + std::to_string(getpid()) + name);
  std::ofstream(path, std::ios::binary) << bytes;
  struct Remove {
    fs::path path;
    ~Remove() { fs::remove(path); }
  } remove{path};
  return readPolygons(parseInput(path.string()));
}

std::string refusal(const std::string& name, const std::string& bytes) {
  try {
    read(name, bytes);
  } catch (const IoError& error) {
    return error.note().text;
  } catch (const GeometryError& error) {
    return error.note().text;
  }
  return "it was read";
}

#define EXPECT_REFUSED(name, bytes, part)                        \
  {                                                              \
    const std::string why = refusal(name, bytes);                \
    EXPECT_NE(why.find(part), std::string::npos) << name << why; \
  }

/// The faces with the places of their corners, whatever points are shared.
std::vector<std::vector<Vec3s>> placesOf(const PolygonMesh& mesh) {
  std::vector<std::vector<Vec3s>> faces;
  for (size_t f = 0; f < mesh.faceCount(); ++f) {
    faces.emplace_back();
    for (std::uint32_t k = mesh.faceStarts[f]; k < mesh.faceStarts[f + 1]; ++k)
      faces.back().push_back(mesh.points.at(mesh.corners[k]));
  }
  return faces;
}

std::vector<std::vector<Vec3s>> placesOf(const Faces& faces) {
  std::vector<std::vector<Vec3s>> places;
  for (const auto& face : faces) {
    places.emplace_back();
    for (const std::uint32_t corner : face) places.back().push_back(kCube[corner]);
  }
  return places;
}

Faces triangles() {
  Faces result;
  for (const auto& q : kQuads) result.push_back({q[0], q[1], q[2]}), result.push_back({q[0], q[2], q[3]});
  return result;
}

void expectCube(const StoredMesh& mesh, const Faces& faces, const std::string& what) {
  EXPECT_EQ(placesOf(mesh.mesh), placesOf(faces)) << what;
  EXPECT_EQ(mesh.faces, faces.size()) << what;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](char c) { return char(std::toupper(c)); });
  return text;
}

std::string numbersOf(const Vec3s& p) {
  std::ostringstream text;
  text << p[0] << " " << p[1] << " " << p[2];
  return text.str();
}

/// UTF-16 with its mark, as Windows' editors save "Unicode".
std::string utf16(const std::string& text, bool big) {
  std::string bytes = big ? "\xfe\xff" : "\xff\xfe";
  for (const char c : text) {
    if (big) bytes += '\0';
    bytes += c;
    if (!big) bytes += '\0';
  }
  return bytes;
}

/// What text formats have in common: line ends, marks, blanks.
std::vector<std::string> writings(const std::string& text) {
  return {text,
          replaced(text, "\n", "\r\n"),
          replaced(text, "\n", "\r"),
          "\xef\xbb\xbf" + text,
          utf16(text, false),
          utf16(text, true),
          replaced(text, "\n", " \t\n"),
          replaced(text, " ", "\t  "),
          replaced(text, "\n", "\n\n")};
}

// ---------------------------------------------------------------- OBJ

std::string obj() {
  std::string text = "# a cube\n";
  for (const Vec3s& p : kCube) text += "v " + numbersOf(p) + "\n";
  for (const auto& face : kQuads) {
    text += "f";
    for (const std::uint32_t corner : face) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

TEST(Dialects, Obj) {
  for (const std::string& text : writings(obj())) expectCube(read("c.obj", text), kQuads, text.substr(0, 40));
  expectCube(read("c.obj", upper(obj())), kQuads, "upper case");
  expectCube(read("c.obj", replaced(replaced(obj(), "v ", "  v "), "f ", "\tf ")), kQuads, "leading blanks");
  expectCube(read("c.obj", replaced(obj(), "f 1 4", "f 1 \\\n 4")), kQuads, "continued");
  expectCube(read("c.obj", replaced(obj(), "f 1 4", "f 1 \\\r\n 4")), kQuads, "continued, CR LF");
  expectCube(read("c.obj", replaced(obj(), "f 1 4 3 2", "f -8 -5 -6 -7 # below")), kQuads, "negative");
  expectCube(read("c.obj", replaced(obj(), "f 1 4 3 2", "vt 0 0\nvn 0 0 1\nf 1/1 4/1/1 3//1 2/1")), kQuads,
             "slashes");
  expectCube(read("c.obj", replaced(obj(), "v 1 0 0\n", "v +2e0 0 0 2\n")), kQuads, "weight");
  expectCube(read("c.obj", replaced(obj(), "f 1", "o x\ng y z\ns off\nl 1 2\np 3\nf 1")), kQuads, "others");
  // Faces may come before their points.
  const std::string text = obj();
  const size_t faces = text.find("f ");
  expectCube(read("c.obj", text.substr(faces) + text.substr(0, faces)), kQuads, "faces first");
}

TEST(Dialects, ObjFaults){
    EXPECT_REFUSED("f.obj", replaced(obj(), "v 1 0 0\n", "v 1,5 0 0\n"), "vertex 2, has '1,5' for a number")
        EXPECT_REFUSED("f.obj", replaced(obj(), "v 1 0 0\n", "v 1e999 0 0\n"),
                       "vertex 2 is not finite (1e999)")
            EXPECT_REFUSED("f.obj", replaced(obj(), "v 1 0 0\n", "v 1e200 0 0\n"), "vertex 2 is not finite")
                EXPECT_REFUSED("f.obj", replaced(obj(), "v 1 0 0\n", "v 1 0 0 0\n"), "weight 0")
                    EXPECT_REFUSED("f.obj", replaced(obj(), "f 1 4", "f -9 4"), "does not exist")
                        EXPECT_REFUSED("f.obj", replaced(obj(), "f 1 4", "f 0 4"), "does not exist")
                            EXPECT_REFUSED("f.obj", replaced(replaced(obj(), "f 1 4", "f 99 4"), "\n", "\r"),
                                           "line 10: a face refers to vertex 99")}

// ---------------------------------------------------------------- STL

std::string stl() {
  std::string text = "solid cube of mine\n";
  for (const auto& t : triangles()) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const std::uint32_t corner : t) text += "      vertex " + numbersOf(kCube[corner]) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid cube of mine\n";
}

std::string binaryStl(std::string header = "made by a test") {
  header.resize(80, ' ');
  const auto count = std::uint32_t(triangles().size());
  std::string bytes = header + std::string(reinterpret_cast<const char*>(&count), 4);
  for (const auto& t : triangles()) {
    bytes.append(12, '\0');
    for (const std::uint32_t corner : t)
      bytes.append(reinterpret_cast<const char*>(kCube[corner].asPointer()), 12);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(Dialects, Stl) {
  for (const std::string& text : writings(stl()))
    expectCube(read("c.stl", text), triangles(), text.substr(0, 40));
  expectCube(read("c.stl", upper(stl())), triangles(), "upper case");
  expectCube(read("c.stl", " \n" + stl()), triangles(), "leading blanks");
  expectCube(read("c.stl", replaced(stl(), "\n", " ")), triangles(), "one line");
  expectCube(read("c.stl", replaced(stl(), "endfacet", "end facet")), triangles(), "two words");
  expectCube(read("c.stl", replaced(stl(), " cube of mine", "")), triangles(), "no name");
  expectCube(read("c.stl", stl() + std::string(3, '\0') + "\x1a"), triangles(), "padded");
  std::string two = stl();
  two.insert(two.find("  facet", two.size() / 2), "endsolid a\nSolid b facet\n");
  expectCube(read("c.stl", two), triangles(), "two solids");
  expectCube(read("c.stl", binaryStl()), triangles(), "binary");
  EXPECT_TRUE(read("c.stl", binaryStl()).notes.empty());
  for (const char* header : {"solid", "solid facet", "  SOLID x", "ply", "OFF", "v 0 0 0"})
    expectCube(read("c.stl", binaryStl(header)), triangles(), header);
  // Bytes that follow are told, also behind a header that could be text.
  for (const char* header : {"", "solid x"})
    for (const size_t more : {1, 37, 50, 500}) {
      const StoredMesh mesh = read("c.stl", binaryStl(header) + std::string(more, 'x'));
      expectCube(mesh, triangles(), "trailing bytes");
      ASSERT_EQ(mesh.notes.size(), 1u);
      EXPECT_EQ(mesh.notes[0].code, "mesh.trailing-bytes");
      EXPECT_NE(mesh.notes[0].text.find(std::to_string(more) + " bytes"), std::string::npos);
    }
}

TEST(Dialects, StlFaults) {
  EXPECT_REFUSED("f.stl", replaced(stl(), "vertex 1 2 3", "vertex 1 two 3"), "has 'two' for a number")
  EXPECT_REFUSED("f.stl", replaced(stl(), "vertex 1 2 3", "vertex 1 nan 3"), "is not finite")
  EXPECT_REFUSED("f.stl", replaced(stl(), "endsolid", "x"), "is truncated")
  EXPECT_REFUSED("f.stl", replaced(stl(), "    endloop\n", "vertex 0 0 0\nendloop\n"),
                 "facet 1 has 4 vertices")
  EXPECT_REFUSED("f.stl", "solid a\nendsolid a\n", "no facets")
  std::string nan = binaryStl();
  nan.replace(84 + 12, 4, std::string("\0\0\xc0\x7f", 4));
  EXPECT_REFUSED("f.stl", nan, "point 1 is not finite")
  const size_t lastLine = stl().rfind("endsolid");
  for (size_t size = 1; size < lastLine; size += 7)
    EXPECT_NE(refusal("f.stl", stl().substr(0, size)), "it was read") << size;
  EXPECT_REFUSED("f.stl", binaryStl().substr(0, 600), "is truncated")
}

// ---------------------------------------------------------------- OFF

std::string offPoints(const std::string& after = "") {
  std::string text;
  for (const Vec3s& p : kCube) text += numbersOf(p) + after + "\n";
  return text;
}

std::string offFaces(const std::string& after = "") {
  std::string text;
  for (const auto& face : kQuads) {
    text += "4";
    for (const std::uint32_t corner : face) text += " " + std::to_string(corner);
    text += after + "\n";
  }
  return text;
}

TEST(Dialects, Off) {
  const std::string body = offPoints() + offFaces();
  for (const std::string& text : writings("OFF\n8 6 12\n" + body))
    expectCube(read("c.off", text), kQuads, text.substr(0, 40));
  for (const char* head :
       {"OFF 8 6 12\n", "OFF8 6 12 # or not\n", " \n# first\n\nOFF # second\n# third\n8 6 12\n", "OFF\n8 6\n",
        "OFF\n8\n6\n12\n", "OFF\n8\n6\n", "8 6 12\n", "off\n8 6 12\n"})
    expectCube(read("c.off", head + body), kQuads, head);
  expectCube(read("c.off", "OFF 8 6 0 " + replaced(body, "\n", " ")), kQuads, "one line");
  expectCube(read("c.off", "OFF\n8 6 0\n" + replaced(body, " ", "\n")), kQuads, "a number a line");
  expectCube(read("c.off", replaced("OFF\n8 6 12\n" + body, "\n", " # comment 3 4\n")), kQuads, "comments");
  expectCube(read("c.off", "NOFF\n8 6 0\n" + offPoints(" 0 0 1") + offFaces()), kQuads, "normals");
  expectCube(read("c.off", "STOFF\n8 6 0\n" + offPoints(" .5 .5") + offFaces()), kQuads, "texture");
  expectCube(read("c.off", "STCNOFF 8 6 0\n" + offPoints(" 0 0 1 255 0 51 255 .5 .5") + offFaces()), kQuads,
             "all");
  expectCube(read("c.off", "4OFF\n8 6 0\n" + replaced(offPoints(" 1"), "1 2 3 1", "2 4 6 2") + offFaces()),
             kQuads, "4");
  const StoredMesh more = read("c.off", "OFF\n8 6 12\n" + body + "0 1\n");
  expectCube(more, kQuads, "lines that follow");
  ASSERT_EQ(more.notes.size(), 1u);
  EXPECT_EQ(more.notes[0].code, "mesh.trailing-bytes");
}

TEST(Dialects, OffColours) {
  const auto colorsOf = [](const std::string& text, const char* whose) {
    const StoredMesh mesh = read("c.off", text);
    expectCube(mesh, kQuads, text.substr(0, 30));
    EXPECT_EQ(mesh.colorsOf, whose) << text;
    return mesh.mesh.colors;
  };
  const Vec3s color(1, 0, 0.2f);
  for (const char* given : {" 255 0 51 255", " 255 0 51", " 1 0 0.2", " 1.0 0.0 0.2 1.0"}) {
    EXPECT_EQ(colorsOf("COFF\n8 6 0\n" + offPoints(given) + offFaces(), "points"),
              std::vector<Vec3s>(24, color));
    EXPECT_EQ(colorsOf("OFF\n8 6 0\n" + offPoints(given) + offFaces(), "points"),
              std::vector<Vec3s>(24, color));
    EXPECT_EQ(colorsOf("OFF\n8 6 0\n" + offPoints() + offFaces(given), "faces"),
              std::vector<Vec3s>(24, color));
  }
  // An index into a map of colours is none; faces without one are white where others have one.
  EXPECT_TRUE(colorsOf("OFF\n8 6 0\n" + offPoints() + offFaces(" 3"), "").empty());
  std::string some = offFaces();
  some.insert(some.find('\n'), " 255 0 51");
  const std::vector<Vec3s> colors = colorsOf("OFF\n8 6 0\n" + offPoints() + some, "faces");
  EXPECT_EQ(colors[3], color);
  EXPECT_EQ(colors[4], Vec3s(1.f));
}

/// Geomview's binary files are big endian and count the colours of every face; pmp-library's are neither.
std::string binaryOff(bool big, bool counted, const std::string& head, size_t more) {
  std::string bytes = head + "OFF BINARY\n";
  const auto add = [&](auto number) {
    char raw[4];
    std::memcpy(raw, &number, 4);
    if (big) std::reverse(raw, raw + 4);
    bytes.append(raw, 4);
  };
  for (const int n : {8, 6, 12}) add(n);
  for (const Vec3s& p : kCube) {
    for (int c = 0; c < 3; ++c) add(p[c]);
    for (size_t k = 0; k < more; ++k) add(0.5f);
  }
  for (size_t f = 0; f < kQuads.size(); ++f) {
    add(4);
    for (const std::uint32_t corner : kQuads[f]) add(corner);
    if (counted) add(f == 0 ? 3 : 0);
    for (int c = 0; counted && f == 0 && c < 3; ++c) add(0.25f);
  }
  return bytes;
}

TEST(Dialects, BinaryOff) {
  for (const bool big : {false, true})
    for (const bool counted : {false, true}) {
      const StoredMesh mesh = read("c.off", binaryOff(big, counted, "", 0));
      expectCube(mesh, kQuads, "binary");
      EXPECT_EQ(mesh.colorsOf, counted ? "faces" : "");
      expectCube(read("c.off", binaryOff(big, counted, "N", 3)), kQuads, "binary, normals");
      expectCube(read("c.off", binaryOff(big, counted, "C", 4)), kQuads, "binary, colours");
      const std::string whole = binaryOff(big, counted, "", 0);
      for (size_t size = 12; size < whole.size(); ++size)
        EXPECT_REFUSED("f.off", whole.substr(0, size), "truncated")
    }
}

TEST(Dialects, OffFaults) {
  EXPECT_REFUSED("f.off", "OFF\n8 6 12\n" + offPoints() + replaced(offFaces(), "4 0 3", "4 9 3"),
                 "face 1 refers to vertex 9, the file has 8, counted from 0")
  EXPECT_REFUSED("f.off", "OFF\n8 6 12\n" + offPoints() + replaced(offFaces(), "4 0 3", "4 -1 3"),
                 "vertex -1")
  EXPECT_REFUSED("f.off", "OFF\n8 6 12\n" + replaced(offPoints(), "1 2 3", "1 nan 3") + offFaces(),
                 "not finite")
  EXPECT_REFUSED("f.off", "OFF\n8 6 12\n" + replaced(offPoints(), "1 2 3", "1 2") + offFaces(), "is damaged")
  EXPECT_REFUSED("f.off", "OFF\n8 6 12\n" + replaced(offPoints(), "1 2 3", "1 x 3") + offFaces(),
                 "'x' stands for")
  EXPECT_REFUSED("f.off", "OFF\n8 6000000000 12\n" + offPoints() + offFaces(), "is truncated")
  EXPECT_REFUSED("f.off", "nOFF\n4\n8 6 12\n" + offPoints() + offFaces(), "any dimension")
  EXPECT_REFUSED("f.off", "some text\n", "is no OFF file")
}

// ---------------------------------------------------------------- PLY

struct PlyWriter {
  bool text = true, big = false;
  std::string bytes = {};

  template <typename Number>
  void add(Number number) {
    if (text) {
      bytes += std::to_string(number) + " ";
      return;
    }
    char raw[sizeof(Number)];
    std::memcpy(raw, &number, sizeof number);
    if (big) std::reverse(raw, raw + sizeof number);
    bytes.append(raw, sizeof number);
  }
  void endRow() {
    if (text) bytes += "\n";
  }
};

/// A cube with elements and properties that nobody asked for, faces before points, of the given line ends.
template <typename Real, typename Index>
std::string oddPly(const std::string& format, const char* real, const char* index, const char* list,
                   const std::string& lineEnd) {
  PlyWriter body{format == "ascii", format == "binary_big_endian"};
  body.add(std::int32_t(1)), body.add(double(2.5)), body.add(std::int16_t(-3)), body.endRow();
  for (const auto& face : kQuads) {
    body.add(std::uint8_t(7));
    body.add(std::int16_t(2)), body.add(float(0.5)), body.add(float(1.5));
    body.add(Index(face.size()));
    for (const std::uint32_t corner : face) body.add(Index(corner));
    body.endRow();
  }
  for (const Vec3s& p : kCube) {
    body.add(Real(p[2])), body.add(std::int8_t(-1)), body.add(Real(p[0]));
    body.add(std::uint8_t(1)), body.add(double(8)), body.add(Real(p[1])), body.endRow();
  }
  const std::string head =
      "ply\ncomment element vertex 99\nformat " + format +
      " 1.0\nobj_info made by a test\nelement camera 1\nproperty list int double view\nproperty short id\n"
      "element face 6\nproperty uchar flags\nproperty list short float texcoord\nproperty list " +
      index + " " + index + " " + list + "\nelement vertex 8\ncomment in between\nproperty " + real +
      " z\nproperty char q\nproperty " + real + " x\nproperty list uchar float64 w\nproperty " + real +
      " y\nend_header\n";
  return replaced(head, "\n", lineEnd) +
         (format == "ascii" ? replaced(body.bytes, "\n", lineEnd) : body.bytes);
}

TEST(Dialects, Ply) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    for (const char* lineEnd : {"\n", "\r\n", "\r"}) {
      const std::string what = format + std::string(lineEnd);
      expectCube(
          read("c.ply", oddPly<float, std::uint8_t>(format, "float", "uchar", "vertex_indices", lineEnd)),
          kQuads, what);
      expectCube(
          read("c.ply", oddPly<double, std::int32_t>(format, "double", "int", "vertex_index", lineEnd)),
          kQuads, what);
      expectCube(read("c.ply", oddPly<std::int16_t, std::uint16_t>(format, "int16", "uint16", "vertex_index",
                                                                   lineEnd)),
                 kQuads, what);
      expectCube(
          read("c.ply", oddPly<std::int32_t, float>(format, "int32", "float32", "vertex_index", lineEnd)),
          kQuads, what);
    }
  const std::string whole = oddPly<float, float>("binary_big_endian", "float", "float", "vertex_index", "\n");
  const size_t body = whole.find("end_header");
  for (size_t size = body; size < whole.size(); ++size)
    EXPECT_REFUSED("f.ply", whole.substr(0, size), "truncated")
  expectCube(read("c.ply", "\xef\xbb\xbf" +
                               oddPly<float, std::int32_t>("ascii", "float", "int", "vertex_index", "\n")),
             kQuads, "mark");
}

/// In a body after lines that end with CR the first byte may be that of a line's end.
TEST(Dialects, PlyBodyThatBeginsLikeALineEnd) {
  std::string bytes =
      oddPly<float, std::uint8_t>("binary_little_endian", "float", "uchar", "vertex_index", "\r");
  bytes[bytes.find("end_header") + 11] = '\n';
  bytes.insert(bytes.find("end_header") + 15,
               std::string(8 * 9, '\0'));  // the list of 10 that it now begins with
  expectCube(read("c.ply", bytes), kQuads, "CR");
}

// ---------------------------------------------------------------- what is no mesh of its name

TEST(Dialects, WhatAFileIsIsTold) {
  const std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  for (const char* name : {"f.stl", "f.obj", "f.ply", "f.off", "f.glb"})
    EXPECT_REFUSED(name, png + std::string(100, '\0'), "is a PNG picture")
  const std::string ply = oddPly<float, std::uint8_t>("ascii", "float", "uchar", "vertex_index", "\n");
  EXPECT_REFUSED("f.obj", ply, "is no OBJ mesh: by its content it is a PLY mesh; name it .ply")
  EXPECT_REFUSED("f.stl", ply, "a PLY mesh")
  EXPECT_REFUSED("f.stl", obj(), "an OBJ mesh; name it .obj")
  EXPECT_REFUSED("f.obj", binaryStl(), "an STL mesh; name it .stl")
  EXPECT_REFUSED("f.ply", upper(stl()), "an STL mesh")
  EXPECT_REFUSED("f.obj", "OFF\n8 6 12\n" + offPoints() + offFaces(), "an OFF mesh")
  EXPECT_REFUSED("f.obj", "glTF\2\0\0\0", "binary glTF")
  EXPECT_REFUSED("f.glb", R"({"asset": {"version": "2.0"}})", "a glTF file in text; name it .gltf")
  EXPECT_REFUSED("f.obj", "\xff\xd8\xff\xe0 JFIF", "a JPEG picture")
  EXPECT_REFUSED("f.stl", "PK\3\4 and more", "a ZIP archive")
  EXPECT_REFUSED("f.obj", "\x1f\x8b\x08 and more", "compressed with gzip")
  EXPECT_REFUSED("f.ply", "\n <!DOCTYPE html><html></html>", "a web page")
  EXPECT_REFUSED("f.stl", "version https://git-lfs.github.com/spec/v1\n", "Git LFS pointer")
  EXPECT_REFUSED("f.obj", "Kaydara FBX Binary  ", "an FBX file")
  EXPECT_REFUSED("f.ply", " BDV\0\0\0\0", "an OpenVDB file; name it .vdb")
}

}  // namespace
}  // namespace slicemorph
