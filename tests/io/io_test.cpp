#include "engine/volume/voxelise.h"
#include "io/mesh/mesh_reader.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/file_info.h"
#include "slicemorph/io/input.h"
#include "slicemorph/io/output.h"
#include "slicemorph/io/vdb_reader.h"
#include "tests/support/surface_checks.h"

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <sys/mount.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

std::string readBytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void writeBytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

class Io : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("slicemorph_io_" + std::to_string(getpid()) + "_" +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    writeBytes(file(name), bytes);
    return file(name);
  }
  std::vector<std::string> leftovers() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename().string());
    return names;
  }

  fs::path folder_;
};

/// Path of a file of the shared real data (folder: SLICEMORPH_TEST_DATA); empty where it does not exist.
std::string realFile(const std::string& name) {
  const char* folder = std::getenv("SLICEMORPH_TEST_DATA");
  const fs::path path = fs::path(folder ? folder : "/work/shared/data") / name;
  return fs::exists(path) ? path.string() : "";
}

#define REAL_FILE(variable, name)              \
  const std::string variable = realFile(name); \
  if (variable.empty()) GTEST_SKIP() << name << " is not at hand; set SLICEMORPH_TEST_DATA"

/// The message of the Error that loading throws; else what happened instead.
template <typename Error>
std::string refusal(const std::string& input, const LoadOptions& options = {}) {
  try {
    loadObject(input, options);
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("another exception: ") + error.what();
  }
  return "it was read";
}

/// The severity of the first note on reading a mesh coarsely; kError if it is refused.
Severity severityOfReading(const std::string& path) {
  LoadOptions options;
  options.resolution = 32;
  try {
    const Notes notes = loadObject(path, options).notes;
    return notes.empty() ? Severity::kDetail : notes[0].severity;
  } catch (const Error&) {
    return Severity::kError;
  }
}

#define EXPECT_HAS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

FloatGrid::Ptr ball(double radius = 1, double voxel = 0.1, const Vec3d& centre = Vec3d(0.0)) {
  FloatGrid::Ptr grid = FloatGrid::create(float(3 * voxel));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  const int reach = int(radius / voxel) + 5;
  const openvdb::Coord middle = grid->transform().worldToIndexNodeCentered(centre);
  auto accessor = grid->getAccessor();
  for (openvdb::CoordBBox::Iterator<true> c(
           openvdb::CoordBBox(middle.offsetBy(-reach), middle.offsetBy(reach)));
       c; ++c) {
    const double d = (grid->indexToWorld(*c) - centre).length() - radius;
    if (std::abs(d) < 3 * voxel) {
      accessor.setValueOn(*c, float(d));
    } else if (d < 0) {
      accessor.setValueOff(*c, float(-3 * voxel));
    }
  }
  return grid;
}

LoadOptions coarse() {
  LoadOptions options;
  options.resolution = 32;
  return options;
}

const char* const kCubeObj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

const char* const kCubeOff =
    "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
    "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

const char* const kCubePly =
    "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement "
    "face 6\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 "
    "1 1\n"
    "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

/// A binary glTF of one tetrahedron under a node that scales by 2 and moves by (5, 0, 0).
std::string tetrahedronGlb() {
  const float points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::uint16_t corners[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  std::string data(reinterpret_cast<const char*>(points), sizeof points);
  data.append(reinterpret_cast<const char*>(corners), sizeof corners);
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
      R"("nodes":[{"mesh":0,"scale":[2,2,2],"translation":[5,0,0]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},)"
      R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],)"
      R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],)"
      R"("buffers":[{"byteLength":72}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto number = [](size_t value) {
    const auto n = std::uint32_t(value);
    return std::string(reinterpret_cast<const char*>(&n), 4);
  };
  return "glTF" + number(2) + number(12 + 8 + json.size() + 8 + data.size()) + number(json.size()) + "JSON" +
         json + number(data.size()) + std::string("BIN\0", 4) + data;
}

// ---------------------------------------------------------------- names

