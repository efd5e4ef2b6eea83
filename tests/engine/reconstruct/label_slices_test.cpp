#include "engine/reconstruct/label_slices.h"
#include "engine/reconstruct/fill_gaps.h"
#include "engine/reconstruct/label_level_set.h"
#include "engine/reconstruct/regions.h"
#include "slicemorph/errors.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

using namespace slicemorph;

namespace {

using Label = std::function<int(int, int, int)>;

Image paint(int nx, int ny, int nz, const Label& label, int every = 1) {
  Image image;
  image.lattice.size = openvdb::Coord(nx, ny, nz);
  std::vector<std::uint8_t> values(image.lattice.count(), 0);
  for (int k = 0; k < nz; k += every)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) values[image.lattice.index(i, j, k)] = std::uint8_t(label(i, j, k));
  image.values = std::move(values);
  return image;
}

int at(const Image& image, int i, int j, int k) {
  return std::get<std::vector<std::uint8_t>>(image.values)[image.lattice.index(i, j, k)];
}

struct Section {
  double area = 0, x = 0, y = 0;
};

Section sectionOf(const Image& image, int label, int k) {
  Section s;
  for (int j = 0; j < image.lattice.size[1]; ++j)
    for (int i = 0; i < image.lattice.size[0]; ++i)
      if (at(image, i, j, k) == label) ++s.area, s.x += i, s.y += j;
  if (s.area > 0) s.x /= s.area, s.y /= s.area;
  return s;
}

GivenSlices findGivenSlices(const Image& labels, int axis = -1, int every = 0) {
  LabelledSlices slices(labels.lattice.size);
  slices.add(labels.values);
  return slicemorph::findGivenSlices(slices, axis, every);
}

Image fillIn(int n, int slices, int every, const Label& label) {
  const Image thin = paint(n, n, slices, label, every);
  GivenSlices given{2, {}};
  for (int k = 0; k < slices; k += every) given.at.push_back(k);
  return interpolateLabels(thin, given);
}

double distance(double x, double y, double cx, double cy) { return std::hypot(x - cx, y - cy); }

/// Several labels at once: a tilted tube in an organ, a nested pair, a ball, a line.
int scene(int i, int j, int k) {
  if (distance(i, j, 20 + k, 24) <= 3) return 3;
  if (distance(i, j, 24 + 0.5 * k, 24) <= 16) return 1;
  if (distance(i, j, 50, 50) <= 4) return 5;
  if (distance(i, j, 50, 50) <= 9) return 2;
  return i == 5 + k && j > 40 && j < 56 ? 4 : 0;
}

}  // namespace

TEST(Reconstruct, TiltedTubeMovesWithoutOverlap) {
  // Radius 5, shifted by 12 per gap of 8: consecutive sections do not overlap.
  const Image dense =
      fillIn(80, 33, 8, [](int i, int j, int k) { return distance(i, j, 15 + 1.5 * k, 40) <= 5.2 ? 7 : 0; });
  for (int k = 0; k < 33; ++k) {
    const Section s = sectionOf(dense, 7, k);
    EXPECT_NEAR(s.area, M_PI * 5.2 * 5.2, 2 * M_PI * 5.2 * 0.5) << k;  // half a pixel all round
    EXPECT_NEAR(s.x, 15 + 1.5 * k, 1) << k;
    EXPECT_NEAR(s.y, 40, 0.5) << k;
  }
}

TEST(Reconstruct, ConeAndBall) {
  const Image cone =
      fillIn(64, 33, 8, [](int i, int j, int k) { return distance(i, j, 32, 32) <= 5 + 0.6 * k; });
  for (int k = 0; k < 33; ++k)
    EXPECT_NEAR(std::sqrt(sectionOf(cone, 1, k).area / M_PI), 5 + 0.6 * k, 0.6) << k;
  const Image ball = fillIn(64, 65, 8, [](int i, int j, int k) {
    return (i - 32) * (i - 32) + (j - 32) * (j - 32) + (k - 32) * (k - 32) <= 22 * 22 ? 1 : 0;
  });
  double volume = 0;
  for (int k = 0; k < 65; ++k) volume += sectionOf(ball, 1, k).area;
  EXPECT_NEAR(volume / (4.0 / 3 * M_PI * 22 * 22 * 22), 1, 0.05);
}

