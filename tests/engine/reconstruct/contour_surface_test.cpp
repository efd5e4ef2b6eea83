#include "engine/reconstruct/contour_labels.h"
#include "engine/reconstruct/plane_section.h"
#include "io/contours/contour_reader.h"
#include "slicemorph/errors.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"
#include "tests/support/surface_checks.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <unordered_map>

namespace slicemorph {
namespace {

using Plane = std::pair<Vec3d, Vec3d>;  // a point and a normal

class Contours : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
};

/// The contours of a shape on one plane, exact at their points: marching squares, with the crossings
/// found by bisection.
class Cutter {
 public:
  Cutter(const shapes::Distance& shape, const Plane& plane, double half, double step)
      : shape_(shape),
        plane_(planeAt(plane.first, plane.second)),
        count_(int(2 * half / step)),
        half_(half),
        step_(step) {}

  PlaneContours cut() {
    for (int j = 0; j < count_; ++j)
      for (int i = 0; i < count_; ++i) cell(i, j);
    std::set<Key> done;
    for (const auto& start : next_) {
      std::vector<Vec2d> loop;
      for (Key at = start.first; done.insert(at).second; at = next_.at(at)) loop.push_back(points_.at(at));
      if (loop.size() > 2) plane_.loops.push_back(loop);
    }
    return plane_;
  }

 private:
  using Key = std::array<int, 3>;  // node and direction of an edge of the grid

  Vec2d node(int i, int j) const { return {-half_ + step_ * i + 1.1e-5, -half_ + step_ * j + 1.7e-5}; }
  bool in(const Vec2d& p) const { return shape_(plane_.toWorld(p)) < 0; }
  Key crossing(int i, int j, int direction) {
    const Key key{i, j, direction};
    if (points_.count(key)) return key;
    Vec2d a = node(i, j), b = direction ? node(i, j + 1) : node(i + 1, j);
    const bool first = in(a);
    for (int k = 0; k < 40; ++k) {
      const Vec2d middle = 0.5 * (a + b);
      (in(middle) == first ? a : b) = middle;
    }
    points_[key] = a;
    return key;
  }
  void cell(int i, int j) {
    const bool corner[4] = {in(node(i, j)), in(node(i + 1, j)), in(node(i + 1, j + 1)), in(node(i, j + 1))};
    const auto side = [&](int k) {
      return k == 0   ? crossing(i, j, 0)
             : k == 1 ? crossing(i + 1, j, 1)
             : k == 2 ? crossing(i, j + 1, 0)
                      : crossing(i, j, 1);
    };
    std::vector<Key> from, to;
    for (int k = 0; k < 4; ++k) {
      if (corner[k] && !corner[(k + 1) % 4]) from.push_back(side(k));
      if (!corner[k] && corner[(k + 1) % 4]) to.push_back(side(k));
    }
    for (size_t k = 0; k < from.size(); ++k) next_[from[k]] = to[k];
  }

  const shapes::Distance& shape_;
  PlaneContours plane_;
  int count_;
  double half_, step_;
  std::map<Key, Key> next_;
  std::map<Key, Vec2d> points_;
};

ContourSet cut(const shapes::Distance& shape, const std::vector<Plane>& planes, double half, double step) {
  ContourSet set;
  set.name = "shape";
  set.planes.resize(planes.size());
  tbb::parallel_for(size_t(0), planes.size(),
                    [&](size_t i) { set.planes[i] = Cutter(shape, planes[i], half, step).cut(); });
  return set;
}

struct Topology {
  int pieces = 0;
  double genus = 0;
};

Topology topologyOf(const Mesh& mesh) {
  std::vector<unsigned> root(mesh.points.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](unsigned a) {
    while (root[a] != a) a = root[a] = root[root[a]];
    return a;
  };
  for (const openvdb::Vec3I& t : mesh.triangles) root[find(t[0])] = find(t[1]), root[find(t[1])] = find(t[2]);
  Topology out;
  for (unsigned i = 0; i < root.size(); ++i) out.pieces += find(i) == i;
  const double euler = double(mesh.points.size()) - double(mesh.triangles.size()) / 2;
  out.genus = out.pieces - euler / 2;
  return out;
}

double meanError(const Mesh& mesh, const shapes::Distance& shape) {
  double sum = 0;
  for (const openvdb::Vec3s& p : mesh.points) sum += std::abs(shape(Vec3d(p)));
  return sum / double(mesh.points.size());
}

/// Distance of a point to a triangle, by clamping to the sides (Eberly, Geometric Tools).
double distanceToTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto side = [&](const Vec3d& u, const Vec3d& v) {
    const Vec3d d = v - u;
    const double l = d.lengthSqr();
    return (p - u - (l > 0 ? std::clamp((p - u).dot(d) / l, 0.0, 1.0) : 0.0) * d).length();
  };
  const Vec3d n = (b - a).cross(c - a);
  if (n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 &&
      n.dot((a - c).cross(p - c)) >= 0 && n.lengthSqr() > 0)
    return std::abs((p - a).dot(n)) / n.length();
  return std::min({side(a, b), side(b, c), side(c, a)});
}

