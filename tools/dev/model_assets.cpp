// Models the bundled shapes (assets/*.ply) as closed-form distance fields with smooth unions, meshes them and
// moves every vertex onto the exact surface. Usage: model_assets FOLDER. Distance functions after Inigo
// Quilez, https://iquilezles.org/articles/distfunctions (formulas); the shapes are the project's own. Up is
// y, front is x.

#include "engine/numerics/disjoint_sets.h"
#include "engine/numerics/edge_table.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/io/mesh_writer.h"

#include <openvdb/tools/Dense.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <string>
#include <tuple>

using namespace slicemorph;

namespace {

constexpr double kPi = 3.14159265358979323846;

using Field = std::function<double(const Vec3d&)>;

struct Shape {
  std::string name;
  Field field;         ///< negative inside; close to a distance near the surface
  openvdb::BBoxd box;  ///< holds the whole surface
  int genus = 0;
};

double smoothUnion(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k / 4;
}

double smoothCut(double body, double cutter, double k) { return -smoothUnion(-body, cutter, k); }

double sphere(const Vec3d& p, const Vec3d& centre, double radius) { return (p - centre).length() - radius; }

double ellipsoid(const Vec3d& p, const Vec3d& centre, const Vec3d& radii) {
  const Vec3d a = (p - centre) / radii, b = a / radii;
  const double k0 = a.length(), k1 = b.length();
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({radii.x(), radii.y(), radii.z()});
}

/// The hull of two spheres.
double limb(const Vec3d& p, const Vec3d& a, double ra, const Vec3d& b, double rb) {
  const Vec3d ba = b - a, pa = p - a;
  const double l2 = ba.dot(ba), rr = ra - rb, a2 = l2 - rr * rr, il2 = 1 / l2;
  const double y = pa.dot(ba), z = y - l2;
  const double x2 = (pa * l2 - ba * y).lengthSqr(), y2 = y * y * l2, z2 = z * z * l2;
  const double k = std::copysign(1.0, rr) * rr * rr * x2;
  if (std::copysign(1.0, z) * a2 * z2 > k) return std::sqrt(x2 + z2) * il2 - rb;
  if (std::copysign(1.0, y) * a2 * y2 < k) return std::sqrt(x2 + y2) * il2 - ra;
  return (std::sqrt(x2 * a2 * il2) + y * rr) * il2 - ra;
}

struct Joint {
  Vec3d at;
  double radius;
};

/// Limbs from joint to joint, by a plain union: a smooth one would swell where they overlap.
double chain(const Vec3d& p, const std::vector<Joint>& joints) {
  double d = limb(p, joints[0].at, joints[0].radius, joints[1].at, joints[1].radius);
  for (size_t n = 2; n < joints.size(); ++n) {
    d = std::min(d, limb(p, joints[n - 1].at, joints[n - 1].radius, joints[n].at, joints[n].radius));
  }
  return d;
}

/// Joints along a Catmull-Rom curve through the given ones.
std::vector<Joint> curve(const std::vector<Joint>& through) {
  constexpr int steps = 8;
  std::vector<Joint> joints;
  const int last = int(through.size()) - 1;
  for (int n = 0; n < last; ++n) {
    const Joint &a = through[std::max(n - 1, 0)], &b = through[n], &c = through[n + 1],
                &d = through[std::min(n + 2, last)];
    for (int s = 0; s < steps + (n == last - 1); ++s) {
      const double t = double(s) / steps, t2 = t * t, t3 = t2 * t;
      const auto blend = [&](const auto& e, const auto& f, const auto& g, const auto& h) {
        return 0.5 * ((2.0 * f) + (g - e) * t + (2.0 * e - 5.0 * f + 4.0 * g - h) * t2 +
                      (3.0 * f - e - 3.0 * g + h) * t3);
      };
      joints.push_back({blend(a.at, b.at, c.at, d.at), blend(a.radius, b.radius, c.radius, d.radius)});
    }
  }
  return joints;
}

double smoothStep(double lo, double hi, double x) {
  const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double foot(const Vec3d& p, const Vec3d& ankle) {
  double d = ellipsoid(p, ankle + Vec3d(0.07, -0.055, 0), {0.135, 0.068, 0.1});
  for (const double side : {-1.0, 0.0, 1.0}) {
    const Vec3d toe = ankle + Vec3d(0.185 - 0.025 * std::abs(side), -0.075, 0.062 * side);
    d = smoothUnion(d, limb(p, toe - Vec3d(0.05, -0.01, 0), 0.042, toe, 0.046), 0.022);
  }
  return d;
}

double creatureHead(const Vec3d& p, const Vec3d& mirrored) {
  double d = ellipsoid(p, {0.98, 1.60, 0}, {0.225, 0.195, 0.19});
  d = smoothUnion(d, limb(p, {1.06, 1.56, 0}, 0.135, {1.335, 1.47, 0}, 0.075), 0.12);
  d = smoothUnion(d, limb(mirrored, {0.99, 1.53, 0.09}, 0.10, {1.1, 1.5, 0.07}, 0.085), 0.08);     // cheeks
  d = smoothUnion(d, ellipsoid(p, {1.405, 1.5, 0}, {0.042, 0.034, 0.05}), 0.025);                  // nose
  d = smoothUnion(d, limb(p, {1.08, 1.43, 0}, 0.07, {1.29, 1.395, 0}, 0.042), 0.05);               // jaw
  d = smoothCut(d, limb(mirrored, {1.16, 1.44, 0.13}, 0.014, {1.335, 1.425, 0.055}, 0.01), 0.02);  // mouth
  d = smoothUnion(d, limb(mirrored, {1.07, 1.70, 0.11}, 0.05, {1.16, 1.675, 0.075}, 0.03), 0.05);  // brow
  d = smoothCut(d, sphere(mirrored, {1.157, 1.633, 0.135}, 0.036), 0.025);       // eye socket
  return smoothUnion(d, sphere(mirrored, {1.130, 1.632, 0.118}, 0.042), 0.006);  // eye
}

/// A leaf-shaped ear, hollow in front.
double ear(const Vec3d& mirrored) {
  static const std::vector<Joint> joints =
      curve({{{0.90, 1.74, 0.10}, 0.075}, {{0.83, 1.91, 0.165}, 0.088}, {{0.73, 2.13, 0.215}, 0.022}});
  const double outer = chain(mirrored, joints);
  const double inner = limb(mirrored, {0.955, 1.86, 0.21}, 0.065, {0.83, 2.08, 0.245}, 0.012);
  return smoothCut(outer, inner, 0.035);
}

double creatureBody(const Vec3d& p, const Vec3d& mirrored) {
  double d = ellipsoid(p, {0.32, 1.00, 0}, {0.42, 0.345, 0.285});
  d = smoothUnion(d, ellipsoid(p, {-0.12, 1.0, 0}, {0.42, 0.26, 0.225}), 0.16);
  d = smoothUnion(d, ellipsoid(p, {-0.45, 1.0, 0}, {0.31, 0.285, 0.255}), 0.16);
  static const std::vector<Joint> neck =
      curve({{{0.42, 1.12, 0}, 0.26}, {{0.66, 1.30, 0}, 0.185}, {{0.86, 1.56, 0}, 0.14}});
  d = smoothUnion(d, chain(p, neck), 0.12);
  return smoothUnion(d, limb(mirrored, {0.40, 1.04, 0.17}, 0.17, {0.46, 0.80, 0.2}, 0.125),
                     0.08);  // shoulder
}

double creature(const Vec3d& p) {
  const Vec3d mirrored(p.x(), p.y(), std::abs(p.z()));
  static const std::vector<Joint> foreLeg = curve({{{0.44, 0.90, 0.20}, 0.15},
                                                   {{0.38, 0.56, 0.225}, 0.09},
                                                   {{0.43, 0.32, 0.23}, 0.068},
                                                   {{0.42, 0.115, 0.23}, 0.066}});
  static const std::vector<Joint> hindLeg = curve({{{-0.47, 0.98, 0.17}, 0.21},
                                                   {{-0.33, 0.60, 0.225}, 0.125},
                                                   {{-0.57, 0.34, 0.225}, 0.066},
                                                   {{-0.51, 0.115, 0.225}, 0.066}});
  static const std::vector<Joint> tail = curve({{{-0.62, 1.08, 0}, 0.12},
                                                {{-0.93, 1.07, 0.02}, 0.085},
                                                {{-1.22, 1.22, 0.07}, 0.10},
                                                {{-1.37, 1.52, 0.10}, 0.125},
                                                {{-1.30, 1.80, 0.05}, 0.075},
                                                {{-1.16, 1.95, 0.0}, 0.018}});
  double d = creatureBody(p, mirrored);
  d = smoothUnion(d, creatureHead(p, mirrored), 0.07);
  d = smoothUnion(d, ear(mirrored), 0.045);
  d = smoothUnion(d, smoothUnion(chain(mirrored, foreLeg), foot(mirrored, {0.42, 0.125, 0.23}), 0.06), 0.07);
  d = smoothUnion(d, smoothUnion(chain(mirrored, hindLeg), foot(mirrored, {-0.51, 0.125, 0.225}), 0.06),
                  0.09);
  d = smoothUnion(d, chain(p, tail), 0.08);
  for (int n = 0; n < 6; ++n) {  // a mane of small plates down the neck
    const double t = n / 5.0, size = 0.085 - 0.04 * std::abs(t - 0.35);
    const Vec3d at(0.78 - 0.60 * t, 1.71 - 0.37 * t - 0.10 * std::sin(kPi * t), 0);
    d = smoothUnion(d, limb(p, at - Vec3d(0.02, 0.07, 0), size * 0.62, at + Vec3d(-0.08, size, 0), 0.014),
                    0.03);
  }
  return d;
}

/// A rope of lobes twisted round a ring, swelling to a head in front with a bezel around a stone.
double ring(const Vec3d& p) {
  const double around = std::atan2(p.y(), p.x()), flat = std::hypot(p.x(), p.y());
  const double out = flat - 1.0, tube = std::hypot(out, p.z()), lobe = std::atan2(p.z(), out);
  const double fromHead = std::abs(std::remainder(around - kPi / 2, 2 * kPi));
  const double thickness =
      0.165 + 0.075 * (1 - smoothStep(0.2, 1.35, fromHead)) + 0.018 * std::cos(6 * around);
  const double rope = 0.19 * smoothStep(0.30, 0.75, fromHead);
  double d = (tube - thickness * (1 + rope * std::cos(3 * lobe - 7 * around))) * 0.72;
  for (const double side : {-1.0, 1.0}) {  // beads where the rope begins
    const double at = kPi / 2 + side * 0.52;
    const Vec3d centre(std::cos(at), std::sin(at), 0), along(-std::sin(at), std::cos(at), 0);
    const Vec3d local = p - centre;
    const double l = local.dot(along), r = std::sqrt(std::max(0.0, local.lengthSqr() - l * l));
    d = smoothUnion(d, std::hypot(r - 0.225, l) - 0.05, 0.07);
  }
  d = smoothUnion(d, ellipsoid(p, {0, 1.22, 0}, {0.29, 0.13, 0.29}), 0.1);
  const Vec3d fromStone = p - Vec3d(0, 1.30, 0);
  const double bezel = std::hypot(std::hypot(fromStone.x(), fromStone.z()) - 0.25, fromStone.y()) - 0.042;
  d = smoothUnion(d, bezel, 0.045);
  return smoothUnion(d, ellipsoid(p, {0, 1.32, 0}, {0.195, 0.135, 0.195}), 0.045);
}

/// Points of a smooth curve: a radius over a height.
using Profile = std::vector<std::pair<double, double>>;

/// Cubic Hermite with central slopes; constant beyond its ends.
double valueAt(const Profile& profile, double x) {
  size_t n = 1;
  while (n + 1 < profile.size() && profile[n].first < x) ++n;
  const auto slope = [&](size_t i) {
    const auto &a = profile[i > 0 ? i - 1 : 0], &b = profile[std::min(i + 1, profile.size() - 1)];
    return (b.second - a.second) / (b.first - a.first);
  };
  const auto &a = profile[n - 1], &b = profile[n];
  const double h = b.first - a.first, t = std::clamp((x - a.first) / h, 0.0, 1.0), t2 = t * t, t3 = t2 * t;
  return a.second * (2 * t3 - 3 * t2 + 1) + b.second * (3 * t2 - 2 * t3) +
         h * (slope(n - 1) * (t3 - 2 * t2 + t) + slope(n) * (t3 - t2));
}

/// Factor from a horizontal difference to a distance from the profile: 1 / sqrt(1 + slope^2).
double steepness(const Profile& profile, double x) {
  const double slope = (valueAt(profile, x + 1e-3) - valueAt(profile, x - 1e-3)) / 2e-3;
  return 1 / std::sqrt(1 + slope * slope);
}

/// Leaf-shaped blade with a fuller, drawn towards a point at y = 2.
double bladeOnly(const Vec3d& p) {
  constexpr double kRound = 0.017;  // of the edges: they must survive being voxelised
  static const Profile width = {{-0.1, 0.165}, {0.1, 0.150},  {0.6, 0.128}, {1.15, 0.185},
                                {1.45, 0.180}, {1.72, 0.112}, {1.9, 0.045}, {1.99, 0.006}};
  const double y = std::clamp(p.y(), -0.1, 1.99), wide = valueAt(width, y),
               thick = std::min(0.05 - 0.012 * y, wide);
  const double across = std::abs(p.x()), deep = std::abs(p.z());
  const double lens =
      (across / wide + deep / thick - 1) / std::hypot(1 / wide, 1 / thick) * steepness(width, y);
  const double d = smoothCut(
      lens - kRound, limb({p.x(), p.y(), deep}, {0, -0.1, 0.098}, 0.058, {0, 1.3, 0.105}, 0.03), 0.03);
  return -smoothUnion(-d, -std::max(p.y() - 2.0, -0.1 - p.y()), 0.02);
}

double blade(const Vec3d& p) {
  const Vec3d mirrored(std::abs(p.x()), p.y(), p.z());
  static const std::vector<Joint> guard = curve({{{0, -0.07, 0}, 0.092},
                                                 {{0.20, -0.055, 0}, 0.068},
                                                 {{0.40, 0.03, 0}, 0.052},
                                                 {{0.50, 0.145, 0}, 0.04}});
  double d = bladeOnly(p);
  d = smoothUnion(d, chain(mirrored, guard), 0.05);
  d = smoothUnion(d, sphere(mirrored, {0.515, 0.165, 0}, 0.072), 0.03);
  d = smoothUnion(d, ellipsoid(p, {0, -0.05, 0}, {0.15, 0.11, 0.105}), 0.05);
  const double turn = std::atan2(p.z(), p.x());
  const double swell = 0.068 + 0.014 * std::sin(kPi * std::clamp((-0.12 - p.y()) / 0.58, 0.0, 1.0));
  const double wrap = 0.009 * std::cos(2 * turn + 42 * p.y());
  const double grip =
      std::max((std::hypot(p.x(), p.z() * 1.12) - swell - wrap) * 0.85, std::abs(p.y() + 0.41) - 0.33);
  d = smoothUnion(d, grip, 0.03);
  d = smoothUnion(d, std::hypot(std::hypot(p.x(), p.z()) - 0.075, p.y() + 0.71) - 0.035, 0.03);
  d = smoothUnion(d, ellipsoid(p, {0, -0.85, 0}, {0.15, 0.135, 0.105}), 0.03);
  return smoothUnion(d, ellipsoid(p, {0, -0.995, 0}, {0.055, 0.04, 0.05}), 0.02);
}

/// An amphora: fluted, with two handles; hollow down to the shoulder only, which leaves more triangles for
/// the outside.
double amphora(const Vec3d& p) {
  static const Profile profile = {{-1.0, 0.30}, {-0.9, 0.22}, {-0.75, 0.26}, {-0.3, 0.60}, {0.1, 0.68},
                                  {0.42, 0.52}, {0.65, 0.26}, {0.9, 0.225},  {1.1, 0.33}};
  const double r = std::hypot(p.x(), p.z()), y = std::clamp(p.y(), -1.0, 1.1), radius = valueAt(profile, y);
  const double scale = steepness(profile, y);
  const double belly = smoothStep(-0.85, -0.45, y) * (1 - smoothStep(0.12, 0.38, y));
  const double flutes = 0.02 * belly * std::cos(16 * std::atan2(p.z(), p.x()) + 5 * y);
  double d = std::max((r - radius - flutes) * scale, std::abs(p.y() - 0.05) - 1.05);
  for (const auto& [height, at, thick] :
       {std::tuple{1.09, 0.345, 0.05}, {0.66, 0.262, 0.03}, {-0.985, 0.30, 0.05}, {0.40, 0.53, 0.03}}) {
    d = smoothUnion(d, std::hypot(r - at, p.y() - height) - thick, 0.07);
  }
  static const std::vector<Joint> handle = curve({{{0.22, 0.92, 0}, 0.05},
                                                  {{0.46, 0.99, 0}, 0.052},
                                                  {{0.70, 0.86, 0}, 0.055},
                                                  {{0.72, 0.55, 0}, 0.052},
                                                  {{0.52, 0.25, 0}, 0.065}});
  d = smoothUnion(d, chain({std::abs(p.x()), p.y(), p.z()}, handle), 0.08);
  const double hollow = std::max((r - radius + 0.085) * scale, 0.3 - p.y());
  return smoothCut(d, hollow, 0.03);
}

/// Samples the field on every grid point of the box; values far from the surface are clamped.
FloatGrid::Ptr sampleField(const Shape& shape, double spacing) {
  const auto transform = openvdb::math::Transform::createLinearTransform(spacing);
  const openvdb::CoordBBox box(openvdb::Coord::floor(shape.box.min() / spacing) - openvdb::Coord(2),
                               openvdb::Coord::ceil(shape.box.max() / spacing) + openvdb::Coord(2));
  openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box);
  const float limit = float(kHalfWidth * spacing);
  tbb::parallel_for(box.min().z(), box.max().z() + 1, [&](int z) {
    for (int y = box.min().y(); y <= box.max().y(); ++y) {
      for (int x = box.min().x(); x <= box.max().x(); ++x) {
        const double d = shape.field(transform->indexToWorld(openvdb::Coord(x, y, z)));
        dense.setValue(openvdb::Coord(x, y, z), std::clamp(float(d), -limit, limit));
      }
    }
  });
  FloatGrid::Ptr grid = FloatGrid::create(limit);
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::tools::copyFromDense(dense, *grid, 0.0f);
  return grid;
}

/// Newton steps along the gradient; a vertex never moves farther than `reach`.
void pullOntoSurface(Mesh& mesh, const Field& field, double reach) {
  tbb::parallel_for(size_t(0), mesh.points.size(), [&](size_t n) {
    const Vec3d start(mesh.points[n]);
    Vec3d p = start;
    const double h = 1e-4;
    for (int step = 0; step < 6; ++step) {
      Vec3d gradient;
      for (int a = 0; a < 3; ++a) {
        Vec3d e(0.0);
        e[a] = h;
        gradient[a] = (field(p + e) - field(p - e)) / (2 * h);
      }
      if (gradient.lengthSqr() < 0.01) break;
      p -= gradient * (field(p) / gradient.lengthSqr());
    }
    const Vec3d moved = p - start;
    mesh.points[n] = openvdb::Vec3s(moved.length() <= reach ? p : start);
  });
}

/// Evens out the triangles: every vertex half way to its neighbours' middle, then back onto the surface.
void relax(Mesh& mesh, const Shape& shape, double spacing) {
  for (int round = 0; round < 6; ++round) {
    std::vector<Vec3d> sum(mesh.points.size(), Vec3d(0.0));
    std::vector<int> count(mesh.points.size());
    for (const auto& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        sum[t[k]] += Vec3d(mesh.points[t[(k + 1) % 3]]) + Vec3d(mesh.points[t[(k + 2) % 3]]);
        count[t[k]] += 2;
      }
    }
    for (size_t n = 0; n < mesh.points.size(); ++n) {
      mesh.points[n] = openvdb::Vec3s((Vec3d(mesh.points[n]) + sum[n] / double(count[n])) / 2.0);
    }
    pullOntoSurface(mesh, shape.field, spacing);
  }
}

