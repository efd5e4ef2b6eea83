#include "engine/match/limb_pairs.h"

#include "engine/match/assignment.h"

#include <cmath>

namespace slicemorph {

namespace {

/// Costs of a difference of one size in where a limb leaves the body and in where its tip is, and of lengths that differ
/// by the factor e; and what being left without a partner costs.
constexpr double kRootPrice = 2, kTipPrice = 0.5, kLengthPrice = 0.4, kAlonePrice = 1.3;
/// The first points of a limb's line, which tell where it leaves the body.
constexpr int kRootPoints = 4;

double costOf(const PlacedLimb& a, const PlacedLimb& b, double size) {
  Vec3d root(0.0);
  for (int i = 0; i < kRootPoints; ++i) root += (a.middle[size_t(i)] - b.middle[size_t(i)]) / double(kRootPoints);
  const double tip = (a.middle.back() - b.middle.back()).length();
  return (kRootPrice * root.length() + kTipPrice * tip) / size + kLengthPrice * std::abs(std::log(a.length / b.length));
}

/// `v` turned the way that takes one direction to another.
Mat3d turnBetween(const Vec3d& from, const Vec3d& to) {
  const Vec3d axis = from.cross(to);
  const double s = axis.length();
  return s < 1e-9 ? Mat3d::identity() : rotationFromVector(axis / s * std::atan2(s, from.dot(to)));
}

/// A limb as a root, lengths, and frames that do not spin (first column along the limb), one a piece between two points.
struct Stem {
  Vec3d root;
  std::vector<double> length;
  std::vector<Mat3d> frame;
};

Stem stemOf(const std::vector<Vec3d>& line, const Mat3d& firstFrame) {
  Stem stem{line[0], {}, {}};
  Mat3d frame = firstFrame;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec3d d = line[i + 1] - line[i];
    stem.length.push_back(d.length());
    if (d.length() > 0) frame = turnBetween(frame.col(0), d.unit()) * frame;
    stem.frame.push_back(frame);
  }
  return stem;
}

Mat3d meanFrame(const std::vector<Mat3d>& frames) {
  Mat3d mean = frames[0];
  for (int i = 0; i < 20; ++i) {
    Vec3d step(0.0);
    for (const Mat3d& f : frames) step += rotationVector(mean.transpose() * f) / double(frames.size());
    mean = mean * rotationFromVector(step);
  }
  return mean;
}

/// Mean root and lengths; the first frame is the mean, and from piece to piece it turns by the mean of the turns.
Stem meanStem(const std::vector<Stem>& stems) {
  const double share = 1.0 / double(stems.size());
  Stem mean = stems[0];
  mean.root = Vec3d(0.0);
  std::vector<Mat3d> first;
  for (const Stem& s : stems) mean.root += share * s.root, first.push_back(s.frame[0]);
  mean.frame[0] = meanFrame(first);
  for (size_t i = 0; i < mean.length.size(); ++i) {
    mean.length[i] = 0;
    for (const Stem& s : stems) mean.length[i] += share * s.length[i];
    if (i == 0) continue;
    Vec3d turn(0.0);
    for (const Stem& s : stems) turn += share * rotationVector(s.frame[i - 1].transpose() * s.frame[i]);
    mean.frame[i] = mean.frame[i - 1] * rotationFromVector(turn);
  }
  return mean;
}

/// The middle line's points, each with four around it.
std::vector<Vec3d> pointsOf(const Stem& stem, const std::vector<double>& radius) {
  std::vector<Vec3d> points;
  Vec3d p = stem.root;
  for (size_t i = 0; i < radius.size(); ++i) {
    const Mat3d& frame = stem.frame[std::min(i, stem.frame.size() - 1)];
    const Vec3d x = radius[i] * frame.col(1), y = radius[i] * frame.col(2);
    for (const Vec3d& around : {Vec3d(0.0), x, -x, y, -y}) points.push_back(p + around);
    if (i < stem.length.size()) p += stem.length[i] * frame.col(0);
  }
  return points;
}

}  // namespace

std::vector<int> matchLimbs(const std::vector<PlacedLimb>& a, const std::vector<PlacedLimb>& b, double size) {
  if (a.empty() || b.empty()) return std::vector<int>(a.size(), -1);
  std::vector<std::vector<double>> cost(a.size(), std::vector<double>(b.size() + a.size(), kAlonePrice));
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t j = 0; j < b.size(); ++j) cost[i][j] = costOf(a[i], b[j], size);
  std::vector<int> partner = assign(cost);
  for (int& p : partner)
    if (p >= int(b.size())) p = -1;
  return partner;
}

std::vector<Correspondence> limbPoints(const std::vector<PlacedLimb>& limbs) {
  std::vector<Stem> stems;
  for (const PlacedLimb& limb : limbs) {
    const Vec3d d = limb.chart[1] - limb.chart[0];
    const Vec3d along = d.length() > 0 ? d.unit() : Vec3d(1, 0, 0);
    // One frame for all where they leave the body, then each its own way.
    Mat3d frame = stems.empty() ? turnBetween({1, 0, 0}, along) : stems[0].frame[0];
    frame = turnBetween(frame.col(0), along) * frame;
    stems.push_back(stemOf(limb.chart, frame));
  }
  std::vector<double> meanRadius(limbs[0].radius.size(), 0);
  for (const PlacedLimb& limb : limbs)
    for (size_t i = 0; i < meanRadius.size(); ++i) meanRadius[i] += limb.radius[i] / double(limbs.size());
  const std::vector<Vec3d> middle = pointsOf(meanStem(stems), meanRadius);
  std::vector<Correspondence> points(middle.size());
  for (size_t i = 0; i < middle.size(); ++i) points[i].middle = middle[i];
  for (size_t k = 0; k < limbs.size(); ++k) {
    const std::vector<Vec3d> own = pointsOf(stems[k], limbs[k].radius);
    for (size_t i = 0; i < own.size(); ++i) points[i].at.push_back(own[i]);
  }
  return points;
}

}  // namespace slicemorph
