#include "engine/match/register.h"

#include "engine/match/along_spine.h"
#include "engine/match/features.h"
#include "engine/match/fit_field.h"
#include "engine/match/flow.h"
#include "engine/match/fold_guard.h"
#include "engine/match/limb_groups.h"
#include "engine/match/soft_match.h"
#include "engine/numerics/smoothstep.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

namespace slicemorph {

namespace {

/// One round of matching, from coarse to fine. Lengths are shares of the objects' size in chart space.
struct Round {
  bool soft;         ///< soft match, else closest points
  double reach;      ///< blur of the soft match; or distance up to which a closest point counts
  double spacing;    ///< of the fitted lattice
  double stiffness;  ///< of the fit
  int samples;       ///< per object
};

const Round kRounds[] = {
    {true, 0.22, 0.25, 8, 900},   {true, 0.16, 0.20, 8, 900},   {true, 0.12, 0.15, 6, 1400},
    {true, 0.09, 0.12, 5, 1400},  {true, 0.065, 0.09, 4, 2200}, {true, 0.05, 0.075, 3, 2200},
    {false, 0.20, 0.06, 2, 6000}, {false, 0.12, 0.05, 2, 6000}, {false, 0.08, 0.045, 1.5, 8000},
    {false, 0.06, 0.04, 1, 8000},
};

/// Rounds of a smaller reach are the last ones.
constexpr double kFine = 0.1;

/// A look at how well two objects can be matched at all.
const Round kQuickRounds[] = {{false, 0.25, 0.14, 3, 1500}, {false, 0.15, 0.10, 2, 1500}};

/// What a frame of a sequence changes since the one before.
const Round kFollowRounds[] = {{false, 0.12, 0.06, 2, 6000}, {false, 0.06, 0.045, 1.5, 8000}};
/// Overlap that only a cut loses from one frame to the next.
constexpr double kCut = 0.15;
/// Limbs are followed by fields of this spacing, and the map that follows them is kept on a lattice of this
/// one.
constexpr double kFlowSpacing = 0.08, kFlowLattice = 0.04;
/// Per object: samples of the body, which keeps its place meanwhile; and how far it is from a limb, in the
/// limb's radii.
constexpr int kStillSamples = 900;
constexpr double kStillReach = 1.5;

/// What a limb that grows out of the body is worth although it costs overlap: the air beside it has no place
/// on the object that lacks it.
constexpr double kGrownBonus = 0.03;

/// A gain in overlap after a quick matching that is one after the whole matching, too.
constexpr double kNoDoubt = 0.1;
/// And one that is worth a whole matching to see.
constexpr double kWorthTrying = 0.04;

/// Samples of an inner surface, at least.
constexpr int kLeastInner = 300;
/// Marks alone make a first map as smooth as the first soft matches.
constexpr double kMarkSpacing = 0.15, kMarkStiffness = 0.5;

/// A gain in overlap that is no accident.
constexpr double kClearGain = 0.01;

class Registrar {
 public:
  Registrar(const Fields& fields, const std::vector<Fields>& inner, const Frames& frames,
            const MorphOptions& options, Progress& progress)
      : fields_(fields),
        charts_(frames.charts),
        options_(options),
        progress_(progress),
        objects_(fields.size()) {
    for (const Fields& surface : inner) inner_.push_back({surface, {}, {}});
    features_ = placeFeatures(options.features, fields, charts_);
  }

  Registration run(bool last) {
    start();
    State best;
    const std::vector<State> candidates = withLimbs();
    const double rounds = double(std::size(kRounds) * candidates.size());
    int n = 0;
    for (const State& candidate : candidates) {
      now_ = candidate;
      for (const Round& round : kRounds) {
        if (progress_.cancelled()) throw Cancelled();
        progress_.report("match", 0.2 + 0.8 * n++ / rounds);
        if (last || round.soft || round.reach >= kFine) refine(round);
      }
      if (now_.value() > best.value() + kClearGain) best = std::move(now_);
    }
    now_ = std::move(best);
    finish();
    return std::move(result_);
  }

  Registration started() {
    start();
    finish(false);
    return std::move(result_);
  }