TEST_F(Io, OutputNamesNumberFrames) {
  const OutputName sequence("a#b/name.####.vdb");
  EXPECT_TRUE(sequence.isSequence());
  EXPECT_EQ(sequence.path(7), "a#b/name.0007.vdb");
  EXPECT_EQ(sequence.path(12345), "a#b/name.12345.vdb");
  EXPECT_EQ(sequence.extension(), ".vdb");
  EXPECT_FALSE(OutputName("a#b/name.OBJ").isSequence());
  EXPECT_EQ(OutputName("a#b/name.OBJ").path(3), "a#b/name.OBJ");
  EXPECT_EQ(OutputName("name.OBJ").extension(), ".obj");
}

// ---------------------------------------------------------------- meshes in

TEST_F(Io, EveryMeshFormatGivesTheCube) {
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"c.obj", kCubeObj}, {"c.OFF", kCubeOff}, {"c.ply", kCubePly}}) {
    const LoadedObject loaded = loadObject(write(name, bytes), coarse());
    EXPECT_EQ(loaded.object.name, "c");
    const double voxel = loaded.object.levelSet->voxelSize().x();
    EXPECT_NEAR(voxel, 1.0 / 32, 1e-9);
    // Edges and corners are cut by up to a voxel.
    EXPECT_NEAR(checks::volumeOf(surfaceOf(*loaded.object.levelSet)), 1, 12 * voxel * voxel) << name;
  }
}

TEST_F(Io, GlbNodesAreApplied) {
  const LoadedObject loaded = loadObject(write("t.glb", tetrahedronGlb()), coarse());
  const Mesh surface = surfaceOf(*loaded.object.levelSet);
  EXPECT_NEAR(checks::volumeOf(surface), 8.0 / 6, 0.05);
  for (const openvdb::Vec3s& p : surface.points) EXPECT_GT(p.x(), 4.9);
}

TEST_F(Io, RealMeshesAreReadAndRepaired) {
  REAL_FILE(bunny, "mesh/stanford-bunny.obj");
  const auto notes = loadObject(bunny, coarse()).notes;
  // One line for people; its parts are details.
  EXPECT_EQ(sentencesOf(notes), (std::vector<std::string>{
                                    "dropped 1113 points that no face uses; filled 5 holes (223 edges)",
                                    "dropped 1113 points that no face uses", "filled 5 holes (223 edges)"}));
  EXPECT_EQ(notes[0].severity, Severity::kNote);
  EXPECT_EQ(notes[1].severity, Severity::kDetail);
  // Coarser, the horse's legs are thinner than a voxel, which is told, too; as the shark's fins are here.
  EXPECT_EQ(sentencesOf(loadObject(realFile("mesh/horse_ref.obj"), LoadOptions()).notes),
            std::vector<std::string>{"filled 2 holes (19 edges)"});
  EXPECT_EQ(loadObject(realFile("mesh/shark.ply"), coarse()).notes.at(2).text,
            "turned 1 inside-out shell outwards");
  const std::string moebius = refusal<GeometryError>(realFile("mesh/moebius.obj"));
  EXPECT_HAS(moebius, "moebius.obj: the surface is not orientable: 112 boundary edges in 1 loop");
  EXPECT_HAS(moebius, "it is a sheet that encloses nothing: --shell ");
  const Note truck = loadObject(realFile("mesh/truck.obj"), coarse()).notes.at(0);
  EXPECT_HAS(truck.text, "the surface is open: 1388 boundary edges");
  EXPECT_HAS(truck.text, "54 edges with more than two faces");
  EXPECT_EQ(truck.severity, Severity::kWarning);
}

