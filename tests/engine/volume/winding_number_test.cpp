#include "engine/volume/winding_number.h"

#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;

/// The sum of the solid angles of all triangles [VS83], in full spheres.
double summed(const Mesh& mesh, const Vec3d& p) {
  double sum = 0;
  for (const Vec3I& t : mesh.triangles) {
    const Vec3d a = Vec3d(mesh.points[t[0]]) - p, b = Vec3d(mesh.points[t[1]]) - p,
                c = Vec3d(mesh.points[t[2]]) - p;
    const double la = a.length(), lb = b.length(), lc = c.length();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * M_PI);
}

Mesh randomSoup(unsigned seed, int count, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> at(-1, 1);
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const Vec3d centre(at(random), at(random), at(random));
    for (int k = 0; k < 3; ++k)
      mesh.points.emplace_back(centre + size * Vec3d(at(random), at(random), at(random)));
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return mesh;
}

/// The part of a unit sphere above a height, wound outwards: rings from the pole down.
Mesh cap(double lowest, unsigned rings) {
  Mesh mesh;
  const unsigned around = 4 * rings;
  for (unsigned r = 0; r <= rings; ++r) {
    const double theta = std::acos(lowest) * r / rings;
    for (unsigned a = 0; a < around; ++a) {
      const double phi = 2 * M_PI * a / around;
      mesh.points.emplace_back(float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)),
                               float(std::cos(theta)));
    }
  }
  for (unsigned r = 0; r < rings; ++r)
    for (unsigned a = 0; a < around; ++a) {
      const unsigned b = (a + 1) % around, row = r * around;
      if (r > 0) mesh.triangles.emplace_back(row + a, row + around + a, row + b);
      if (r + 1 < rings || lowest > -1)
        mesh.triangles.emplace_back(row + b, row + around + a, row + around + b);
    }
  return mesh;
}

TEST(WindingNumber, IsTheSumOfAllTriangles) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-1.5, 1.5);
  for (const auto& [count, size] :
       std::vector<std::pair<int, double>>{{1, 1}, {7, 1}, {100, 0.5}, {2000, 0.2}}) {
    const Mesh mesh = randomSoup(unsigned(count), count, size);
    const WindingNumber winding(mesh);
    double squares = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3d p(at(random), at(random), at(random));
      const double difference = winding.at(p) - summed(mesh, p);
      // What the header promises; a random soup is the worst case, for its triangles do not cancel.
      EXPECT_LT(std::abs(difference), 0.01) << count << " " << p;
      squares += difference * difference;
    }
    // A series broken off too early would be ten times as far off [BDSLJ18].
    EXPECT_LT(std::sqrt(squares / 500), 1e-3) << count;
  }
}

TEST(WindingNumber, IsOneInsideAClosedSurfaceAndNoneOutside) {
  const Mesh ball = cap(-1, 40);
  const WindingNumber winding(ball);
  std::mt19937 random(2);
  std::normal_distribution<double> at;
  for (int i = 0; i < 300; ++i) {
    const Vec3d direction = Vec3d(at(random), at(random), at(random)).unit();
    EXPECT_NEAR(winding.at(direction * 0.98), 1, 0.01);
    EXPECT_NEAR(winding.at(direction * 1.01), 0, 0.01);
    EXPECT_NEAR(winding.at(direction * 30), 0, 1e-5);
  }
}

/// From its centre a cap above the height z fills (1 - z) / 2 of the view.
TEST(WindingNumber, FallsSmoothlyAcrossHoles) {
  for (double z : {0.9, 0.5, 0.0, -0.7}) {
    const Mesh open = cap(z, 60);
    EXPECT_NEAR(WindingNumber(open).at(Vec3d(0.0)), (1 - z) / 2, 2e-3) << z;
  }
}

TEST(WindingNumber, CountsHowOftenAPointIsWrappedAndWhichWay) {
  Mesh twice = cap(-1, 20);
  const std::vector<Vec3I> once = twice.triangles;
  twice.triangles.insert(twice.triangles.end(), once.begin(), once.end());
  EXPECT_NEAR(WindingNumber(twice).at(Vec3d(0.3, 0.2, 0.1)), 2, 0.01);
  for (Vec3I& t : twice.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(WindingNumber(twice).at(Vec3d(0.3, 0.2, 0.1)), -2, 0.01);
  std::vector<std::uint32_t> half;
  for (std::uint32_t t = 0; t < once.size(); ++t) half.push_back(t);
  EXPECT_NEAR(WindingNumber(twice, half).at(Vec3d(0.3, 0.2, 0.1)), -1, 0.01);
  EXPECT_EQ(WindingNumber(Mesh()).at(Vec3d(1.0)), 0);
}

TEST(WindingNumber, RaysHitTheFirstTriangle) {
  const Mesh mesh = randomSoup(3, 300, 0.1);
  const WindingNumber winding(mesh);
  std::mt19937 random(4);
  std::normal_distribution<double> at;
  size_t hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3d origin(at(random), at(random), at(random));
    const Vec3d direction = Vec3d(at(random), at(random), at(random)).unit();
    std::optional<std::uint32_t> first;
    double nearest = 1e300;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3d a(mesh.points[3 * t]), ab = Vec3d(mesh.points[3 * t + 1]) - a,
                                         ac = Vec3d(mesh.points[3 * t + 2]) - a;
      // By Cramer's rule: origin + s direction = a + u ab + v ac.
      const double det = -direction.dot(ab.cross(ac));
      const Vec3d from = origin - a;
      const double s = from.dot(ab.cross(ac)) / det, u = -direction.dot(from.cross(ac)) / det,
                   v = -direction.dot(ab.cross(from)) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && s > 0 && s < nearest) nearest = s, first = t;
    }
    EXPECT_EQ(winding.firstHit(origin, direction), first) << i;
    hits += first.has_value();
  }
  EXPECT_GT(hits, 20u);
}

TEST(WindingNumber, SameBytesForAnyThreadCount) {
  const Mesh mesh = randomSoup(9, 40000, 0.05);
  std::vector<std::vector<double>> values;
  for (size_t threads : {1, 2, 4})
    withThreads(threads, [&] {
      const WindingNumber winding(mesh);
      values.emplace_back();
      for (int i = 0; i < 100; ++i) values.back().push_back(winding.at(Vec3d(0.013 * i - 0.6, 0.2, 0.1)));
    });
  EXPECT_EQ(values[0], values[1]);
  EXPECT_EQ(values[0], values[2]);
}

}  // namespace
}  // namespace slicemorph