  Registration refined(Registration made) {
    measureObjects();
    startFrom(made.map, made.map);
    for (const Round& round : kFollowRounds) {
      if (progress_.cancelled()) throw Cancelled();
      progress_.report("match", 0.95);
      refine(round);
    }
    finish();
    made.notes.insert(made.notes.end(), result_.notes.begin(), result_.notes.end());
    made.map = std::move(result_.map), made.base = std::move(result_.base),
    made.overlapAfter = result_.overlapAfter;
    return made;
  }

  std::optional<Registration> follow(const Registration& before) {
    measureObjects();
    startFrom(before.map, before.base);
    if (now_.overlap < before.overlapAfter - kCut) return std::nullopt;
    char text[128];
    std::snprintf(text, sizeof text, "the matching of the frame before: overlap %.3f, there %.3f",
                  now_.overlap, before.overlapAfter);
    now_.notes.push_back(text);
    for (const Round& round : kFollowRounds) {
      if (progress_.cancelled()) throw Cancelled();
      progress_.report("match", 0.5);
      refine(round);
    }
    finish();
    return std::move(result_);
  }

  Agreement quickAgreement() {
    quick_ = true;
    start();
    for (const Round& round : kQuickRounds) refine(round);
    return {result_.overlapBefore, now_.overlap, strain()};
  }

 private:
  /// What the rounds change.
  struct State {
    Displacements map;
    Displacements base;                      ///< what the rounds' fields are added to
    std::vector<Correspondence> limbPoints;  ///< where limbs are followed
    std::vector<MiddleGuess> guesses;        ///< then, per object
    double overlap = 0;
    double bonus = 0;  ///< what the overlap does not show
    Notes notes;

    double value() const { return overlap + bonus; }
  };

  /// Goes on from a map that nearly holds.
  void startFrom(const Displacements& map, const Displacements& base) {
    now_.base = continued(base);
    now_.map = resampled(map, latticeOf(kFollowRounds[0].spacing));
    removeFolds(now_.map);
    for (size_t k = 0; k < objects_; ++k) now_.guesses.emplace_back(now_.map.lattice, now_.map.of[k]);
    result_.overlapBefore = now_.overlap = overlapOf(now_.map);
  }

  void start() {
    measureObjects();
    sliceObjects();
    startFromContours();
    startFromFeatures();
  }

  void measureObjects() {
    samples_.resize(objects_);
    area_.resize(objects_);
    std::vector<openvdb::BBoxd> boxes(objects_);
    tbb::parallel_for(size_t(0), objects_, [&](size_t k) {
      samples_[k] = chartSamples(*fields_[k], k, area_[k]);
      for (const Vec3d& p : samples_[k].position) boxes[k].expand(p);
    });
    for (InnerSurface& surface : inner_) {
      surface.samples.resize(objects_), surface.area.resize(objects_);
      tbb::parallel_for(size_t(0), objects_, [&](size_t k) {
        if (surface.fields[k]) surface.samples[k] = chartSamples(*surface.fields[k], k, surface.area[k]);
      });
    }
    chartBoxes_ = boxes;
    for (const auto& b : boxes) box_.expand(b);
    const Vec3d e = box_.extents();
    size_ = std::cbrt(e[0] * e[1] * e[2]);
    margin_ = Vec3d(0.3 * size_);
  }

  OrientedPoints chartSamples(const DistanceField& field, size_t k, double& area) const {
    OrientedPoints result;
    double total = 0;
    for (const SurfaceSample& s : field.samples()) {
      const Vec3d z = charts_[k].toChart(s.position);
      result.position.push_back(z);
      result.normal.push_back(charts_[k].normalToChart(z, s.normal));
      result.mass.push_back(s.area);
      total += s.area;
    }
    for (double& m : result.mass) m /= total;
    area = total / (charts_[k].meanScale() * charts_[k].meanScale());
    return result;
  }

