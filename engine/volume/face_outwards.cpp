#include "engine/volume/face_outwards.h"

#include "engine/volume/agree_on_winding.h"
#include "engine/volume/mesh_measures.h"
#include "engine/volume/surface_samples.h"
#include "engine/volume/turn_outwards.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slicemorph {
namespace {

using Index = std::uint32_t;

/// Rays from each side of a patch: what 2 standard deviations of a vote decide is then a quarter of them. Where there
/// are very many patches, fewer, so that all take as long as those of one large mesh's voxels.
constexpr size_t kRays = 64, kLeastRays = 8, kAllRays = 1 << 18;
/// Rays begin this far from their triangle, in the mesh's diagonals: coordinates in single precision are exact to 1e-7.
constexpr double kLift = 1e-6;
/// Strides of directions, as in surface_samples.cpp but in space [Rob18].
constexpr double kStrideHeight = 0.8191725133961645, kStrideTurn = 0.6710436067037893;

struct Votes {
  size_t front = 0, back = 0;  ///< rays that got away
  std::vector<Index> hit;      ///< triangles that the others hit

  /// Differences of less than 2 standard deviations are no decision.
  bool turned() const { return back > front && double(back - front) > 2 * std::sqrt(double(back + front)); }
};

/// A direction in the half space that a normal points into.
Vec3d directionAbout(const Vec3d& normal, size_t k) {
  const double height = evenSequence(k, kStrideHeight), turn = 2 * M_PI * evenSequence(k, kStrideTurn);
  const Vec3d aside = std::abs(normal[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  const Vec3d x = normal.cross(aside).unit(), y = normal.cross(x);
  const double across = std::sqrt(std::max(0.0, 1 - height * height));
  return height * normal + across * (std::cos(turn) * x + std::sin(turn) * y);
}

Votes votesOf(const Mesh& mesh, const std::vector<Index>& patch, const WindingNumber& rays, size_t count,
              double lift) {
  Votes votes;
  size_t k = 0;
  for (const SurfacePoint& s : sampleSurface(mesh, patch, count)) {
    const Vec3d forth = directionAbout(s.normal, k++), mirrored = forth - 2 * forth.dot(s.normal) * s.normal;
    const auto front = rays.firstHit(s.point + lift * s.normal, forth);
    const auto back = rays.firstHit(s.point - lift * s.normal, mirrored);
    votes.front += !front, votes.back += !back;
    if (front) votes.hit.push_back(*front);
    if (back) votes.hit.push_back(*back);
  }
  return votes;
}

std::vector<Votes> votesOfAll(const Mesh& mesh, const std::vector<std::vector<Index>>& sets,
                              const WindingNumber& rays) {
  const double lift = kLift * boundsOf(mesh.points).extents().length();
  const size_t count = std::clamp(kAllRays / std::max(sets.size(), size_t(1)), kLeastRays, kRays);
  std::vector<Votes> votes(sets.size());
  tbb::parallel_for(size_t(0), sets.size(),
                    [&](size_t i) { votes[i] = votesOf(mesh, sets[i], rays, count, lift); });
  return votes;
}

}  // namespace

size_t faceOutwards(Mesh& mesh, const std::vector<Index>& patch, const WindingNumber& rays) {
  const std::vector<std::vector<Index>> patches = trianglesOfSets(patch);
  const std::vector<Votes> votes = votesOfAll(mesh, patches, rays);
  std::vector<Index> number(mesh.triangles.size());
  for (Index i = 0; i < patches.size(); ++i)
    for (Index t : patches[i]) number[t] = i;
  size_t turned = 0;
  for (size_t i = 0; i < patches.size(); ++i) {
    bool turn = votes[i].turned();
    if (votes[i].front + votes[i].back == 0) {
      ptrdiff_t against = 0;
      for (Index t : votes[i].hit)
        if (const Votes& other = votes[number[t]]; other.front + other.back > 0)
          against += other.turned() ? 1 : -1;
      turn = against > 0;
    }
    if (turn) turnOver(mesh, patches[i]), turned += patches[i].size();
  }
  return turned;
}

size_t facePiecesOutwards(Mesh& mesh, const std::vector<Index>& piece, const WindingNumber& rays) {
  const std::vector<std::vector<Index>> pieces = trianglesOfSets(piece);
  const std::vector<Votes> votes = votesOfAll(mesh, pieces, rays);
  size_t turned = 0;
  for (size_t i = 0; i < pieces.size(); ++i)
    if (votes[i].turned()) turnOver(mesh, pieces[i]), turned += pieces[i].size();
  return turned;
}

}  // namespace slicemorph