/// Meshes as people have them: closed solids all, but for what is truly a sheet.
/// A ball as map data has it: half a million metres east, five million north. Single precision has steps of .5 there.
/// Within two voxels of .3 its distances may miss those of a true ball of radius 5 by the depth of its triangles, twice
/// 5 (1 - cos(pi / 128)) or .003, and by a hundredth of a voxel, as OpenVDB looks for the nearest of a few triangles only.
TEST_F(Io, FarCoordinatesLoseNothing) {
  const Vec3d centre(500000.3, 5000000.7, 120.1);
  constexpr int kAround = 128, kRings = 64;
  std::vector<Vec3d> points;
  for (int r = 0; r <= kRings; ++r)
    for (int a = 0; a < (r % kRings ? kAround : 1); ++a) {
      const double down = M_PI * r / kRings, about = 2 * M_PI * a / kAround;
      points.push_back(centre + 5 * Vec3d(std::sin(down) * std::cos(about), std::sin(down) * std::sin(about),
                                          std::cos(down)));
    }
  const auto at = [&](int r, int a) {
    return r == 0 ? 0 : r == kRings ? int(points.size()) - 1 : 1 + (r - 1) * kAround + a % kAround;
  };
  std::vector<openvdb::Vec3I> triangles;
  for (int r = 0; r < kRings; ++r)
    for (int a = 0; a < kAround; ++a) {
      if (r > 0) triangles.emplace_back(at(r, a), at(r + 1, a), at(r, a + 1));
      if (r + 1 < kRings) triangles.emplace_back(at(r, a + 1), at(r + 1, a), at(r + 1, a + 1));
    }
  std::ostringstream obj, off, ply;
  obj.precision(15), off.precision(15);
  off << "OFF\n" << points.size() << " " << triangles.size() << " 0\n";
  ply << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
      << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << triangles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3d& p : points) {
    obj << "v " << p[0] << " " << p[1] << " " << p[2] << "\n",
        off << p[0] << " " << p[1] << " " << p[2] << "\n";
    ply.write(reinterpret_cast<const char*>(p.asPointer()), 24);
  }
  for (const openvdb::Vec3I& t : triangles) {
    obj << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
    off << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
    ply.put(3);
    ply.write(reinterpret_cast<const char*>(t.asPointer()), 12);
  }
  LoadOptions options;
  options.voxelSize = 0.3;
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"far.obj", obj.str()},
                                    {"far.off", off.str()},
                                    {"far.ply", ply.str()}}) {
    const FloatGrid::ConstPtr grid = loadObject(write(name, bytes), options).object.levelSet;
    double worst = 0;
    for (auto value = grid->cbeginValueOn(); value; ++value) {
      const double distance = (grid->indexToWorld(value.getCoord()) - centre).length() - 5;
      if (std::abs(*value) < 2 * options.voxelSize) worst = std::max(worst, std::abs(distance - *value));
    }
    EXPECT_LT(worst, 0.003 + 0.01 * options.voxelSize) << name;
    EXPECT_GT(grid->activeVoxelCount(), 1000u);
    // Written surfaces keep the digits, too; straight lines between voxels miss at most 3 / 8 of .3^2 / 5 more.
    for (const char* out : {"out.obj", "out.ply"}) {
      writeSurface(file(out), *grid);
      const StoredMesh back = readPolygons(parseInput(file(out)));
      for (const openvdb::Vec3s& p : back.mesh.points)
        ASSERT_NEAR((Vec3d(p) + back.origin - centre).length(), 5, 0.003 + 0.003 + 0.007)
            << name << " " << out;
    }
  }
}

TEST_F(Io, WildMeshesAreSolids) {
  REAL_FILE(first, "wild/trimesh__models_teapot.stl");
  for (const char* name :
       {"assimp__test_models_OBJ_regr01.obj", "assimp__test_models_STL_Wuson.stl",
        "manifold__test_models_openscad-nonmanifold-crash.obj", "meshoptimizer__demo_pirate.obj",
        "pmp-library__data_off_beetle.off", "pmp-library__data_off_hemisphere.off",
        "trimesh__models_angle_block.STL", "trimesh__models_chair_model.obj", "trimesh__models_teapot.stl",
        "trimesh__models_whitespace.off"}) {
    LoadOptions options;
    options.resolution = 64;
    const LoadedObject loaded = loadObject(realFile(std::string("wild/") + name), options);
    const Mesh surface = surfaceOf(*loaded.object.levelSet);
    EXPECT_EQ(checks::closedAndManifold(surface), "") << name;
    EXPECT_GT(checks::volumeOf(surface), 0) << name;
    size_t lines = 0;
    for (const Note& note : loaded.notes) lines += note.severity != Severity::kDetail;
    EXPECT_LE(lines, 1u) << name;
  }
  const std::string lego = realFile("wild/geometry-central__test_assets_lego.ply");
  EXPECT_HAS(refusal<GeometryError>(lego, coarse()), "encloses nothing: --shell 0.059 makes it a solid");
  LoadOptions thick = coarse();
  thick.shell = 0.059;
  EXPECT_GT(checks::volumeOf(surfaceOf(*loadObject(lego, thick).object.levelSet)), 0);
}