  /// About `count` of an object's samples, one of every bin, so that a sample more or less at one place does
  /// not change the choice everywhere else.
  OrientedPoints thinned(const OrientedPoints& all, double area, int count) const {
    if (int(all.position.size()) <= count) return all;
    const double cell = 1.3 * std::sqrt(area / count);
    std::map<SurfaceBin, size_t> bins;
    OrientedPoints result;
    for (size_t i = 0; i < all.position.size(); ++i) {
      const Vec3d& n = all.normal[i];
      const SurfaceBin bin = surfaceBin(all.position[i], n, box_.min(), cell);
      const auto [it, fresh] = bins.emplace(bin, result.position.size());
      if (fresh) {
        result.position.push_back(all.position[i]), result.normal.push_back(n),
            result.mass.push_back(all.mass[i]);
        continue;
      }
      // The sample nearest the middle of the bin's cube stands for the bin: a mean would leave the surface.
      const Vec3d middle = box_.min() + cell * (Vec3d(bin[2], bin[1], bin[0]) + Vec3d(0.5));
      const size_t at = it->second;
      if ((all.position[i] - middle).lengthSqr() < (result.position[at] - middle).lengthSqr())
        result.position[at] = all.position[i], result.normal[at] = n;
      result.mass[at] += all.mass[i];
    }
    return result;
  }

  void sliceObjects() {
    progress_.report("slice", 0.05);
    result_.planes = placeSlices(chartBoxes_, options_.slices);
    result_.stacks.resize(objects_);
    place_.assign(objects_, result_.planes.z0);
    if (!quick_) {
      const AlongSpine along = matchAlongSpine(fields_, charts_, result_.planes);
      char text[128];
      std::snprintf(text, sizeof text, "slices at equal places overlap %.3f, matched along the spine %.3f",
                    along.before, along.after);
      now_.notes.push_back(text);
      place_ = along.place;
    }
    for (size_t k = 0; k < objects_; ++k) {
      SlicePlanes own = result_.planes;
      own.z0 = place_[k];
      const std::vector<SliceImage> images = sampleSlices(*fields_[k], charts_[k], own);
      result_.stacks[k].resize(images.size());
      tbb::parallel_for(size_t(0), images.size(),
                        [&](size_t i) { result_.stacks[k][i] = traceContours(images[i], result_.planes); });
    }
  }

  Lattice latticeOf(double spacing) const {
    return Lattice::over({box_.min() - margin_, box_.max() + margin_}, spacing * size_);
  }

  /// Displacements on a lattice that covers the objects as they are now: its own nodes as far as they go, so
  /// that frame after frame blurs nothing, and beyond them what its outermost nodes say.
  Displacements continued(const Displacements& before) const {
    const Lattice& old = before.lattice;
    const openvdb::Coord low = openvdb::Coord::floor((box_.min() - margin_ - old.origin) / old.spacing);
    const openvdb::Coord high = openvdb::Coord::ceil((box_.max() + margin_ - old.origin) / old.spacing);
    const Lattice lattice{old.position(low[0], low[1], low[2]), old.spacing, high - low + openvdb::Coord(1)};
    Displacements result{lattice, std::vector<VectorField>(objects_, VectorField(lattice.count()))};
    for (int z = 0; z < lattice.size[2]; ++z)
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int x = 0; x < lattice.size[0]; ++x) {
          openvdb::Coord from = low + openvdb::Coord(x, y, z);
          from.maxComponent(openvdb::Coord(0));
          from.minComponent(old.size - openvdb::Coord(1));
          for (size_t k = 0; k < objects_; ++k)
            result.of[k][lattice.index(x, y, z)] = before.of[k][old.index(from[0], from[1], from[2])];
        }
    return result;
  }

  void startFromContours() {
    progress_.report("match contours", 0.1);
    const BaseWarp base = makeBaseWarp(result_.stacks, result_.planes, place_);
    const Lattice lattice = latticeOf(0.08);
    Displacements none{lattice,
                       std::vector<VectorField>(objects_, VectorField(lattice.count(), openvdb::Vec3s(0.f)))};
    result_.overlapBefore = now_.overlap = overlapOf(none);
    now_.map = none;
    now_.base = none;
    Displacements affine = baseDisplacements(base, lattice, box_);
    removeFolds(affine);
    if (takeAsFarAsBetter(affine, 0, kClearGain, "per-slice affine") > 0) now_.base = now_.map;
    result_.pairs = matchContours(result_.stacks, base);
    const std::vector<Correspondence> points =
        pairCorrespondences(result_.pairs, result_.stacks, base, std::max(16, ofEach(options_.samples / 4)));
    if (points.empty()) return;
    takeAsFarAsBetter(fit(points, latticeOf(0.12), 4), 0, kClearGain, "contour pairs");
  }

