/// Times of voxelising a scan of two million triangles at 256 voxels, as ratios against OpenVDB alone in the same run: of
/// the clean mesh, and of the same with every thousandth face missing and every ten-thousandth flipped, whose inside
/// winding numbers tell. Memory: their tree against the mesh. Usage: slicemorph_mesh_benchmark

#include "engine/volume/solid_of_mesh.h"
#include "engine/volume/voxelise.h"
#include "engine/volume/winding_number.h"
#include "engine/volume/winding_solid.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <random>

using namespace slicemorph;

namespace {

constexpr unsigned kAround = 1000;
constexpr double kVoxelSize = 2.3 / 256;

/// A lumpy ball with the noise of a scanner.
Mesh scan() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-3e-4, 3e-4);
  Mesh mesh;
  mesh.points.emplace_back(0, 0, 1);
  for (unsigned r = 1; r < kAround; ++r)
    for (unsigned a = 0; a < kAround; ++a) {
      const double theta = M_PI * r / kAround, phi = 2 * M_PI * a / kAround;
      const double radius =
          1 + 0.1 * std::sin(7 * phi) * std::sin(5 * theta) * std::sin(theta) + noise(random);
      mesh.points.emplace_back(float(radius * std::sin(theta) * std::cos(phi)),
                               float(radius * std::sin(theta) * std::sin(phi)),
                               float(radius * std::cos(theta)));
    }
  mesh.points.emplace_back(0, 0, -1);
  const auto point = [](unsigned r, unsigned a) {
    return r == 0 ? 0u : r == kAround ? (kAround - 1) * kAround + 1 : 1 + (r - 1) * kAround + a % kAround;
  };
  for (unsigned r = 0; r < kAround; ++r)
    for (unsigned a = 0; a < kAround; ++a) {
      if (r > 0) mesh.triangles.emplace_back(point(r, a), point(r + 1, a), point(r, a + 1));
      if (r + 1 < kAround) mesh.triangles.emplace_back(point(r, a + 1), point(r + 1, a), point(r + 1, a + 1));
    }
  return mesh;
}

Mesh damaged(const Mesh& mesh) {
  Mesh result{mesh.points, {}};
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    openvdb::Vec3I corners = mesh.triangles[t];
    if (t % 10007 == 0) std::swap(corners[0], corners[1]);
    if (t % 1009 != 0) result.triangles.push_back(corners);
  }
  return result;
}

PolygonMesh asPolygons(const Mesh& mesh) {
  PolygonMesh polygons;
  polygons.points = mesh.points;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) polygons.corners.push_back(t[k]);
    polygons.faceStarts.push_back(std::uint32_t(polygons.corners.size()));
  }
  return polygons;
}

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Resident memory, MB.
double memory() {
  std::ifstream status("/proc/self/statm");
  double all = 0, resident = 0;
  status >> all >> resident;
  return resident * 4096 / 1e6;
}

}  // namespace

int main() {
  openvdb::initialize();
  const Mesh clean = scan(), open = damaged(clean);
  const double megabytes = double(clean.points.size() * 12 + clean.triangles.size() * 12) / 1e6;
  // The same algorithm without any of ours around it.
  const double plain = seconds([&] { voxelise(clean, kVoxelSize); });
  std::printf("%zu triangles, mesh %.0f MB; OpenVDB alone %.2f s\n", clean.triangles.size(), megabytes,
              plain);
  SolidOptions options;
  options.voxelSize = kVoxelSize;
  SolidMesh cleanReady, openReady;
  const PolygonMesh cleanInput = asPolygons(clean), openInput = asPolygons(open);
  const double cleanRepair = seconds([&] { cleanReady = prepareSolid(cleanInput); });
  const double cleanTime = seconds([&] { solidOf(std::move(cleanReady), options); });
  std::printf("clean: %.2f times (repair %.2f s)\n", cleanTime / plain, cleanRepair);
  const double before = memory();
  double tree = 0;
  const double windingTime = seconds([&] {
    const WindingNumber winding(open);
    tree = memory() - before;
    windingLevelSet(open, winding, kVoxelSize);
  });
  std::printf("by winding numbers: %.2f times; their tree takes %.0f MB, %.2f of the mesh\n",
              windingTime / plain, tree, tree / megabytes);
  const double openTime = seconds([&] { solidOf(prepareSolid(openInput), options); });
  std::printf("the damaged scan with its repair: %.2f times\n", openTime / plain);
}