/// The largest distance of a contour point to the mesh. Triangles are sorted into bins of size `bin`;
/// distances above that are reported as `bin`.
double farthestContourPoint(const ContourSet& set, const Mesh& mesh, double bin) {
  std::map<std::array<int, 3>, std::vector<size_t>> bins;
  const auto cellOf = [&](const Vec3d& p) {
    return std::array<int, 3>{int(std::floor(p[0] / bin)), int(std::floor(p[1] / bin)),
                              int(std::floor(p[2] / bin))};
  };
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    openvdb::BBoxd box;
    for (int k = 0; k < 3; ++k) box.expand(Vec3d(mesh.points[mesh.triangles[t][k]]));
    const auto low = cellOf(box.min()), high = cellOf(box.max());
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) bins[{x, y, z}].push_back(t);
  }
  double farthest = 0;
  for (const PlaneContours& plane : set.planes)
    for (const auto& loop : plane.loops)
      for (const Vec2d& q : loop) {
        const Vec3d p = plane.toWorld(q);
        const auto at = cellOf(p);
        double least = bin;
        for (int n = 0; n < 27; ++n) {
          const auto found = bins.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
          if (found == bins.end()) continue;
          for (size_t t : found->second) {
            const openvdb::Vec3I& v = mesh.triangles[t];
            least = std::min(least, distanceToTriangle(p, Vec3d(mesh.points[v[0]]), Vec3d(mesh.points[v[1]]),
                                                       Vec3d(mesh.points[v[2]])));
          }
        }
        farthest = std::max(farthest, least);
      }
  return farthest;
}

/// Pixels of the planes where the level set has the wrong sign by more than the diagonal of a cell, below
/// which a lattice may miss a detail.
int contradictions(const ContourSet& set, const ContourSurface& surface) {
  const double h = surface.voxelSize;
  const auto values = surface.grid->getConstAccessor();
  Notes notes;
  int count = 0;
  for (const PlaneContours& plane : set.planes) {
    const PlaneImage image = distanceImage(sectionOf(plane, 1e-4 * h, "", notes), h, 3 * h);
    for (int j = 0; j < image.height; ++j)
      for (int i = 0; i < image.width; ++i) {
        const double d = image.distance[size_t(j) * image.width + i];
        const Vec3d at = surface.grid->worldToIndex(plane.toWorld(image.position(i, j)));
        if (std::abs(d) > std::sqrt(3.0) * h)
          count += (openvdb::tools::BoxSampler::sample(values, at) < 0) != (d < 0);
      }
  }
  return count;
}

// Closed forms.

constexpr double kRing = 3, kTube = 1;

void expectTorus(const std::vector<Plane>& planes, const char* what) {
  SCOPED_TRACE(what);
  const shapes::Distance torus = shapes::torus(Vec3d(0.0), kRing, kTube);
  const ContourSet set = cut(torus, planes, 8, 0.12);
  const ContourSurface surface = contourSurface(set);
  const Mesh mesh = contourMesh(set, surface);
  EXPECT_EQ(checks::closedAndManifold(mesh), "");
  const Topology topology = topologyOf(mesh);
  EXPECT_EQ(topology.pieces, 1);
  EXPECT_EQ(topology.genus, 1);
  EXPECT_LT(meanError(mesh, torus), 0.02 * kTube);
  EXPECT_LT(farthestContourPoint(set, mesh, surface.voxelSize), 0.5 * surface.voxelSize);
}