  /// Limbs are matched as wholes: a leg meets the leg that leaves the body at the same place, however far it
  /// has swung. Returns the state that follows them where that wins beyond doubt, or all those that may turn
  /// out best.
  std::vector<State> withLimbs() {
    const std::vector<std::vector<PlacedLimb>> limbs = placedLimbs(fields_, charts_, now_.map);
    std::vector<Correspondence> matched, all;
    int matches = 0, grown = 0;
    for (const LimbGroup& group : groupLimbs(limbs, fields_, charts_, now_.map, size_)) {
      if (isPrescribed(group)) continue;
      const std::vector<Correspondence> points = limbPoints(group.limb);
      all.insert(all.end(), points.begin(), points.end());
      ++(group.grows ? grown : matches);
      if (!group.grows) matched.insert(matched.end(), points.begin(), points.end());
    }
    std::string found;
    for (const auto& list : limbs) found += (found.empty() ? "" : " and ") + std::to_string(list.size());
    now_.notes.push_back("limbs: " + found + " found, " + std::to_string(matches) + " matched, " +
                         std::to_string(grown) + " to grow out of the body");
    if (all.empty()) return {now_};
    for (auto* points : {&matched, &all})
      points->insert(points->end(), features_.lines.begin(), features_.lines.end());
    const double without = tried(now_).overlap;
    if (1 + (grown > 0 ? kGrownBonus : 0) <= without + kWorthTrying) return {now_};  // no overlap is above 1
    std::vector<std::vector<PlacedLimb>> moving = limbs;
    for (size_t k = 0; k < objects_; ++k)
      moving[k].insert(moving[k].end(), features_.limbs[k].begin(), features_.limbs[k].end());
    const std::vector<Vec3d> still = stillPoints(moving);
    double most = without + kNoDoubt;
    std::vector<State> candidates{now_};
    Notes notes;
    const auto consider = [&](const std::vector<Correspondence>& points, double bonus, const char* name) {
      State state = following(now_, points, still);
      state.bonus = bonus;
      const State after = tried(state);
      char text[128];
      std::snprintf(text, sizeof text, "%s: overlap %.3f after a quick matching, else %.3f", name,
                    after.overlap, without);
      notes.push_back(text);
      if (after.value() > most + kClearGain) {
        most = after.value();
        candidates = {std::move(state)};
      } else if (most == without + kNoDoubt && after.value() > without + kWorthTrying) {
        candidates.push_back(std::move(state));
      }
    };
    if (matches > 0) consider(matched, 0, "matched limbs followed");
    if (grown > 0) consider(all, kGrownBonus, "all limbs followed");
    for (State& state : candidates) state.notes.insert(state.notes.end(), notes.begin(), notes.end());
    return candidates;
  }

  /// Whether a user's line says where a limb goes.
  bool isPrescribed(const LimbGroup& group) const {
    for (size_t k = 0; k < objects_; ++k)
      if (isPrescribedBy(group.limb[k], features_.limbs[k])) return true;
    return false;
  }

  /// The state with a map that follows limbs.
  State following(State state, const std::vector<Correspondence>& points,
                  const std::vector<Vec3d>& still) const {
    state.map = flowed(state.map, points, still, kFlowSpacing * size_, latticeOf(kFlowLattice));
    removeFolds(state.map);
    state.overlap = overlapOf(state.map);
    state.base = state.map;
    state.limbPoints = points;
    state.guesses.clear();
    for (size_t k = 0; k < objects_; ++k) state.guesses.emplace_back(state.map.lattice, state.map.of[k]);
    return state;
  }

  /// The state after a quick matching from there.
  State tried(State state) {
    State before = std::exchange(now_, std::move(state));
    for (const Round& round : kQuickRounds) refine(round);
    return std::exchange(now_, std::move(before));
  }

  /// Surface points well away from all limbs, middle space: the body, which does not swing with them.
  std::vector<Vec3d> stillPoints(const std::vector<std::vector<PlacedLimb>>& limbs) const {
    std::vector<Vec3d> still;
    for (size_t k = 0; k < objects_; ++k) {
      const MiddleSamples samples = middleSamples(k, thinned(samples_[k], area_[k], ofEach(kStillSamples)));
      for (size_t i = 0; i < samples.own.size(); ++i) {
        bool away = true;
        for (const PlacedLimb& limb : limbs[k])
          for (size_t n = 0; n < limb.chart.size() && away; ++n)
            away = (limb.chart[n] - samples.own[i]).length() > kStillReach * limb.radius[n] + 0.03 * size_;
        if (away) still.push_back(samples.points.position[i]);
      }
    }
    return still;
  }

