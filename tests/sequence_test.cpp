// Plans from frame to frame of a sequence: what was decided holds, follows the objects, and makes no jumps.
#include "engine/errors.h"
#include "engine/frame/moments.h"
#include "engine/frame/track.h"
#include "engine/measure/measure.h"
#include "engine/slicemorph.h"
#include "tests/same_values.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <chrono>
#include <random>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFrames = 10;
using shapes::Distance;

Object object(const FloatGrid::Ptr& grid) { return {"shape", grid}; }

Weights at(double t) { return {1 - t, t}; }

/// A first-order distance from any smooth function that is negative inside.
Distance distanceOf(const Distance& f) {
  return [=](const Vec3d& p) {
    constexpr double e = 1e-4;
    const Vec3d g(f(p + Vec3d(e, 0, 0)) - f(p - Vec3d(e, 0, 0)), f(p + Vec3d(0, e, 0)) - f(p - Vec3d(0, e, 0)),
                  f(p + Vec3d(0, 0, e)) - f(p - Vec3d(0, 0, e)));
    return f(p) / std::max(g.length() / (2 * e), 0.3);
  };
}

Distance ellipsoid(const Vec3d& axes) {
  return distanceOf([=](const Vec3d& p) { return ((p / axes).length() - 1) * std::min({axes[0], axes[1], axes[2]}); });
}

/// A ball of radius 0.8 with bumps of a tenth.
Distance bumpy() {
  return distanceOf([](const Vec3d& p) {
    const Vec3d n = p / std::max(p.length(), 1e-6);
    return p.length() - 0.8 - 0.08 * (std::sin(3 * n[0] + 1) + std::sin(4 * n[1] + 2 * n[0]) + std::sin(4 * n[2] - n[1]));
  });
}

/// Merged balls whose radii and places billow with `phase`.
Distance cloud(unsigned seed, double phase) {
  struct Ball {
    Vec3d centre;
    double radius;
  };
  std::vector<Ball> balls;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 14; ++i) {
    Vec3d c(any(random), any(random), any(random));
    c = 0.55 * c / std::max(1.0, c.length());
    const double start = kPi * any(random);
    c += 0.08 * Vec3d(std::sin(phase + start), std::cos(phase + 2 * start), std::sin(phase - start));
    balls.push_back({c * Vec3d(1.2, 1, 0.8), 0.34 * (1 + 0.2 * std::sin(phase + 3 * start))});
  }
  return [=](const Vec3d& p) {
    double sum = 0;
    for (const Ball& b : balls) sum += std::exp(-30 * ((p - b.centre).length() - b.radius));
    return -std::log(sum) / 30;
  };
}

Mat3d aboutZ(double degrees) { return rotationFromVector({0, 0, degrees * kPi / 180}); }

using Sequence = std::vector<FloatGrid::Ptr>;  ///< per frame

template <typename Shape>
Sequence sequence(const Shape& shape, double h = 2.0 / 72) {
  Sequence result;
  for (int i = 0; i < kFrames; ++i) result.push_back(shapes::levelSet(shape(i), shapes::cube({0, 0, 0}, 1.3), h));
  return result;
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Plans {
  std::vector<MorphPlan> frames;
  double first = 0, next = 0;  ///< seconds; of the first, and in the mean of the others
};

Plans plansOf(const Sequence& a, const Sequence& b, bool follow) {
  Plans plans;
  for (size_t i = 0; i < a.size(); ++i) {
    const double start = seconds();
    const std::vector<Object> objects{object(a[i]), object(b[i])};
    if (follow && i > 0) plans.frames.emplace_back(objects, plans.frames.back());
    else plans.frames.emplace_back(objects);
    if (std::getenv("NOTES")) for (auto& n : plans.frames.back().notes()) std::printf("   %zu: %s\n", i, n.c_str());
    (i > 0 ? plans.next : plans.first) += (seconds() - start) / (i > 0 ? double(a.size() - 1) : 1);
  }
  return plans;
}

/// Largest difference from one frame to the next over their mean.
template <typename Time>
double popOf(const std::vector<MorphPlan>& plans, const Time& time) {
  double sum = 0, largest = 0;
  FloatGrid::Ptr before;
  for (size_t i = 0; i < plans.size(); ++i) {
    const FloatGrid::Ptr now = plans[i].frame(at(time(i))).surface;
    if (before) {
      const double d = overlap(*before, *now).symmetricDifference;
      sum += d, largest = std::max(largest, d);
      if (std::getenv("NOTES")) std::printf("   jump %.5f\n", d);
    }
    before = now;
  }
  return largest * double(plans.size() - 1) / sum;
}

void expectNoJumps(const Sequence& a, const Sequence& b) {
  const auto playing = [](size_t i) { return double(i) / (kFrames - 1); };
  const auto held = [](size_t) { return 0.5; };
  const Plans followed = plansOf(a, b, true), fresh = plansOf(a, b, false);
  const double playingPop = popOf(followed.frames, playing), heldPop = popOf(followed.frames, held);
  std::printf("largest jump over the mean: %.2f playing, %.2f held half way; planned anew each frame %.2f and %.2f\n",
              playingPop, heldPop, popOf(fresh.frames, playing), popOf(fresh.frames, held));
  std::printf("seconds a plan: %.2f following, %.2f anew\n", followed.next, fresh.next);
  EXPECT_LE(playingPop, 1.5);
  EXPECT_LE(heldPop, 1.5);
}

TEST(Sequence, AxesThatCrossAndATurningBlob) {
  expectNoJumps(sequence([](int i) { return ellipsoid({1 - 0.2 * i / 9.0, 0.8 + 0.2 * i / 9.0, 0.65}); }),
                sequence([](int i) { return shapes::placed(bumpy(), aboutZ(10 * i), {0, 0, 0}); }));
}

TEST(Sequence, BillowingClouds) {
  expectNoJumps(sequence([](int i) { return cloud(1, 0.3 * i); }), sequence([](int i) { return cloud(2, 0.3 * i); }));
}

}  // namespace
}  // namespace slicemorph