std::vector<Plane> acrossTheRing(double lean, double turn) {
  std::vector<Plane> planes;
  for (int k = 0; k < 20; ++k) {
    const double a = 2 * M_PI * k / 20, sign = k % 2 ? 1 : -1;
    const Vec3d along(-std::sin(a), std::cos(a), 0), out(std::cos(a), std::sin(a), 0);
    planes.emplace_back(
        kRing * out, (along + sign * std::tan(lean) * Vec3d(0, 0, 1) + sign * std::tan(turn) * out).unit());
  }
  return planes;
}

std::vector<Plane> tiltedStack(double degrees) {
  const double a = degrees * M_PI / 180, half = kRing * std::sin(a) + kTube;
  const Vec3d normal(std::sin(a), 0, std::cos(a));
  std::vector<Plane> planes;
  for (int k = 0; k < 20; ++k) planes.emplace_back(normal * (-half + 2 * half * (k + 0.5) / 20), normal);
  return planes;
}

std::vector<Plane> anywhere() {
  std::vector<Plane> planes;
  unsigned seed = 12345;
  const auto random = [&] {
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) / double(1 << 24) - 0.5;
  };
  for (int k = 0; k < 20; ++k) {
    Vec3d n;
    for (int a = 0; a < 3; ++a) n[a] = random();
    n.normalize();
    planes.emplace_back(n * (5 * random()), n);
  }
  return planes;
}

TEST_F(Contours, TorusOnTwentyTiltedPlanes) {
  expectTorus(acrossTheRing(15 * M_PI / 180, 0), "planes across the ring, leaning in turns");
  expectTorus(acrossTheRing(0, 20 * M_PI / 180), "planes across the ring, turned in turns");
  expectTorus(tiltedStack(30), "a stack at 30 degrees to the axis");
  expectTorus(tiltedStack(60), "a stack at 60 degrees to the axis");
  expectTorus(anywhere(), "planes in general position");
}

TEST_F(Contours, SphereOnThreePlanesThatCross) {
  const shapes::Distance ball = shapes::sphere(Vec3d(0.0), 1);
  const ContourSet set =
      cut(ball, {{Vec3d(0.0), Vec3d(1, 0, 0)}, {Vec3d(0.0), Vec3d(0, 1, 0)}, {Vec3d(0.0), Vec3d(0, 0, 1)}}, 2,
          0.05);
  const Mesh mesh = contourMesh(set, contourSurface(set));
  EXPECT_EQ(checks::closedAndManifold(mesh), "");
  EXPECT_EQ(topologyOf(mesh).pieces, 1);
  EXPECT_EQ(topologyOf(mesh).genus, 0);
  EXPECT_LT(meanError(mesh, ball), 0.02);
}

std::vector<Plane> stack(int count, double gap) {
  std::vector<Plane> planes;
  for (int k = 0; k < count; ++k)
    planes.emplace_back(Vec3d(0, 0, gap * (k - 0.5 * (count - 1))), Vec3d(0, 0, 1));
  return planes;
}

TEST_F(Contours, SlantedTubeStaysWhole) {
  // The contours are 1 wide and shifted by 2: none overlaps the next.
  const Vec3d axis = Vec3d(2, 0, 1).unit();
  const shapes::Distance tube = [&](const Vec3d& p) { return (p - p.dot(axis) * axis).length() - 0.5; };
  const ContourSet set = cut(tube, stack(8, 1), 9, 0.08);
  const Mesh mesh = contourMesh(set, contourSurface(set));
  EXPECT_EQ(checks::closedAndManifold(mesh), "");
  EXPECT_EQ(topologyOf(mesh).pieces, 1);
  EXPECT_EQ(topologyOf(mesh).genus, 0);
  double sum = 0;
  int count = 0;
  for (const openvdb::Vec3s& p : mesh.points)
    if (std::abs(p[2]) < 2.5) sum += std::abs(tube(Vec3d(p))), ++count;
  EXPECT_LT(sum / count, 0.1 * 0.5);
}