  bool toMiddleSpace(size_t k, const Vec3d& a, Vec3d& s) const {
    s = now_.guesses.empty() ? a - now_.map.at(k, a) : now_.guesses[k].near(a);
    return toMiddle(now_.map, k, a, s);
  }

  /// Takes a map to the degree to which the warped objects overlap better than before: not at all where they
  /// do not gain more than `nothing`, wholly from a gain of `all`.
  double takeAsFarAsBetter(const Displacements& map, double nothing, double all, const char* name) {
    const double overlap = overlapOf(map);
    const double share = smoothstep(overlap - now_.overlap, nothing, all);
    char text[128];
    std::snprintf(text, sizeof text, "%s: overlap %.3f, taken to %.0f %%", name, overlap, 100 * share);
    now_.notes.push_back(text);
    if (share == 0) return 0;
    if (share == 1) {
      now_.map = map;
      now_.overlap = overlap;
      return 1;
    }
    Displacements blended = resampled(now_.map, map.lattice);
    for (size_t k = 0; k < objects_; ++k)
      for (size_t i = 0; i < map.lattice.count(); ++i)
        blended.of[k][i] += float(share) * (map.of[k][i] - blended.of[k][i]);
    removeFolds(blended);
    now_.map = std::move(blended);
    now_.overlap = overlapOf(now_.map);
    return share;
  }

  /// What is known for certain comes before what is found.
  void startFromFeatures() {
    if (options_.features.empty()) return;
    // A quick look does not follow lines.
    if (!features_.lines.empty() && !quick_)
      now_ = following(now_, features_.lines, stillPoints(features_.limbs));
    if (!features_.marks.empty()) now_.map = fit(now_.limbPoints, latticeOf(kMarkSpacing), kMarkStiffness);
    now_.overlap = overlapOf(now_.map);
    char text[96];
    std::snprintf(text, sizeof text, "%zu features: overlap %.3f", options_.features.size(), now_.overlap);
    now_.notes.push_back(text);
  }

  /// The smooth fold-free map that meets the correspondences and the marks, as displacement on top of the
  /// base warp.
  Displacements fit(std::vector<Correspondence> points, const Lattice& lattice, double stiffness) const {
    points.insert(points.end(), features_.marks.begin(), features_.marks.end());
    const Displacements base = resampled(now_.base, lattice);
    Displacements start = resampled(now_.map, lattice);
    for (size_t k = 0; k < objects_; ++k)
      for (size_t i = 0; i < lattice.count(); ++i) start.of[k][i] -= base.of[k][i];
    Sites sites;
    sites.value.resize(objects_);
    for (const Correspondence& c : points) {
      const Vec3d& s = c.middle;
      sites.position.push_back(s);
      sites.weight.push_back(c.weight);
      for (size_t k = 0; k < objects_; ++k) sites.value[k].push_back(c.at[k] - s - now_.base.at(k, s));
    }
    // As many samples a node whatever the counts: the stiffness then means the same for all rounds.
    Displacements map = fitFields(lattice, sites, stiffness, start);
    const bool finer = now_.base.lattice.spacing < lattice.spacing;
    if (finer) map = resampled(map, now_.base.lattice);
    const Displacements& under = finer ? now_.base : base;
    for (size_t k = 0; k < objects_; ++k)
      for (size_t i = 0; i < map.lattice.count(); ++i) map.of[k][i] += under.of[k][i];
    removeFolds(map);
    return map;
  }

  /// Samples of an object, in the middle space.
  struct MiddleSamples {
    OrientedPoints points;
    std::vector<Vec3d> own;  ///< chart coordinates
  };

  MiddleSamples middleSamples(size_t k, const OrientedPoints& all) const {
    const size_t n = all.position.size();
    std::vector<Vec3d> middle(n);
    std::vector<char> found(n);
    tbb::parallel_for(size_t(0), n,
                      [&](size_t i) { found[i] = toMiddleSpace(k, all.position[i], middle[i]); });
    MiddleSamples result;
    double total = 0;
    for (size_t i = 0; i < n; ++i) {
      if (!found[i]) continue;
      result.points.position.push_back(middle[i]);
      result.points.normal.push_back(all.normal[i]);
      result.points.mass.push_back(all.mass[i]);
      result.own.push_back(all.position[i]);
      total += all.mass[i];
    }
    for (double& m : result.points.mass) m /= total;
    return result;
  }