TEST_F(Io, RealSurfacesAreClosedManifoldAndOutward) {
  REAL_FILE(first, "mesh/armadillo.obj");
  for (const char* name :
       {"armadillo.obj", "bob_small.ply", "busted.stl", "fandisk.obj", "fertility.off", "hand1.off",
        "horse_ref.obj", "human_man.obj", "shark.ply", "spot.obj", "stanford-bunny.obj"}) {
    for (int resolution : {64, 128}) {
      LoadOptions options;
      options.resolution = resolution;
      const Mesh surface =
          surfaceOf(*loadObject(realFile(std::string("mesh/") + name), options).object.levelSet);
      EXPECT_EQ(checks::closedAndManifold(surface), "") << name << " " << resolution;
      EXPECT_EQ(checks::distinctPoints(surface), "") << name << " " << resolution;
      EXPECT_GT(checks::volumeOf(surface), 0) << name;
    }
  }
}

TEST_F(Io, TruncatedMeshesAreRefused) {
  const std::vector<std::pair<std::string, std::string>> meshes{
      {"c.off", kCubeOff}, {"c.ply", kCubePly}, {"c.obj", kCubeObj}, {"t.glb", tetrahedronGlb()}};
  for (const auto& [name, bytes] : meshes) {
    for (size_t size = 1; size + 4 < bytes.size(); ++size) {
      const std::string path = write(name, bytes.substr(0, size));
      // An OBJ that ends with a whole face is whole, for nothing in it counts faces: its open surface is warned of.
      if (name == "c.obj" && size >= bytes.find("f 3 7") && bytes[size - 1] == '\n') {
        EXPECT_EQ(severityOfReading(path), Severity::kWarning) << size;
        continue;
      }
      EXPECT_THROW(
          try { loadObject(path, coarse()); } catch (const GeometryError& error) {
            EXPECT_HAS(error.what(), path);
            throw IoError(error.what());
          },
          IoError)
          << name << " cut at " << size;
    }
  }
}

TEST_F(Io, TruncatedRealMeshesAreRefused) {
  REAL_FILE(first, "mesh/spot.obj");
  for (const char* name : {"spot.obj", "bob_small.ply", "shark.ply", "busted.stl", "hand1.off"}) {
    const std::string bytes = readBytes(realFile(std::string("mesh/") + name));
    for (size_t i = 0; i < 20; ++i) {
      const std::string path = write(name, bytes.substr(0, bytes.size() * i / 20 + 3));
      const std::string io = refusal<IoError>(path);
      const std::string why = io.find("another exception: ") == 0 ? io.substr(19) : io;
      EXPECT_EQ(why.find("it was read"), std::string::npos) << name << " " << i;
      EXPECT_EQ(why.find(path), 0u) << why;
    }
  }
}