TEST_F(Contours, OneBodySplitsInTwo) {
  const shapes::Distance trousers = [](const Vec3d& p) {
    const double s = std::clamp((3 - p[2]) / 4, 0.0, 1.0), apart = 1.2 * s * s * (3 - 2 * s);
    return std::min(std::hypot(p[0] - apart, p[1]) - 0.8, std::hypot(p[0] + apart, p[1]) - 0.8);
  };
  std::vector<Plane> planes = stack(13, 0.5);
  for (Plane& plane : planes) plane.first[2] += 1;
  const ContourSet set = cut(trousers, planes, 4, 0.08);
  const Mesh mesh = contourMesh(set, contourSurface(set));
  EXPECT_EQ(checks::closedAndManifold(mesh), "");
  EXPECT_EQ(topologyOf(mesh).pieces, 1);
  EXPECT_EQ(topologyOf(mesh).genus, 0);
}

TEST_F(Contours, NestedContoursAreTheInnerWallOfATube) {
  const shapes::Distance tube = [](const Vec3d& p) { return std::abs(std::hypot(p[0], p[1]) - 0.8) - 0.2; };
  const ContourSet set = cut(tube, stack(9, 0.5), 3, 0.06);
  const ContourSurface surface = contourSurface(set);
  const Mesh mesh = contourMesh(set, surface);
  EXPECT_EQ(checks::closedAndManifold(mesh), "");
  EXPECT_EQ(topologyOf(mesh).pieces, 1);
  EXPECT_EQ(topologyOf(mesh).genus, 1);
  // At most half a gap beyond the last planes.
  for (const openvdb::Vec3s& p : mesh.points) EXPECT_LT(std::abs(p[2]), 2 + 0.25 + surface.voxelSize);
}

TEST_F(Contours, SameForAnyNumberOfThreads) {
  const ContourSet set = cut(shapes::torus(Vec3d(0.0), kRing, kTube), tiltedStack(30), 8, 0.15);
  FloatGrid::Ptr first;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      const FloatGrid::Ptr grid = contourSurface(set).grid;
      if (!first) first = grid;
      EXPECT_TRUE(sameValues(*first, *grid));
    });
}

// Contours that are reported in notes.

std::vector<Vec2d> square(double x, double y, double half) {
  return {{x - half, y - half}, {x + half, y - half}, {x + half, y + half}, {x - half, y + half}};
}

/// The same contours on three planes.
ContourSet prism(const std::vector<std::vector<Vec2d>>& loops) {
  ContourSet set;
  set.name = "prism";
  for (int k = 0; k < 3; ++k) {
    set.planes.push_back(planeAt(Vec3d(0, 0, k), Vec3d(0, 0, 1)));
    set.planes.back().loops = loops;
  }
  return set;
}

double volumeOf(const ContourSet& set, std::string& notes) {
  ContourSurfaceOptions options;
  options.voxelSize = 0.1;
  const ContourSurface surface = contourSurface(set, options);
  for (const Note& note : surface.notes) notes += note.sentence() + "\n";
  return checks::volumeOf(contourMesh(set, surface));
}

TEST_F(Contours, PlaneWithoutTheBodyPartsIt) {
  // The same column above and below; the plane in between is empty, or has something else only.
  for (const bool other : {false, true}) {
    ContourSet set;
    for (int k = 0; k < 9; ++k) {
      set.planes.push_back(planeAt(Vec3d(0, 0, k), Vec3d(0, 0, 1)));
      if (k != 4) set.planes.back().loops = {square(0, 0, 2)};
    }
    if (other) set.planes[4].loops = {square(6, 0, 1)};
    ContourSurfaceOptions options;
    options.voxelSize = 0.2;
    const Mesh mesh = contourMesh(set, contourSurface(set, options));
    EXPECT_EQ(checks::closedAndManifold(mesh), "");
    EXPECT_EQ(topologyOf(mesh).pieces, other ? 3 : 2);
    EXPECT_EQ(topologyOf(mesh).genus, 0);
  }
}