  /// Samples are counted for two objects; more share them, so that the work grows no faster than their
  /// number.
  int ofEach(int samples) const { return std::max(samples * 2 / int(std::max<size_t>(objects_, 2)), 1); }

  void refine(const Round& round) {
    std::vector<MiddleSamples> samples(objects_);
    for (size_t k = 0; k < objects_; ++k)
      samples[k] = middleSamples(k, thinned(samples_[k], area_[k], ofEach(round.samples)));
    std::vector<Correspondence> points =
        round.soft ? softCorrespondences(samples, round) : closestCorrespondences(fields_, samples, round);
    if (!round.soft) addInner(round, points);
    if (points.empty()) return;
    points.insert(points.end(), now_.limbPoints.begin(), now_.limbPoints.end());
    const Lattice lattice = latticeOf(round.spacing);
    const double density = double(points.size()) / 2000;
    char name[64];
    std::snprintf(name, sizeof name, "%s %.3f (%zu points)", round.soft ? "soft match" : "closest points",
                  round.reach, points.size());
    // Closest points nearly always help, and the last rounds by little each: they are only refused where they
    // harm.
    const Displacements map = fit(points, lattice, round.stiffness * density);
    // Of many objects they draw every one to the nearest of all the others.
    if (round.soft || objects_ > 2)
      takeAsFarAsBetter(map, 0, kClearGain, name);
    else
      takeAsFarAsBetter(map, -2 * kClearGain, -kClearGain, name);
  }

  std::vector<Correspondence> softCorrespondences(const std::vector<MiddleSamples>& samples,
                                                  const Round& round) const {
    // targets[j][i].at: of object j's sample i on every object.
    std::vector<std::vector<Correspondence>> all(objects_);
    for (size_t j = 0; j < objects_; ++j)
      for (size_t i = 0; i < samples[j].own.size(); ++i) {
        Correspondence c;
        const Vec3d& s = samples[j].points.position[i];
        for (size_t k = 0; k < objects_; ++k)
          c.at.push_back(k == j ? samples[j].own[i] : s + now_.map.at(k, s));
        c.middle = s;
        c.weight = 1;
        all[j].push_back(std::move(c));
      }
    // Each target counts as far as it is trusted against the sample's best.
    std::vector<std::vector<std::vector<float>>> trust(objects_);
    std::vector<std::vector<std::vector<Vec3d>>> target(objects_);
    for (size_t j = 0; j < objects_; ++j) {
      trust[j].assign(objects_, std::vector<float>(all[j].size(), 0.f));
      target[j].resize(objects_);
    }
    const auto take = [&](size_t from, size_t to, const SoftTargets& targets) {
      target[from][to] = targets.position;
      trust[from][to].assign(targets.trust.begin(), targets.trust.end());
    };
    for (size_t j = 0; j < objects_; ++j)
      for (size_t k = j + 1; k < objects_; ++k) {
        const SoftMatch m = softMatch(samples[j].points, samples[k].points, round.reach * size_);
        take(j, k, m.aToB);
        take(k, j, m.bToA);
      }
    for (size_t j = 0; j < objects_; ++j)
      for (size_t i = 0; i < all[j].size(); ++i) {
        Correspondence& c = all[j][i];
        const Vec3d& s = samples[j].points.position[i];
        float best = 0;
        for (size_t k = 0; k < objects_; ++k) best = std::max(best, k == j ? 0.f : trust[j][k][i]);
        for (size_t k = 0; k < objects_; ++k) {
          if (k == j || !(trust[j][k][i] > 0)) continue;
          const Vec3d t = s + double(trust[j][k][i] / best) * (target[j][k][i] - s);
          c.at[k] = t + now_.map.at(k, t);
          c.middle += (t - s) / double(objects_);
        }
        c.weight = std::min(c.weight, best);
      }
    std::vector<Correspondence> points;
    for (const auto& list : all)
      for (const Correspondence& c : list)
        if (c.weight > 0.05f) points.push_back(c);
    return points;
  }

