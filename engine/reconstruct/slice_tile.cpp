#include "engine/reconstruct/slice_tile.h"

namespace slicemorph {

namespace {

void dropBy(const float* from, float by, float* to, size_t n) {
  for (size_t i = 0; i < n; ++i) to[i] = from[i] - by;
}
void levelAll(const float* from, float at, float* to, size_t n) {
  const float per = 1 / at;
  for (size_t i = 0; i < n; ++i) to[i] = from[i] / std::sqrt(1 + (from[i] * per) * (from[i] * per));
}

}  // namespace

void TileScores::readNear(const GapLabel& l, const Moment& m, const PlanePoints* tile) {
  const size_t n = tile->x.size();
  s.resize(4 * n), whole = false;
  float *a = s.data(), *b = &s[3 * n];  // plane 0 is left to readFar
  if (l.plane[1]) l.plane[1].read(tile[1], a);
  if (l.plane[2]) l.plane[2].read(tile[2], b);
  if (!l.plane[1]) dropBy(b, fall(l, 1), a, n);
  if (!l.plane[2]) dropBy(a, fall(l, 2), b, n);
  levelAll(a, m.level, &s[n], n), levelAll(b, m.level, &s[2 * n], n);
}

void TileScores::readFar(const GapLabel& l, const Moment& m, const PlanePoints* tile) {
  if (whole) return;
  const size_t n = tile->x.size();
  for (int k : {0, 3}) {
    float* to = &s[size_t(k) * n];
    if (!(k ? m.after : m.before))
      std::fill_n(to, n, 0.0f);
    else if (l.plane[k])
      l.plane[k].read(tile[k], to);
    else
      dropBy(to, fall(l, k), to, n);
    levelAll(to, m.level, to, n);
  }
  whole = true;
}

void SliceTile::findMost(const Moments& m, size_t i, const Rivals& rivals, size_t from) {
  const size_t count = half.count();
  const float t = m.t[i];
  most.assign(count, -1e30f);
  for (size_t r = from; r < rivals.labels.size(); ++r) {
    if (!rivals.mayWin(r, i, m.first.draw)) continue;
    const float *a = &scores[r - from].s[count], *b = a + count;
    for (size_t k = 0; k < count; ++k) most[k] = std::max(most[k], a[k] + t * (b[k] - a[k]));
  }
}

bool SliceTile::comesNear(const TileScores& score, float t, float spare) const {
  const size_t count = half.count();
  const float *a = &score.s[count], *b = a + count;
  int near = 0;
  for (size_t k = 0; k < count; ++k) near |= a[k] + t * (b[k] - a[k]) + spare > most[k];
  return near;
}

void SliceTile::blendScore(const TileScores& score, const Moments& m, size_t i) {
  const size_t count = half.count();
  const float *s0 = score.s.data(), *s1 = s0 + count, *s2 = s1 + count, *s3 = s2 + count;
  const float c0 = m.cubic[0][i], c1 = m.cubic[1][i], c2 = m.cubic[2][i], c3 = m.cubic[3][i];
  const float t = m.t[i], limit = m.limit[i];
  for (size_t k = 0; k < count; ++k)
    blend[k] = limited(c0 * s0[k] + c1 * s1[k] + c2 * s2[k] + c3 * s3[k], s1[k] + t * (s2[k] - s1[k]), limit);
}

void SliceTile::compete(int label, const int* at, float draw) {
  const float *fx = points.fx.data(), *fy = points.fy.data();
  for (size_t k = 0, row = size_t(half.width()); k < part.count(); ++k) {
    const float *p = &blend[size_t(at[k])], *q = p + row;
    const float low = p[0] + fx[k] * (p[1] - p[0]), high = q[0] + fx[k] * (q[1] - q[0]);
    const float v = low + fy[k] * (high - low);
    const bool wins = v > best[k] + draw;
    best[k] = wins ? v : best[k], winner[k] = wins ? label : winner[k];
  }
}

}  // namespace slicemorph