TEST_F(Contours, RepairsAreStated) {
  std::string notes;
  const double plain = volumeOf(prism({square(0, 0, 2)}), notes);
  EXPECT_EQ(notes, "");
  EXPECT_NEAR(volumeOf(prism({square(0, 0, 2), square(0, 0, 2)}), notes), plain, 1e-6);
  EXPECT_NE(notes.find("given twice"), std::string::npos) << notes;
  notes.clear();
  volumeOf(prism({{{-2, -2}, {2, 2}, {2, -2}, {-2, 2}}}), notes);
  EXPECT_NE(notes.find("cross themselves"), std::string::npos) << notes;
  notes.clear();
  const double both = volumeOf(prism({square(0, 0, 2), square(2, 1, 2)}), notes);
  EXPECT_NE(notes.find("overlap: joined"), std::string::npos) << notes;
  EXPECT_GT(both, 1.3 * plain);
  notes.clear();
  volumeOf(prism({square(0, 0, 2), {{0, 0}, {1, 0}}}), notes);
  EXPECT_NE(notes.find("less than three"), std::string::npos) << notes;
}

TEST_F(Contours, MissingPlanesAreStated) {
  ContourSet set = cut(shapes::sphere(Vec3d(0.0), 2), stack(9, 0.4), 3, 0.1);
  ContourSurfaceOptions options;
  options.voxelSize = 0.1;
  EXPECT_TRUE(contourSurface(set, options).notes.empty());
  set.planes.erase(set.planes.begin() + 5);
  const std::vector<std::string> notes = sentencesOf(contourSurface(set, options).notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0],
            "1 gaps between planes bridged (1 planes missing), usual gap 0.4 mm: 0.8 mm from 0 mm to "
            "0.8 mm");
}

Image labelsOf(const std::vector<ContourSet>& sets, const std::vector<int>& labels, SharedVoxel rule) {
  std::vector<ContourSurface> surfaces;
  ContourSurfaceOptions options;
  options.voxelSize = 0.1;
  for (const ContourSet& set : sets) surfaces.push_back(contourSurface(set, options));
  return contourLabels(surfaces, labels, contourLattice(sets, 0.1), rule);
}

double volumeOf(const Image& image, int label) {
  const auto& values = std::get<std::vector<std::uint8_t>>(image.values);
  const Vec3d spacing = image.lattice.spacing();
  return spacing[0] * spacing[1] * spacing[2] * double(std::count(values.begin(), values.end(), label));
}

TEST_F(Contours, InnerOfTwoBallsIsNotSwallowed) {
  const std::vector<Plane> planes = stack(19, 0.2);
  const std::vector<ContourSet> sets{cut(shapes::sphere(Vec3d(0.0), 2), planes, 3, 0.1),
                                     cut(shapes::sphere(Vec3d(0.0), 1), planes, 3, 0.1)};
  const double inner = 4 * M_PI / 3, voxel = 0.1;
  for (const std::vector<int>& labels : {std::vector<int>{1, 2}, std::vector<int>{2, 1}}) {
    const Image image = labelsOf(sets, labels, SharedVoxel::smallest);
    // Half a voxel for either surface.
    EXPECT_NEAR(volumeOf(image, labels[1]), inner, 0.5 * voxel * 4 * M_PI);
    EXPECT_NEAR(volumeOf(image, labels[0]), 7 * inner, 0.5 * voxel * 20 * M_PI);
  }
}

TEST_F(Contours, TouchingBoxesShareAWall) {
  const std::vector<ContourSet> sets{prism({square(-1, 0, 1)}), prism({square(1, 0, 1)})};
  const Image image = labelsOf(sets, {7, 3}, SharedVoxel::deepest);
  const auto& values = std::get<std::vector<std::uint8_t>>(image.values);
  const ImageLattice& on = image.lattice;
  for (int k = 0; k < on.size[2]; ++k)
    for (int j = 0; j < on.size[1]; ++j)
      for (int i = 0; i < on.size[0]; ++i) {
        const Vec3d p = on.toWorld(Vec3d(i, j, k));
        if (std::abs(p[1]) > 0.8 || p[2] < 0 || p[2] > 2 || std::abs(p[0]) < 0.06 || std::abs(p[0]) > 1.8)
          continue;
        EXPECT_EQ(values[on.index(i, j, k)], p[0] < 0 ? 7 : 3) << p;
      }
}