  /// Points of the inner surfaces, as densely as those of the shape, each drawn to its like alone.
  void addInner(const Round& round, std::vector<Correspondence>& points) const {
    for (const InnerSurface& surface : inner_) {
      std::vector<MiddleSamples> samples(objects_);
      for (size_t k = 0; k < objects_; ++k) {
        if (!surface.fields[k]) continue;
        const int count = std::max(ofEach(kLeastInner),
                                   int(ofEach(round.samples) * std::min(surface.area[k] / area_[k], 1.0)));
        samples[k] = middleSamples(k, thinned(surface.samples[k], surface.area[k], count));
      }
      const std::vector<Correspondence> found = closestCorrespondences(surface.fields, samples, round);
      points.insert(points.end(), found.begin(), found.end());
    }
  }

  std::vector<Correspondence> closestCorrespondences(const Fields& fields,
                                                     const std::vector<MiddleSamples>& samples,
                                                     const Round& round) const {
    std::vector<Correspondence> points;
    for (size_t j = 0; j < objects_; ++j) {
      std::vector<Correspondence> found(samples[j].own.size());
      tbb::parallel_for(size_t(0), found.size(), [&](size_t i) {
        Correspondence& c = found[i];
        const Vec3d& s = samples[j].points.position[i];
        c.weight = 0;
        c.middle = s;
        for (size_t k = 0; k < objects_; ++k) {
          const Vec3d before = k == j ? samples[j].own[i] : s + now_.map.at(k, s);
          Vec3d at = before;
          if (k != j && fields[k])
            c.weight = std::max(
                c.weight, projectOnto(*fields[k], k, samples[j].points.normal[i], round.reach * size_, at));
          c.at.push_back(at);
          c.middle += (at - before) / double(objects_);
        }
      });
      for (Correspondence& c : found)
        if (c.weight > 0) points.push_back(std::move(c));
    }
    return points;
  }

  /// Moves a chart point onto a surface of object k and returns how far that is to be trusted: wholly where
  /// the surface is near and faces the same way, not at all where it is `reach` away or faces elsewhere.
  float projectOnto(const DistanceField& field, size_t k, const Vec3d& normal, double reach,
                    Vec3d& at) const {
    const Vec3d surface = field.closest(charts_[k].toWorld(at));
    const Vec3d projected = charts_[k].toChart(surface);
    const double near = 1 - (projected - at).length() / reach;
    const double facing =
        (charts_[k].normalToChart(projected, field.gradient(surface)).dot(normal) - 0.1) / 0.4;
    const double trust = std::min(std::max(4 * near, 0.0), 1.0) * std::min(std::max(facing, 0.0), 1.0);
    if (trust > 0) at = projected;
    return float(trust);
  }

  /// Soft intersection over union of the warped objects in the middle space, of all their pairs.
  double overlapOf(const Displacements& map) const {
    const Lattice lattice = latticeOf(quick_ ? 0.05 : 0.035);
    std::vector<double> both(lattice.size[2], 0), either(lattice.size[2], 0);
    std::vector<double> unit;
    for (size_t k = 0; k < objects_; ++k) unit.push_back(1 / (charts_[k].meanScale() * lattice.spacing));
    std::vector<DistanceField::Sampler> samplers;
    for (size_t k = 0; k < objects_; ++k) samplers.emplace_back(*fields_[k]);
    std::vector<std::vector<double>> insides(lattice.size[2], std::vector<double>(objects_));
    tbb::parallel_for(0, int(lattice.size[2]), [&](int iz) {
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int x = 0; x < lattice.size[0]; ++x) {
          const Vec3d s = lattice.position(x, y, iz);
          std::vector<double>& inside = insides[size_t(iz)];
          for (size_t k = 0; k < objects_; ++k) {
            const Vec3d z = s + map.at(k, s);
            const double d = samplers[k].coarse(fields_[k]->relative(charts_[k].toWorld(z))) * unit[k];
            inside[k] = charts_[k].spread(z) > 0 ? std::min(std::max(0.5 - d, 0.0), 1.0) : 0;
          }
          // Of the pairs with the n-th smallest, it is the smaller one in all with larger ones.
          std::sort(inside.begin(), inside.end());
          for (size_t n = 0; n < objects_; ++n)
            both[size_t(iz)] += inside[n] * double(objects_ - 1 - n),
                either[size_t(iz)] += inside[n] * double(n);
        }
    });
    double sumBoth = 0, sumEither = 0;
    for (size_t z = 0; z < both.size(); ++z) sumBoth += both[z], sumEither += either[z];
    return sumEither > 0 ? sumBoth / sumEither : 0;
  }

