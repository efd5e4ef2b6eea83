#include "engine/frame/settle_turns.h"

#include "engine/frame/climb_rotation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Turns that differ by less than this angle, radians, are settled once.
constexpr double kSameStart = 0.6;
/// Turns to settle with few samples and with many, up to this distortion against the least one. Of a running horse and a
/// toy cow the right turn was among the first two of few samples, by 2 % before the next; with many it was the first, by
/// 3 %, where chance made 1 %.
constexpr size_t kMostWithFew = 12, kMostWithMany = 4;
constexpr double kWorthFew = 2, kWorthMany = 1.15;
/// First and last steps of the climbs, radians: from where overlap is best, and from where few samples fit best.
constexpr double kFar = 0.3, kNear = 0.1, kFine = 0.03;

std::vector<SettledTurn> inOrder(std::vector<SettledTurn> turns) {
  std::stable_sort(turns.begin(), turns.end(),
                   [](const SettledTurn& x, const SettledTurn& y) { return x.distortion < y.distortion; });
  return turns;
}

/// Of turns in order the first ones that are not near each other.
std::vector<SettledTurn> distinct(const std::vector<SettledTurn>& turns, size_t most, double worth) {
  std::vector<SettledTurn> result;
  for (const SettledTurn& t : turns)
    if (result.size() < most && t.distortion <= worth * turns[0].distortion &&
        std::none_of(result.begin(), result.end(), [&](const SettledTurn& other) {
          return rotationVector(t.turn.rotation.transpose() * other.turn.rotation).length() < kSameStart;
        }))
      result.push_back(t);
  return result;
}

SettledTurn settled(const InnerSamples (&samples)[2], const Turn& start, double first) {
  struct Placed {
    Mat3d rotation;
    double distortion;
  };
  const auto at = [&](const Mat3d& rotation) {
    return Placed{rotation, innerDistortion(samples[0], samples[1], rotation)};
  };
  const Placed least = climbRotation(
      at(start.rotation), first, kFine, at, [](const Placed& p) { return -p.distortion; },
      [](const Placed& p, double) { return 1e-3 * p.distortion; });
  Turn turn = start;
  turn.rotation = least.rotation, turn.angle = rotationVector(turn.rotation).length();
  return {turn, least.distortion};
}

std::vector<SettledTurn> allSettled(const InnerSamples (&samples)[2], std::vector<SettledTurn> turns,
                                    double first) {
  tbb::parallel_for(size_t(0), turns.size(),
                    [&](size_t i) { turns[i] = settled(samples, turns[i].turn, first); });
  return inOrder(std::move(turns));
}

}  // namespace

std::vector<SettledTurn> settleTurns(const InnerSamples (&few)[2], const InnerSamples (&many)[2],
                                     const std::vector<SettledTurn>& starts) {
  const std::vector<SettledTurn> found =
      allSettled(few, distinct(inOrder(starts), kMostWithFew, kWorthFew), kFar);
  return allSettled(many, distinct(found, kMostWithMany, kWorthMany), kNear);
}

}  // namespace slicemorph
