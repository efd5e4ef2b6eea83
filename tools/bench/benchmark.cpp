// Benchmarks as ratios against peers of the same run.
// Usage: slicemorph_benchmark [MESH MESH] [--quick] [--fog] [--many]
// Without meshes the bundled creature and ring are used. --fog runs only the fog (of the files given, if
// any), --many only the blends of many objects; --quick leaves out OpenVDB's LevelSetMorphing and 512 voxels.
#include "engine/measure/measure.h"
#include "engine/peers/peers.h"
#include "engine/volume/level_set.h"
#include "engine/volume/voxelise.h"
#include "io/vdb/grid_sets.h"
#include "slicemorph/io/input.h"
#include "slicemorph/slicemorph.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>
#include <type_traits>

namespace slicemorph {
namespace {

using openvdb::GridBase;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Seconds, the best of three runs, which is least disturbed by other processes.
template <typename Work>
double timeOf(const Work& work) {
  double best = 1e30;
  for (int i = 0; i < 3; ++i) {
    const double start = seconds();
    work();
    best = std::min(best, seconds() - start);
  }
  return best;
}

Weights at(double t) { return {1 - t, t}; }

std::vector<Object> load(const std::vector<std::string>& inputs, int resolution) {
  std::vector<Object> objects;
  for (const std::string& input : inputs) {
    LoadOptions options;
    options.resolution = resolution;
    objects.push_back(loadObject(input, options).object);
  }
  return objects;
}

struct FrameCost {
  double ours = 0, voxelising = 0;
};

/// Seconds per frame, and of meshToLevelSet on the meshes of the same frames; means over some in-betweens.
FrameCost frameCost(const MorphPlan& plan) {
  FrameCost cost;
  const double times[] = {0.2, 0.5, 0.8};
  for (double t : times) {
    FloatGrid::Ptr frame;
    cost.ours += timeOf([&] { frame = plan.frame(at(t)).surface; }) / std::size(times);
    const Mesh mesh = surfaceOf(*frame);
    cost.voxelising += timeOf([&] { voxelise(mesh, frame->voxelSize()[0]); }) / std::size(times);
  }
  return cost;
}

double peakGiB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / (1 << 20);
}

void againstSdf(const std::vector<Object>& objects, const FrameCost& cost) {
  const std::vector<FloatGrid::ConstPtr> grids{objects[0].levelSet, objects[1].levelSet};
  const SdfBlend blend(grids, std::min(grids[0]->voxelSize()[0], grids[1]->voxelSize()[0]));
  const double peer = timeOf([&] { blend.frame(at(0.5)); });
  std::printf("frame / --method sdf             %6.3f   goal <= 0.5    (%.3f s / %.3f s)\n", cost.ours / peer,
              cost.ours, peer);
}

void againstLevelSet(const std::vector<Object>& objects) {
  constexpr int kFrames = 25;
  double start = seconds();
  const MorphPlan plan(objects);
  for (int i = 0; i < kFrames; ++i) plan.frame(at(i / double(kFrames - 1)));
  const double ours = seconds() - start;
  start = seconds();
  const LevelSetMorphResult peer = levelSetMorph(*objects[0].levelSet, *objects[1].levelSet, kFrames);
  const double theirs = seconds() - start;
  std::printf(
      "25 frames / --method levelset    %6.3f   goal <= 0.05   (%.1f s / %.1f s; it rests %.2f voxels away "
      "after %d steps)\n",
      ours / theirs, ours, theirs, peer.restDistance, peer.steps);
}

/// A rod, straight or bent to an arc of `bend` radians.
Object rod(double bend, double voxelSize) {
  constexpr double kLength = 2, kThick = 0.18;
  constexpr int kSides = 24, kRings = 120;
  Mesh mesh;
  const auto bent = [&](double s, double y, double z) {
    if (bend == 0) return openvdb::Vec3s(float(s), float(y), float(z));
    const double radius = kLength / bend, a = s / radius;
    return openvdb::Vec3s(float((radius - y) * std::sin(a)), float(radius - (radius - y) * std::cos(a)),
                          float(z));
  };
  for (int i = 0; i <= kRings; ++i)
    for (int j = 0; j < kSides; ++j) {
      const double s = kLength * (double(i) / kRings - 0.5), angle = 2 * 3.14159265358979 * j / kSides;
      mesh.points.push_back(bent(s, kThick * std::cos(angle), 0.7 * kThick * std::sin(angle)));
    }
  const auto point = [&](int ring, int side) { return unsigned(ring * kSides + side % kSides); };
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kSides; ++j) {
      mesh.triangles.emplace_back(point(i, j), point(i + 1, j), point(i + 1, j + 1));
      mesh.triangles.emplace_back(point(i, j), point(i + 1, j + 1), point(i, j + 1));
    }
  for (int end : {0, kRings}) {
    mesh.points.push_back(bent(kLength * (double(end) / kRings - 0.5), 0, 0));
    const unsigned middle = unsigned(mesh.points.size()) - 1;
    for (int j = 0; j < kSides; ++j) {
      if (end == 0)
        mesh.triangles.emplace_back(middle, point(end, j), point(end, j + 1));
      else
        mesh.triangles.emplace_back(middle, point(end, j + 1), point(end, j));
    }
  }
  return {"rod", voxelise(mesh, voxelSize)};
}