  /// Root mean square of the displacements' derivatives inside the objects.
  double strain() const {
    const Displacements& map = now_.map;
    const Lattice& lattice = map.lattice;
    const size_t step[3] = {1, size_t(lattice.size[0]), size_t(lattice.size[0]) * lattice.size[1]};
    std::vector<double> sum(lattice.size[2], 0), count(lattice.size[2], 0);
    tbb::parallel_for(1, int(lattice.size[2]) - 1, [&](int z) {
      for (int y = 1; y + 1 < lattice.size[1]; ++y)
        for (int x = 1; x + 1 < lattice.size[0]; ++x) {
          const size_t i = lattice.index(x, y, z);
          const Vec3d s = lattice.position(x, y, z);
          bool any = false;
          for (size_t k = 0; k < objects_ && !any; ++k)
            any = fields_[k]->coarse(charts_[k].toWorld(s + Vec3d(map.of[k][i]))) < 0;
          if (!any) continue;
          double squares = 0;
          for (const VectorField& field : map.of)
            for (size_t d : step)
              squares += ((field[i + d] - field[i - d]) / (2 * lattice.spacing)).lengthSqr();
          sum[z] += squares / double(objects_), count[z] += 1;
        }
    });
    double total = 0, n = 0;
    for (size_t z = 0; z < sum.size(); ++z) total += sum[z], n += count[z];
    return n > 0 ? std::sqrt(total / n) : 0;
  }

  /// The lattice the frames move: as fine as the eye needs, still free of folds. `last`: nothing is matched
  /// after it.
  void finish(bool last = true) {
    const double longest = std::max({box_.extents()[0], box_.extents()[1], box_.extents()[2]});
    Displacements fine =
        resampled(now_.map, Lattice::over({box_.min() - margin_, box_.max() + margin_}, longest / 72));
    removeFolds(fine, 0.1);
    result_.overlapAfter = overlapOf(fine);
    if (last)
      for (const Note& warning : contradictions(options_.features, charts_, fine, size_))
        now_.notes.push_back(warning);
    result_.map = std::move(fine), result_.base = std::move(now_.base), result_.notes = std::move(now_.notes);
  }

  const Fields& fields_;
  const std::vector<Chart>& charts_;
  const MorphOptions& options_;
  Progress& progress_;
  size_t objects_;
  struct InnerSurface {
    Fields fields;
    std::vector<OrientedPoints> samples;
    std::vector<double> area;
  };
  std::vector<InnerSurface> inner_;
  FeaturePoints features_;
  std::vector<OrientedPoints> samples_;  ///< per object: its surface in chart coordinates
  std::vector<double> area_;             ///< per object, chart units
  std::vector<openvdb::BBoxd> chartBoxes_;
  std::vector<std::vector<double>> place_;  ///< per object and slice: z0
  openvdb::BBoxd box_;                      ///< of all objects, chart space
  Vec3d margin_;
  double size_ = 1;  ///< cube root of the box's volume
  State now_;
  bool quick_ = false;
  Registration result_;
};

}  // namespace

std::optional<Registration> followRegistration(const Registration& before, const Fields& fields,
                                               const std::vector<Fields>& inner, const Frames& frames,
                                               const MorphOptions& options, Progress& progress) {
  return Registrar(fields, inner, frames, options, progress).follow(before);
}

Registration startRegistration(const Fields& fields, const Frames& frames, const MorphOptions& options,
                               Progress& progress) {
  return Registrar(fields, {}, frames, options, progress).started();
}

Registration refineRegistration(Registration made, const Fields& fields, const std::vector<Fields>& inner,
                                const Frames& frames, const MorphOptions& options, Progress& progress) {
  return Registrar(fields, inner, frames, options, progress).refined(std::move(made));
}

Agreement quickAgreement(const Fields& fields, const Frames& frames, const MorphOptions& options,
                         Progress& progress) {
  return Registrar(fields, {}, frames, options, progress).quickAgreement();
}

Registration registerObjects(const Fields& fields, const std::vector<Fields>& inner, const Frames& frames,
                             const MorphOptions& options, Progress& progress, bool last) {
  return Registrar(fields, inner, frames, options, progress).run(last);
}

}  // namespace slicemorph