TEST(Reconstruct, WideGap) {
  // More slices than are labelled together (kMoments).
  const Image cone =
      fillIn(64, 41, 20, [](int i, int j, int k) { return distance(i, j, 32, 32) <= 8 + 0.4 * k ? 1 : 0; });
  for (int k = 0; k < 41; ++k)
    EXPECT_NEAR(std::sqrt(sectionOf(cone, 1, k).area / M_PI), 8 + 0.4 * k, 0.6) << k;
}

TEST(Reconstruct, RegionsAreJoinedBelow) {
  // Two arms that meet at the bottom, a pixel that touches one at a corner, and an isolated one.
  const char* const rows[] = {"#..#..#", "#..#...", "#..##..", "###..#.", ".##...."};
  LabelScore score;
  score.box = {3, 2, 10, 7};
  for (const char* row : rows)
    for (int x = 0; x < 7; ++x) score.values.push_back(row[x] == '#' ? 0.5f + 0.1f * float(x) : -0.5f);
  const LabelRegions found = findRegions(score);
  ASSERT_EQ(found.regions.size(), 2u);
  EXPECT_EQ(found.regions[0].count, 13u);
  EXPECT_EQ(found.regions[1].count, 1u);
  EXPECT_FLOAT_EQ(found.regions[0].depth, 1.0f);
  EXPECT_FLOAT_EQ(found.regions[1].x, 9);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x)
      EXPECT_EQ(found.at(3 + x, 2 + y), rows[y][x] != '#' ? -1 : y == 0 && x == 6 ? 1 : 0) << x << ' ' << y;
}

TEST(Reconstruct, BranchesJoin) {
  // Trousers: two legs that merge.
  const Image y = fillIn(80, 33, 8, [](int i, int j, int k) {
    const double apart = std::max(0.0, 20.0 - 0.75 * k);
    return distance(i, j, 40 - apart, 40) <= 8 || distance(i, j, 40 + apart, 40) <= 8 ? 1 : 0;
  });
  for (int k = 0; k < 33; ++k) {
    EXPECT_GT(sectionOf(y, 1, k).area, 0.8 * M_PI * 64) << k;
    EXPECT_NEAR(sectionOf(y, 1, k).x, 40, 0.6) << k;
  }
}

TEST(Reconstruct, LabelEndsBetweenSlices) {
  const Image end =
      fillIn(48, 17, 8, [](int i, int j, int k) { return k <= 8 && distance(i, j, 24, 24) <= 6; });
  EXPECT_GT(sectionOf(end, 1, 9).area, 0);
  EXPECT_EQ(sectionOf(end, 1, 16).area, 0);
  for (int k = 9; k < 17; ++k) EXPECT_LE(sectionOf(end, 1, k).area, sectionOf(end, 1, k - 1).area) << k;
}

TEST(Reconstruct, ThinThingsJumpAndStay) {
  const Image line =
      fillIn(64, 17, 8, [](int i, int j, int k) { return i == 10 + 2 * k && j > 10 && j < 50 ? 1 : 0; });
  const Image dot =
      fillIn(64, 17, 8, [](int i, int j, int k) { return i == 10 + 2 * k && j == 60 - 3 * k ? 1 : 0; });
  for (int k = 0; k < 17; ++k) {
    EXPECT_NEAR(sectionOf(line, 1, k).area, 39, 4) << k;
    EXPECT_NEAR(sectionOf(line, 1, k).x, 10 + 2 * k, 1) << k;
    EXPECT_EQ(sectionOf(dot, 1, k).area, 1) << k;
    EXPECT_NEAR(sectionOf(dot, 1, k).y, 60 - 3 * k, 1) << k;
  }
}

TEST(Reconstruct, GivenSlicesStayAndNumbersDoNotMatter) {
  const Image dense = fillIn(72, 25, 8, scene);
  const int other[6] = {0, 250, 3, 1, 77, 2};
  const Image renamed = fillIn(72, 25, 8, [&](int i, int j, int k) { return other[scene(i, j, k)]; });
  for (int k = 0; k < 25; ++k)
    for (int j = 0; j < 72; ++j)
      for (int i = 0; i < 72; ++i) {
        ASSERT_EQ(at(renamed, i, j, k), other[at(dense, i, j, k)]);
        if (k % 8 == 0) {
          ASSERT_EQ(at(dense, i, j, k), scene(i, j, k));
        }
      }
  for (int label = 1; label < 6; ++label)
    for (int k = 0; k < 25; ++k) EXPECT_GT(sectionOf(dense, label, k).area, 0) << label << " at " << k;
}

