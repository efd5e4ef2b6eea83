#include "tools/job/grid_methods.h"

#include "engine/peers/bounded_blend.h"
#include "engine/peers/fourier.h"
#include "engine/peers/minkowski.h"
#include "engine/peers/morphology.h"
#include "engine/peers/variational.h"
#include "engine/peers/wavelet.h"
#include "tools/job/plan_parts.h"

namespace slicemorph {
namespace {

MethodPlan planMorphology(const MethodTask& task) {
  return planOf(
      std::make_shared<const MorphologyMorph>(gridsOf(task), commonVoxelSize(task), &task.progress));
}

MethodPlan planMinkowski(const MethodTask& task) {
  MinkowskiOptions options;
  options.directions = int(task.parameter("directions"));
  return planOf(
      std::make_shared<const MinkowskiMorph>(gridsOf(task), commonVoxelSize(task), options, &task.progress));
}

/// `method`: for messages.
MethodPlan planScheduled(const MethodTask& task, std::unique_ptr<LatticeTransform> transform,
                         const char* method) {
  return planOf(std::make_shared<const ScheduledDissolve>(gridsOf(task), commonVoxelSize(task),
                                                          task.parameter("fade"), std::move(transform),
                                                          method, &task.progress));
}

MethodPlan planFourier(const MethodTask& task) {
  return planScheduled(task, cosineTransform(task.parameter("cutoff")), "fourier");
}

MethodPlan planWavelet(const MethodTask& task) {
  return planScheduled(task, haarTransform(int(task.parameter("levels"))), "wavelet");
}

MethodPlan planBoundedBlend(const MethodTask& task) {
  BoundedBlendOptions options;
  options.gap = task.parameter("gap"), options.stay = task.parameter("stay");
  options.strength = task.parameter("strength"), options.width = task.parameter("width");
  return planOf(
      std::make_shared<const BoundedBlend>(gridsOf(task), commonVoxelSize(task), options, &task.progress));
}

MethodPlan planVariational(const MethodTask& task) {
  VariationalOptions options;
  options.points = int(task.parameter("points")), options.apart = task.parameter("apart");
  return planOf(std::make_shared<const VariationalMorph>(gridsOf(task), commonVoxelSize(task), options,
                                                         &task.progress));
}

}  // namespace

void addGridMethods(std::vector<MorphMethod>& table) {
  const MethodTraits surface;
  table.push_back(
      {"morphology",
       "dilates and erodes what objects have beside their common part (2.1 billion voxels at most)", surface,
       planMorphology});
  table.push_back({"minkowski",
                   "adds weighted objects point by point (others than convex ones in a box of 2.1 million "
                   "voxels at most)",
                   surface,
                   planMinkowski,
                   {{"directions", "directions per right angle in which convex objects are measured", "",
                     double(MinkowskiOptions().directions), 4, 256, true}}});
  const MethodParameter fade{
      "fade", "share of the way after which the finest parts of the first input are gone",
      "",     FourierOptions().fade,
      0,      1};
  table.push_back({"fourier",
                   "blends distances by frequency: detail fades, shape changes, detail comes (134 million "
                   "voxels at most)",
                   surface,
                   planFourier,
                   {fade,
                    {"cutoff", "frequency from which on parts are the finest",
                     "half waves along the longest side", FourierOptions().cutoff, 1, 1e4}}});
  table.push_back(
      {"wavelet",
       "blends distances by levels of a Haar wavelet on the same schedule, in blocks (as many voxels)",
       surface,
       planWavelet,
       {fade, {"levels", "levels of the wavelet", "", double(WaveletOptions().levels), 1, 8, true}}});
  const BoundedBlendOptions bounded;
  table.push_back(
      {"bounded-blend",
       "blends unions of cylinders in space and time within a bounding object (as many voxels as morphology)",
       surface,
       planBoundedBlend,
       {{"gap", "length of the way through time", "diagonals of the inputs' box", bounded.gap, 0.01, 10},
        {"stay", "share of the way for which each input lasts by itself", "", bounded.stay, 0.01, 0.49},
        {"strength", "the most that the blend adds", "gaps", bounded.strength, 0, 100},
        {"width", "how far from all inputs the blend is felt", "bounding objects", bounded.width, 0.01,
         100}}});
  const VariationalOptions plate;
  table.push_back({"variational",
                   "takes slices of one smooth function in further dimensions (constraints times voxels: 10 "
                   "billion at most)",
                   surface,
                   planVariational,
                   {{"points", "points on each input's surface through which it passes", "",
                     double(plate.points), 10, 2500, true},
                    {"apart", "how far inputs are from each other in the further dimensions",
                     "half diagonals of the inputs' box", plate.apart, 0.01, 100}}});
}

}  // namespace slicemorph