double areaOf(const Mesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    area +=
        0.5 * (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).length();
  }
  return area;
}

struct Topology {
  int pieces = 0;
  int genus = 0;
  bool closed = true;
};

Topology topologyOf(const Mesh& mesh) {
  const EdgeTable edges(mesh.triangles);
  DisjointSets sets(mesh.points.size());
  Topology topology;
  for (size_t e = 0; e < edges.count(); ++e) {
    int balance = 0;  // sum of +1 and -1 by the edge's direction in each face: 0 where the mesh is closed
    for (size_t i = 0; i < edges.faces(e); ++i) balance += edges.half(e, i).forward ? 1 : -1;
    topology.closed = topology.closed && balance == 0;
    sets.join(edges.half(e, 0).low, edges.half(e, 0).high);
  }
  for (DisjointSets::Index v = 0; v < mesh.points.size(); ++v) topology.pieces += sets.find(v) == v;
  const long euler = long(mesh.points.size()) - long(edges.count()) + long(mesh.triangles.size());
  topology.genus = int(topology.pieces - euler / 2);
  return topology;
}

/// A mesh of about that many evenly spread vertices: the mesher makes about 1.2 per squared voxel side.
Mesh meshOf(const Shape& shape, double vertices) {
  const double longest = shape.box.extents()[shape.box.maxExtent()];
  const double area = areaOf(surfaceOf(*sampleField(shape, longest / 100)));
  const double spacing = std::sqrt(1.2 * area / vertices);
  Mesh mesh = surfaceOf(*sampleField(shape, spacing));
  pullOntoSurface(mesh, shape.field, spacing);
  relax(mesh, shape, spacing);
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: model_assets FOLDER\n";
    return 2;
  }
  openvdb::initialize();
  const Shape shapes[] = {
      {"creature", creature, {{-1.6, -0.05, -0.5}, {1.55, 2.2, 0.5}}, 0},
      {"ring", ring, {{-1.4, -1.4, -0.45}, {1.4, 1.6, 0.45}}, 1},
      {"blade", blade, {{-0.65, -1.1, -0.2}, {0.65, 2.05, 0.2}}, 0},
      {"amphora", amphora, {{-0.9, -1.15, -0.85}, {0.9, 1.25, 0.85}}, 2},
  };
  bool fine = true;
  for (const Shape& shape : shapes) {
    const Mesh mesh = meshOf(shape, 12000);
    const Topology topology = topologyOf(mesh);
    writeMesh(std::string(argv[1]) + "/" + shape.name + ".ply", mesh);
    std::cout << shape.name << ": " << mesh.points.size() << " vertices, " << mesh.triangles.size()
              << " triangles, " << topology.pieces << " piece(s), genus " << topology.genus
              << (topology.closed ? "" : ", NOT CLOSED") << '\n';
    fine = fine && topology.closed && topology.pieces == 1 && topology.genus == shape.genus;
  }
  if (!fine) std::cerr << "a shape is not what it should be\n";
  return fine ? 0 : 1;
}