/// Planning a morph with curved spines against the same with straight ones, and its
/// frames against meshToLevelSet.
void curvedAgainstStraight() {
  const std::vector<Object> objects{rod(0, 2.0 / 256), rod(2.1, 2.0 / 256)};
  MorphOptions straight;
  straight.spine = SpineKind::kStraight;
  const double curved = timeOf([&] { MorphPlan plan(objects); }),
               peer = timeOf([&] { MorphPlan plan(objects, straight); });
  std::printf("plan, curved / straight          %6.3f   goal <= 3      (%.2f s / %.2f s)\n", curved / peer,
              curved, peer);
  const FrameCost bent = frameCost(MorphPlan(objects));
  std::printf("frame, curved / meshToLevelSet   %6.3f   goal <= 1.5    (%.3f s / %.3f s)\n",
              bent.ours / bent.voxelising, bent.ours, bent.voxelising);
}

/// A cloud of overlapping puffs, active where some puff is. `extent`: voxels along the longest side;
/// `radius`: of a puff, voxels.
FloatGrid::Ptr cloud(int extent, int puffs, double radius, unsigned seed) {
  auto grid = FloatGrid::create(0.f);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setName("density");
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(radius, extent - radius);
  for (int i = 0; i < puffs; ++i) {
    // Along a bent plume, so that the box is mostly empty.
    const double t = (i + 0.5) / puffs, bend = 0.3 * std::sin(3 * t + seed);
    const Vec3d middle(extent * (0.5 + bend) + 0.1 * (coordinate(random) - 0.5 * extent),
                       radius + t * (extent - 2 * radius),
                       0.5 * extent + 0.1 * (coordinate(random) - 0.5 * extent));
    FloatGrid::Ptr puff = openvdb::tools::createLevelSetSphere<FloatGrid>(float(radius * (0.6 + 0.4 * t)),
                                                                          openvdb::Vec3f(middle), 1.f, 3.f);
    openvdb::tools::sdfToFogVolume(*puff, float(0.5 * radius));
    openvdb::tools::compMax(*grid, *puff);
  }
  grid->tree().voxelizeActiveTiles();
  return grid;
}