TEST(Reconstruct, MirroredInputMirrorsOutput) {
  const Image dense = fillIn(72, 25, 8, scene);
  const Image turned = fillIn(72, 25, 8, [](int i, int j, int k) { return scene(i, j, 24 - k); });
  size_t differ = 0, drawn = 0;
  for (int k = 0; k < 25; ++k)
    for (int j = 0; j < 72; ++j)
      for (int i = 0; i < 72; ++i)
        differ += at(turned, i, j, 24 - k) != at(dense, i, j, k), drawn += at(dense, i, j, k) != 0;
  EXPECT_LE(differ, drawn / 1000);  // half pixels are rounded in one direction
}

TEST(Reconstruct, SameForAnyThreadCount) {
  std::vector<Image> made;
  for (size_t threads : {1, 2, 4}) withThreads(threads, [&] { made.push_back(fillIn(72, 25, 8, scene)); });
  EXPECT_EQ(made[0].values, made[1].values);
  EXPECT_EQ(made[0].values, made[2].values);
}

TEST(Reconstruct, FindsGivenSlices) {
  const auto ball = [](int i, int j, int k) { return distance(i, j, 16, 16) <= 10 && k > 2 ? 1 : 0; };
  const GivenSlices found = findGivenSlices(paint(32, 32, 25, ball, 4));
  EXPECT_EQ(found.axis, 2);
  EXPECT_EQ(found.at, (std::vector<int>{4, 8, 12, 16, 20, 24}));
  // An empty slice at a regular position is given.
  const auto gap = [&](int i, int j, int k) { return k == 12 ? 0 : ball(i, j, k); };
  EXPECT_EQ(findGivenSlices(paint(32, 32, 25, gap, 4)).at, found.at);
  const auto uneven = [&](int i, int j, int k) {
    return k == 4 || k == 7 || k == 9 || k == 20 ? ball(i, j, k) : 0;
  };
  EXPECT_EQ(findGivenSlices(paint(32, 32, 25, uneven)).at, (std::vector<int>{4, 7, 9, 20}));
  EXPECT_THROW(findGivenSlices(paint(32, 32, 25, ball)), InputError);
  EXPECT_THROW(findGivenSlices(paint(32, 32, 25, ball), 2), InputError);
  EXPECT_THROW(findGivenSlices(paint(32, 32, 25, [](int, int, int) { return 0; })), InputError);
  EXPECT_THROW(findGivenSlices(paint(32, 32, 25, [](int i, int j, int k) { return k == 8 && i > j; }), 2),
               InputError);
  Image fraction = paint(8, 8, 8, [](int, int, int) { return 0; });
  fraction.values = std::vector<float>(512, 0.5f);
  EXPECT_THROW(findGivenSlices(fraction), InputError);
}

TEST(Reconstruct, LevelSetPassesThroughTheContours) {
  const auto tube = [](int i, int j, int k) { return distance(i, j, 20 + 0.5 * k, 32) <= 9 ? 1 : 0; };
  const Image thin = paint(64, 64, 33, tube, 8);
  RankedSlices ranked = rankSlices(thin, findGivenSlices(thin));
  const size_t rank = ranked.values[0] == 1 ? 0 : 1;
  const SliceScores scores(std::move(ranked.stack));
  const FloatGrid::Ptr grid = labelLevelSet(scores, int(rank), {});
  auto values = grid->getConstAccessor();
  for (int k = 0; k < 33; k += 8)
    for (int j = 1; j < 63; ++j)
      for (int i = 1; i < 63; ++i) {
        const Vec3d node = grid->transform().worldToIndex(Vec3d(i, j, k));
        ASSERT_NEAR(node[2], std::round(node[2]), 1e-6);
        ASSERT_EQ(values.getValue(openvdb::Coord::round(node)) < 0, tube(i, j, k) == 1)
            << i << " " << j << " " << k;
      }
  // Closed within half a gap.
  for (double z : {-5.0, 37.0}) {
    const Vec3d node = grid->transform().worldToIndex(Vec3d(z < 0 ? 20 : 36, 32, z));
    EXPECT_GT(values.getValue(openvdb::Coord::round(node)), 0);
  }
}