TEST_F(Io, DamagedMeshesNameTheFault) {
  std::string obj = kCubeObj;
  obj.replace(obj.find("v 1 0 0"), 7, "v nan 0 0");
  EXPECT_HAS(refusal<IoError>(write("nan.obj", obj)), "line 2: vertex 2 is not finite (nan)");
  obj = std::string(kCubeObj) + "f 1 2 9\n";
  EXPECT_HAS(refusal<IoError>(write("index.obj", obj)), "line 15: a face refers to vertex 9, the file has 8");
  EXPECT_HAS(refusal<IoError>(write("cut.obj", std::string(kCubeObj) + "f 1 2")),
             "is truncated: the last line");
  EXPECT_HAS(refusal<IoError>(write("points.obj", "v 0 0 0\n")), "no faces");
  EXPECT_HAS(refusal<IoError>(write("noise.obj", "\x89PNG\r\n")), "no vertices");
  std::string ply = kCubePly;
  ply.replace(ply.find("1 0 0"), 5, "1 0 nan");
  EXPECT_HAS(refusal<IoError>(write("nan.ply", ply)), "point 2 is not finite");
  ply = kCubePly;
  ply.replace(ply.find("face 6"), 6, "face 4000000000");
  EXPECT_HAS(refusal<IoError>(write("absurd.ply", ply)), "the header says 4000000000 face");
  ply = kCubePly;
  ply.replace(ply.find("1 3 7 5"), 7, "1 3 7 8");
  EXPECT_HAS(refusal<IoError>(write("index.ply", ply)), "index.ply");
  ply = kCubePly;
  ply.insert(ply.find("element face"),
             "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n");
  EXPECT_HAS(refusal<IoError>(write("twice.ply", ply)), "its header has the element 'vertex' twice");
  const std::string deep = R"({"asset": {"version": "2.0", "extras": )" + std::string(400000, '[') +
                           std::string(400000, ']') + "}}";
  EXPECT_HAS(refusal<IoError>(write("deep.gltf", deep)), "its JSON nests deeper than 256 levels");
  std::string stl(84, '\0');
  stl[80] = 7;
  EXPECT_HAS(refusal<IoError>(write("short.stl", stl)), "is truncated: the header says 7 triangles");
  EXPECT_HAS(refusal<IoError>(write("short2.stl", "solid x\nfacet normal 0 0 1\n")), "is truncated");
}

TEST_F(Io, MissingAndWrongInputsAreNamed) {
  EXPECT_HAS(refusal<IoError>(file("none.obj")), "none.obj: no such file");
  EXPECT_HAS(refusal<IoError>(file("none.vdb:x")), "none.vdb: no such file");
  EXPECT_HAS(refusal<IoError>(write("empty.obj", "")), "is empty");
  EXPECT_HAS(refusal<IoError>(write("empty.vdb", "")), "is empty");
  EXPECT_HAS(refusal<InputError>(write("x.doc", "x")), "cannot read the extension '.doc'; use .vdb, .obj");
  EXPECT_HAS(refusal<IoError>(write("x.vdb", "this is no volume at all")),
             "x.vdb: cannot be read as a VDB file");
  fs::create_directory(file("folder.obj"));
  EXPECT_HAS(refusal<IoError>(file("folder.obj")), "is a folder");
  const std::string cube = write("c.obj", kCubeObj);
  LoadOptions options;
  options.resolution = 100000;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_HAS(refusal<InputError>(cube, options), "resolution 100000 is out of range: use 8 to 4096");
  options = {};
  options.voxelSize = 1e-7;
  EXPECT_HAS(refusal<InputError>(cube, options), "voxel size of at least");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
  options.voxelSize = -1;
  EXPECT_HAS(refusal<InputError>(cube, options), "voxel size -1");
}

/// An error's note names the file apart from the text, whether the error comes from the file, from a file
/// that it names or from the engine, which knows no files.
TEST_F(Io, ErrorsAreAboutTheFile) {
  const auto noteOf = [](const std::string& input, const LoadOptions& options = {}) {
    try {
      loadObject(input, options);
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()), error.note().sentence());
      return error.note();
    }
    return Note("test.read", Severity::kNote, "", "it was read");
  };
  const std::string cube = write("c.obj", std::string("mtllib m.mtl\nusemtl red\n") + kCubeObj);
  EXPECT_EQ(noteOf(write("cut.obj", std::string(kCubeObj) + "f 1 2")).about, file("cut.obj"));
  EXPECT_EQ(noteOf(write("x.doc", "x")).about, file("x.doc"));
  EXPECT_EQ(noteOf(file("none.vdb:x")).about, file("none.vdb"));
  LoadOptions options;
  options.voxelSize = 1e-7;
  EXPECT_EQ(noteOf(cube, options).about, file("c.obj"));
  EXPECT_HAS(noteOf(cube, options).text, "voxel size of at least");
  write("m.mtl", "newmtl red\nKd 1 nan 0\n");
  EXPECT_EQ(noteOf(cube).about, file("m.mtl"));
  // The grid's name looks like the file's: what an error is about does not depend on its text.
  writeSurface(file("grid.vdb"), *ball());
  EXPECT_EQ(noteOf(file("grid.vdb") + ":grid.vdb").about, file("grid.vdb"));
}