/// Resamples a grid onto voxels between its own, trilinearly; labels by the nearest voxel.
void resample(const GridBase& grid) {
  using Types = openvdb::TypeList<FloatGrid, openvdb::Vec3SGrid, openvdb::Int32Grid>;
  grid.apply<Types>([](const auto& typed) {
    using Grid = std::decay_t<decltype(typed)>;
    using Sampler = std::conditional_t<std::is_same_v<Grid, openvdb::Int32Grid>, openvdb::tools::PointSampler,
                                       openvdb::tools::BoxSampler>;
    Grid in(openvdb::ConstPtrCast<typename Grid::TreeType>(
        typed.treePtr()));  // of no class: level sets would be rebuilt
    in.setTransform(typed.transform().copy());
    Grid out(typed.background());
    out.setTransform(typed.transform().copy());
    out.transform().preTranslate(Vec3d(0.3, 0.4, 0.2));
    openvdb::tools::resampleToMatch<Sampler>(in, out);
  });
}

/// A frame of fog with all its grids against a resampling of the same grids.
void fogAgainstResample(const std::vector<Object>& objects,
                        const std::vector<std::vector<GridBase::ConstPtr>>& sets, const char* name) {
  const MorphPlan plan(objects);
  double out = 0;
  const double ours = timeOf([&] {
    Pullback pullback = plan.pullback(at(0.5));
    out = 0;
    for (const auto& grids : sets) out += double(pullback.carry(grids)->activeVoxelCount()) / 1e6;
  });
  double in = 0;
  const double peer = timeOf([&] {
    in = 0;
    for (const auto& grids : sets)
      for (const GridBase::ConstPtr& grid : grids)
        resample(*grid), in += double(grid->activeVoxelCount()) / 1e6;
  });
  std::printf(
      "fog frame / resampleToMatch      %6.3f   goal <= 2      (%.3f s / %.3f s; %s, %zu grids, %.1f million "
      "voxels in, "
      "%.1f out)\n",
      ours / peer, ours, peer, name, sets.size(), in, out);
  std::fflush(stdout);
}

void fogFiles(const std::vector<std::string>& inputs, const char* name) {
  std::vector<LoadedObject> loaded;
  std::vector<Object> objects;
  for (const std::string& input : inputs) {
    LoadOptions options;
    options.fogResolution = 160;  // as `slicemorph morph`
    loaded.push_back(loadObject(input, options));
    objects.push_back(loaded.back().object);
  }
  std::vector<std::vector<GridBase::ConstPtr>> sets;
  for (const GridSet& set : pairGrids(loaded).sets)
    if (set.index[0] && set.index[1]) sets.push_back(readGrids(set, loaded));
  const double before = peakGiB();
  fogAgainstResample(objects, sets, name);
  std::printf("peak memory                      %6.2f   goal <  6 GiB  (%.2f when the shapes were read)\n",
              peakGiB(), before);
}

/// Fog through files, as users have it, so that reading voxels on demand counts too.
void clouds(int extent, int puffs, double radius, const char* name) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  for (unsigned seed : {1u, 2u}) {
    files.push_back(
        (fs::temp_directory_path() / ("slicemorph_cloud_" + std::to_string(seed) + ".vdb")).string());
    openvdb::io::File(files.back()).write(openvdb::GridPtrVec{cloud(extent, puffs, radius, seed)});
  }
  fogFiles(files, name);
  for (const std::string& file : files) fs::remove(file);
}

void fog(bool quick) {
  clouds(128, 12, 20, "128");
  clouds(256, 12, 40, "256");
  if (quick) return;
  clouds(1024, 40, 90, "1024");
}

/// A ball of radius about 1 with lumps of its own; 128 voxels.
Object lumpyBall(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Vec3d> waves;
  std::vector<double> phase;
  for (int i = 0; i < 6; ++i)
    waves.emplace_back(3 * any(random), 3 * any(random), 3 * any(random)), phase.push_back(3 * any(random));
  const Vec3d stretch(1 + 0.3 * any(random), 1 + 0.3 * any(random), 1 + 0.3 * any(random));
  Mesh mesh =
      surfaceOf(*openvdb::tools::createLevelSetSphere<FloatGrid>(1.f, openvdb::Vec3f(0.f), 0.03f, 3.f));
  for (openvdb::Vec3s& p : mesh.points) {
    const Vec3d on(p);
    double height = 1;
    for (size_t i = 0; i < waves.size(); ++i) height += 0.05 * std::sin(waves[i].dot(on) + phase[i]);
    p = openvdb::Vec3s(height * stretch * on);
  }
  return {"ball " + std::to_string(seed), voxelise(mesh, 2.4 / 128)};
}