TEST_F(Contours, KeyholeIsAHole) {
  std::string notes;
  const std::vector<Vec2d> outer = square(0, 0, 2);
  const double nested = volumeOf(prism({outer, square(0, 0, 1)}), notes);
  // Out along the bottom, in to the hole's corner, around it, and back along the same line.
  const double keyhole = volumeOf(
      prism({{{-2, -2}, {2, -2}, {2, 2}, {-2, 2}, {-2, -2}, {-1, -1}, {-1, 1}, {1, 1}, {1, -1}, {-1, -1}}}),
      notes);
  EXPECT_EQ(notes, "");
  EXPECT_NEAR(keyhole, nested, 1e-3 * nested);
}

TEST_F(Contours, WhatMakesNoBodyIsRefused) {
  ContourSet one = prism({square(0, 0, 2)});
  one.planes.resize(1);
  EXPECT_THROW(contourSurface(one), GeometryError);
  EXPECT_THROW(contourSurface(ContourSet()), GeometryError);
  EXPECT_THROW(contourSurface(prism({})), GeometryError);
  for (double voxelSize : {-1.0, 1e-6, std::nan("")}) {
    ContourSurfaceOptions options;
    options.voxelSize = voxelSize;
    EXPECT_THROW(contourSurface(prism({square(0, 0, 2)}), options), InputError);
  }
}

// Files.

class ContourFiles : public Contours {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("contours_test." + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string written(const std::string& name, const std::string& bytes) {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  static std::string shared(const char* name) {
    return std::string(SLICEMORPH_SHARED) + "/medical/contours/" + name;
  }
  static std::string bytesOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream all;
    all << file.rdbuf();
    return all.str();
  }
  std::string errorOf(const std::string& path) {
    try {
      readContours(path);
    } catch (const IoError& error) {
      return error.what();
    }
    return "";
  }

 private:
  std::filesystem::path folder_;
};

const char* const kSmallCsl =
    "CSLC\n2 2\n\n1 4 1 0 0 1 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 1 0 1 2 3\n\n"
    "2 4 1 0 0 1 -1\n0 0 1\n4 0 1\n4 4 1\n0 4 1\n4 1 0 1 2 3\n";

TEST_F(ContourFiles, DamagedCslIsRefusedByName) {
  const std::string good = kSmallCsl;
  EXPECT_EQ(errorOf(written("good.csl", good)), "");
  for (size_t n = 0; n < good.size() - 1; ++n) {
    const std::string why = errorOf(written("cut.csl", good.substr(0, n)));
    EXPECT_NE(why.find("cut.csl"), std::string::npos) << n;
  }
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return errorOf(written("bad.csl", text));
  };
  EXPECT_NE(with("0 0 1 0\n", "0 0 0 0\n").find("normal is zero"), std::string::npos);
  EXPECT_NE(with("4 4 0", "4 4 2").find("off its plane"), std::string::npos);
  EXPECT_NE(with("4 1 0 1 2 3", "4 1 0 1 2 7").find("'7'"), std::string::npos);
  EXPECT_NE(with("4 0 0", "4 nan 0").find("finite"), std::string::npos);
  EXPECT_NE(with("2 2\n", "999999999999 2\n").find("planes"), std::string::npos);
  EXPECT_NE(errorOf("/nowhere/at.csl").find("/nowhere/at.csl"), std::string::npos);
}

TEST_F(ContourFiles, CutStructureSetsAreRefusedByName) {
  const std::string path = shared("rtss.dcm");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the shared data are absent";
  const std::string good = bytesOf(path);
  EXPECT_EQ(parseInput(path).contents, Contents::kContours);
  EXPECT_EQ(parseInput(shared("SHA256SUMS")).contents, Contents::kUnknown);
  for (size_t n = 0; n < good.size() - 1; n += n < 2000 ? 61 : good.size() / 40) {
    const std::string why = errorOf(written("cut.dcm", good.substr(0, n)));
    EXPECT_NE(why.find("cut.dcm"), std::string::npos) << n;
  }
}