// ---------------------------------------------------------------- VDB

TEST_F(Io, LevelSetComesBackAsWritten) {
  const FloatGrid::Ptr grid = ball();
  SurfaceOutput output;
  output.vdb.framesPerSecond = 25;
  output.vdb.frame = 3;
  writeSurface(file("b.vdb"), *grid, output);
  EXPECT_EQ(grid->getName(), "");
  const LoadedObject loaded = loadObject(file("b.vdb"));
  EXPECT_TRUE(loaded.notes.empty());
  EXPECT_FALSE(loaded.halfFloat);
  const FloatGrid& read = *loaded.object.levelSet;
  EXPECT_EQ(read.getName(), "surface");
  EXPECT_EQ(read.getCreator(), "slicemorph 0.1.0");
  EXPECT_EQ(read.metaValue<float>("fps"), 25);
  EXPECT_EQ(read.metaValue<std::int32_t>("frame"), 3);
  EXPECT_EQ(read.metaValue<std::int64_t>("file_voxel_count"), std::int64_t(grid->activeVoxelCount()));
  ASSERT_EQ(read.activeVoxelCount(), grid->activeVoxelCount());
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    ASSERT_EQ(read.tree().getValue(value.getCoord()), *value);
  }
  output.halfFloat = true;
  writeSurface(file("h.vdb"), *grid, output);
  EXPECT_TRUE(loadObject(file("h.vdb")).halfFloat);
  EXPECT_TRUE(loadObject(file("h.vdb")).notes.empty());
}

TEST_F(Io, SameGridGivesTheSameBytes) {
  const FloatGrid::Ptr grid = ball();
  for (const char* extension : {".vdb", ".obj", ".ply", ".stl"}) {
    writeSurface(file(std::string("a") + extension), *grid);
    writeSurface(file(std::string("b") + extension), *grid);
    EXPECT_TRUE(readBytes(file(std::string("a") + extension)) ==
                readBytes(file(std::string("b") + extension)))
        << extension;
  }
  writeSurface(file("c.vdb"), *ball(1.01));
  EXPECT_NE(readBytes(file("a.vdb")).substr(21, 36), readBytes(file("c.vdb")).substr(21, 36));
}

TEST_F(Io, GridsAreChosenByName) {
  const auto named = [](FloatGrid::Ptr grid, const char* name, openvdb::GridClass gridClass) {
    grid->setName(name);
    grid->setGridClass(gridClass);
    return grid;
  };
  FloatGrid::Ptr far = FloatGrid::create(1e4f);
  far->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(9)), 1e4f);
  far->tree().setValue(openvdb::Coord(60), 1e4f);  // keeps it from being dense: those are tried last
  const openvdb::DoubleGrid::Ptr doubles(new openvdb::DoubleGrid(*ball(1.5)));
  doubles->setName("double");
  const auto vectors = openvdb::Vec3SGrid::create();
  vectors->setName("vel");
  openvdb::io::File(file("all.vdb"))
      .write(openvdb::GridCPtrVec{vectors, named(far, "far", openvdb::GRID_LEVEL_SET),
                                  named(ball(1), "same", openvdb::GRID_LEVEL_SET),
                                  named(ball(2), "same", openvdb::GRID_LEVEL_SET), doubles});
  const auto volume = [&](const std::string& input) {
    return std::cbrt(checks::volumeOf(surfaceOf(*loadObject(input).object.levelSet)) * 0.75 / M_PI);
  };
  EXPECT_NEAR(volume(file("all.vdb")), 1, 0.01);
  EXPECT_NEAR(volume(file("all.vdb") + ":same"), 1, 0.01);
  EXPECT_NEAR(volume(file("all.vdb") + ":same[1]"), 2, 0.01);
  EXPECT_NEAR(volume(file("all.vdb") + ":double"), 1.5, 0.01);
  EXPECT_HAS(loadObject(file("all.vdb")).notes.at(0).text,
             "took grid 'same[0]' of 5, a level set; 'far' is no shape: the grid has no");
  EXPECT_HAS(refusal<InputError>(file("all.vdb") + ":none"),
             "there is no grid 'none'; the file holds 'vel' (vec3s");
  EXPECT_HAS(refusal<InputError>(file("all.vdb") + ":vel"), "grid 'vel' holds vec3s values");
  EXPECT_HAS(refusal<GeometryError>(file("all.vdb") + ":far"), "grid 'far': the grid has no surface");
  const FileInfo info = describeFile(parseInput(file("all.vdb")));
  ASSERT_EQ(info.vdb.grids.size(), 5u);
  EXPECT_EQ(info.vdb.chosen, "same[0]");
  EXPECT_EQ(info.vdb.grids[0].type, "vec3s");
  EXPECT_EQ(info.vdb.grids[3].reading, "level set, as it is");
}