/// The cost of a blend of N objects, which should grow no faster than N.
void manyObjects() {
  double plan2 = 0, frame2 = 0;
  for (size_t n : {2, 4, 8}) {
    std::vector<Object> objects;
    for (size_t k = 0; k < n; ++k) objects.push_back(lumpyBall(unsigned(k) + 1));
    std::unique_ptr<MorphPlan> plan;
    const double planning = timeOf([&] { plan = std::make_unique<MorphPlan>(objects); });
    const Weights equal(n, 1.0 / double(n));
    const double frame = timeOf([&] { plan->frame(equal); });
    if (n == 2) plan2 = planning, frame2 = frame;
    std::printf(
        "%zu objects: plan %.2f s, frame %.3f s; against two, per object  plan %6.3f  frame %6.3f   goal <= "
        "1\n",
        n, planning, frame, planning / plan2 * 2 / double(n), frame / frame2 * 2 / double(n));
    std::fflush(stdout);
  }
}

void run(const std::vector<std::string>& inputs, bool quick) {
  std::vector<double> costs;
  for (int resolution : {128, 256, 512}) {
    if (quick && resolution > 256) break;
    const std::vector<Object> objects = load(inputs, resolution);
    const double start = seconds();
    const MorphPlan plan(objects);
    const double planning = seconds() - start;
    const FrameCost cost = frameCost(plan);
    std::printf("%d voxels: plan %.2f s, frame %.3f s\n", resolution, planning, cost.ours);
    std::printf("frame / meshToLevelSet           %6.3f   goal <= 1.5    (%.3f s / %.3f s)\n",
                cost.ours / cost.voxelising, cost.ours, cost.voxelising);
    if (!costs.empty())
      std::printf("frame / frame at half as many    %6.3f   goal <= 4.5\n", cost.ours / costs.back());
    costs.push_back(cost.ours);
    if (resolution == 512) std::printf("peak memory                      %6.2f   goal <  4 GiB\n", peakGiB());
    std::fflush(stdout);
  }
  const std::vector<Object> objects = load(inputs, 256);
  againstSdf(objects, frameCost(MorphPlan(objects)));
  std::fflush(stdout);
  curvedAgainstStraight();
  if (!quick) againstLevelSet(objects);
}

}  // namespace
}  // namespace slicemorph

int main(int argc, char** argv) {
  std::vector<std::string> inputs;
  bool quick = false, fog = false, many = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else if (std::strcmp(argv[i], "--fog") == 0)
      fog = true;
    else if (std::strcmp(argv[i], "--many") == 0)
      many = true;
    else
      inputs.push_back(argv[i]);
  }
  const bool filesGiven = !inputs.empty();
  if (!filesGiven) inputs = {SLICEMORPH_ASSETS "/creature.ply", SLICEMORPH_ASSETS "/ring.ply"};
  if (inputs.size() != 2) {
    std::fprintf(stderr, "usage: slicemorph_benchmark [MESH MESH] [--quick] [--fog] [--many]\n");
    return 2;
  }
  openvdb::initialize();
  try {
    if (many) {
      slicemorph::manyObjects();
      return 0;
    }
    if (!fog) slicemorph::run(inputs, quick), slicemorph::manyObjects();
    if (fog && filesGiven)
      slicemorph::fogFiles(inputs, "files");
    else
      slicemorph::fog(quick);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "slicemorph_benchmark: %s\n", e.what());
    return 1;
  }
}