TEST_F(ContourFiles, StructureSetHasWhatPydicomReads) {
  const std::string path = shared("rtss.dcm");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the shared data are absent";
  const ContourFile file = readContours(path);
  struct Expected {
    const char* name;
    size_t planes, contours, points;
  };
  const std::vector<Expected> expected{{"BODY", 98, 141, 51846},   {"Areola", 0, 0, 0},
                                       {"Borders", 2, 2, 88},      {"Breast", 47, 48, 9062},
                                       {"Heart", 33, 33, 4732},    {"Lt Lung", 80, 165, 19956},
                                       {"Nodes", 4, 4, 64},        {"Scar", 6, 6, 162},
                                       {"Tumor Bed", 18, 18, 616}, {"Tumor Bed Block", 24, 24, 1632}};
  ASSERT_EQ(file.sets.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    size_t contours = 0, points = 0;
    for (const PlaneContours& plane : file.sets[i].planes) {
      contours += plane.loops.size();
      for (const auto& loop : plane.loops) points += loop.size();
    }
    EXPECT_EQ(file.sets[i].name, expected[i].name);
    EXPECT_EQ(file.sets[i].planes.size(), expected[i].planes);
    EXPECT_EQ(contours, expected[i].contours);
    EXPECT_EQ(points, expected[i].points);
  }
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].sentence().find("Areola: has no closed contour"), std::string::npos);
}

TEST_F(ContourFiles, SurfacesPassThroughTheContours) {
  if (!std::filesystem::exists(shared("rtss.dcm"))) GTEST_SKIP() << "the shared data are absent";
  const std::map<std::string, int> pieces{
      {"Heart", 1}, {"Breast", 1}, {"Tumor Bed", 1}, {"Nodes", 1}, {"Scar", 1}};
  for (const ContourSet& set : readContours(shared("rtss.dcm")).sets) {
    if (!pieces.count(set.name)) continue;
    SCOPED_TRACE(set.name);
    const ContourSurface surface = contourSurface(set);
    const Mesh mesh = contourMesh(set, surface);
    EXPECT_EQ(checks::closedAndManifold(mesh), "");
    EXPECT_EQ(topologyOf(mesh).pieces, pieces.at(set.name));
    EXPECT_LE(farthestContourPoint(set, mesh, surface.voxelSize), std::min(0.5, 0.5 * surface.voxelSize));
  }
}

TEST_F(ContourFiles, SurfacesKeepToTheVerdictOfThePlanes) {
  if (!std::filesystem::exists(shared("rtss.dcm")) || !std::filesystem::exists(shared("Vetebrae.csl")))
    GTEST_SKIP() << "the shared data are absent";
  const ContourSet vertebrae = readContours(shared("Vetebrae.csl")).sets.at(0);
  const ContourSurface spine = contourSurface(vertebrae);
  EXPECT_EQ(contradictions(vertebrae, spine), 0);
  EXPECT_LE(farthestContourPoint(vertebrae, contourMesh(vertebrae, spine), spine.voxelSize),
            0.5 * spine.voxelSize);
  for (const ContourSet& set : readContours(shared("rtss.dcm")).sets) {
    if (set.name != "Lt Lung") continue;
    const ContourSurface surface = contourSurface(set);
    EXPECT_EQ(contradictions(set, surface), 0);
    const Mesh mesh = contourMesh(set, surface);
    EXPECT_EQ(checks::closedAndManifold(mesh), "");
    // The slices, extruded by the gap and stacked, have 12 handles: vessels are holes in the contours.
    EXPECT_LE(topologyOf(mesh).genus, 12);
    EXPECT_LE(farthestContourPoint(set, mesh, surface.voxelSize), std::min(0.5, 0.5 * surface.voxelSize));
  }
}

TEST_F(ContourFiles, HorseIsOneBodyWithoutHandles) {
  const std::string path = shared("Horsers.csl");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the shared data are absent";
  const ContourFile file = readContours(path);
  ASSERT_EQ(file.sets.size(), 1u);
  EXPECT_EQ(file.sets[0].planes.size(), 29u);
  const ContourSurface surface = contourSurface(file.sets[0]);
  const Mesh mesh = contourMesh(file.sets[0], surface);
  EXPECT_EQ(checks::closedAndManifold(mesh), "");
  EXPECT_EQ(topologyOf(mesh).pieces, 1);
  EXPECT_EQ(topologyOf(mesh).genus, 0);
  EXPECT_LE(farthestContourPoint(file.sets[0], mesh, surface.voxelSize), 0.5 * surface.voxelSize);
}

}  // namespace
}  // namespace slicemorph