TEST_F(Io, RealVdbsAreRead) {
  REAL_FILE(sphere, "vdb/ls_sphere.vdb");
  const LoadedObject loaded = loadObject(sphere);
  EXPECT_TRUE(loaded.notes.empty());
  EXPECT_TRUE(loaded.halfFloat);
  EXPECT_EQ(loaded.object.levelSet->activeVoxelCount(), 270638u);
  const std::string gas = realFile("vdb/c42_gas_0006.vdb");
  EXPECT_HAS(refusal<GeometryError>(gas + ":phi_out"), "grid 'phi_out': the grid has no surface at 0");
  EXPECT_HAS(refusal<GeometryError>(gas + ":flame"), "empty");
  EXPECT_HAS(refusal<InputError>(gas + ":flags"), "holds int32 values");
  for (const std::string& input : {gas, gas + ":density", realFile("vdb/dragon_with_xform.vdb"),
                                   realFile("vdb/three_grids_same_name.vdb") + ":density[2]"}) {
    const Mesh surface = surfaceOf(*loadObject(input).object.levelSet);
    EXPECT_EQ(checks::closedAndManifold(surface), "") << input;
    EXPECT_GT(checks::volumeOf(surface), 0) << input;
  }
  EXPECT_EQ(describeFile(parseInput(gas)).vdb.grids.size(), 24u);
}

TEST_F(Io, FilesWithoutOffsetsAreRead) {
  {
    std::ofstream stream(file("s.vdb"), std::ios::binary);
    openvdb::io::Stream(stream).write(openvdb::GridCPtrVec{ball()});
  }
  EXPECT_TRUE(loadObject(file("s.vdb")).notes.empty());
}

/// Both by a reader that takes leaves at once and by one that takes them when they are asked for.
TEST_F(Io, BoolsAndMasksAreRead) {
  const auto bools = openvdb::BoolGrid::create(false);
  const auto mask = openvdb::MaskGrid::create();
  bools->setName("bools"), mask->setName("mask");
  for (int i = 0; i < 50; ++i) {
    bools->tree().setValue(openvdb::Coord(7 * i, 300 * i, -i), i % 3 == 0);
    mask->tree().setValueOn(openvdb::Coord(-5 * i, i, 200 * i));
  }
  openvdb::io::File(file("bits.vdb")).write(openvdb::GridCPtrVec{bools, mask});
  const VdbFile vdb(file("bits.vdb"));
  for (const bool later : {false, true}) {
    const auto read = [&](size_t index) { return later ? vdb.readDelayed(index) : vdb.read(index); };
    const auto readBools = openvdb::gridPtrCast<openvdb::BoolGrid>(read(0));
    const auto readMask = openvdb::gridPtrCast<openvdb::MaskGrid>(read(1));
    EXPECT_TRUE(readMask->tree().hasSameTopology(mask->tree()));
    EXPECT_TRUE(readBools->tree().hasSameTopology(bools->tree()));
    for (auto value = bools->cbeginValueOn(); value; ++value)
      EXPECT_EQ(readBools->tree().getValue(value.getCoord()), *value);
  }
}

TEST_F(Io, TruncatedVdbsAreRefused) {
  writeSurface(file("b.vdb"), *ball());
  const std::string real = realFile("vdb/ls_sphere.vdb"), gas = realFile("vdb/c42_gas_0006.vdb");
  for (const std::string& source : {file("b.vdb"), real, gas}) {
    const std::string bytes = readBytes(source);
    for (size_t i = 1; i <= 20 && !bytes.empty(); ++i) {
      const size_t size = i <= 10 ? bytes.size() * i / 11 : (i - 10) * (i - 10) * 9;
      const std::string path = write("cut.vdb", bytes.substr(0, std::min(size, bytes.size() - 1)));
      EXPECT_HAS(refusal<IoError>(path), path);
      EXPECT_THROW(describeFile(parseInput(path)), IoError);
    }
  }
}

TEST_F(Io, AbsurdSizesInAVdbAllocateNothing) {
  writeSurface(file("b.vdb"), *ball());
  const std::string bytes = readBytes(file("b.vdb"));
  // Every 32-bit word of the head in turn: string lengths, counts, offsets.
  for (size_t at = 57; at < 700; at += 7) {
    std::string bad = bytes;
    bad.replace(at, 4, "\xf0\xff\xff\x7f");
    const std::string path = write("bad.vdb", bad);
    try {
      loadObject(path);
    } catch (const std::runtime_error& error) {
      EXPECT_HAS(error.what(), path);
    }
  }
}

// ---------------------------------------------------------------- output

TEST_F(Io, MeshFilesComeBackClosedAndOutward) {
  const FloatGrid::Ptr grid = ball();
  const Mesh surface = surfaceOf(*grid);
  for (const char* name : {"b.obj", "b.ply", "b.stl"}) {
    writeSurface(file(name), *grid);
    const FileInfo info = describeFile(parseInput(file(name)));
    EXPECT_EQ(info.mesh.faces, surface.triangles.size()) << name;
    EXPECT_TRUE(info.mesh.closed) << name;
    EXPECT_TRUE(info.mesh.notes.empty()) << name << ": " << info.mesh.notes.at(0).text;
    EXPECT_NEAR(info.mesh.signedVolume, checks::volumeOf(surface), 1e-6) << name;
    EXPECT_EQ(info.mesh.boxMax, describeFile(parseInput(file("b.obj"))).mesh.boxMax) << name;
  }
}

template <typename Error>
std::string writeRefusal(const std::string& path) {
  try {
    writeSurface(path, *ball());
  } catch (const Error& error) {
    return error.what();
  }
  return "it was written";
}

TEST_F(Io, OutputsThatCannotBeAreNamedAndLeaveNothing) {
  EXPECT_HAS(writeRefusal<InputError>(file("b.xyz")), "cannot write the extension '.xyz'");
  EXPECT_HAS(writeRefusal<InputError>(file("b")), "without an extension");
  EXPECT_HAS(writeRefusal<IoError>(file("none/b.vdb")), "does not exist");
  write("plain", "x");
  EXPECT_HAS(writeRefusal<IoError>(file("plain/b.vdb")), "is no folder");
  fs::create_directory(file("taken.vdb"));
  EXPECT_HAS(writeRefusal<IoError>(file("taken.vdb")), "is a folder");
  EXPECT_HAS(writeRefusal<IoError>("/proc/b.vdb"), "/proc");
  EXPECT_EQ(leftovers().size(), 2u);
}

TEST_F(Io, FullDiskLeavesNoFile) {
  fs::create_directory(file("full"));
  if (::mount("tmpfs", file("full").c_str(), "tmpfs", 0, "size=64k") != 0)
    GTEST_SKIP() << "cannot mount a tmpfs";
  for (const char* name : {"full/b.vdb", "full/b.obj", "full/b.ply", "full/b.stl"}) {
    writeBytes(file(name), "old");
    EXPECT_HAS(writeRefusal<IoError>(file(name)), "No space left");
    EXPECT_EQ(readBytes(file(name)), "old");
    fs::remove(file(name));
  }
  EXPECT_TRUE(fs::is_empty(file("full")));
  ::umount(file("full").c_str());
}

}  // namespace
}  // namespace slicemorph
