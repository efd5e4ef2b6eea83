#include "tools/job/contour_methods.h"

#include "engine/peers/contour_average.h"
#include "engine/peers/cylindrical.h"
#include "engine/peers/feature_warp.h"
#include "engine/peers/radial.h"
#include "engine/peers/slices_plain.h"
#include "tools/job/plan_parts.h"

namespace slicemorph {
namespace {

MethodPlan planRadial(const MethodTask& task) {
  RadialOptions options;
  options.tangent = task.parameter("tangent");
  return planOf(std::make_shared<const RadialMorph>(objectsOf(task), commonVoxelSize(task), options));
}

ContourAverageOptions averageOptions(const MethodTask& task, ContourAverageKind kind) {
  ContourAverageOptions options;
  options.kind = kind;
  options.slices = task.settings.plan.slices;
  options.samples = task.settings.plan.samples;
  return options;
}

MethodPlan planAverage(const MethodTask& task, const ContourAverageOptions& options) {
  return planOf(std::make_shared<const ContourAverage>(objectsOf(task), commonVoxelSize(task),
                                                       task.settings.plan.axis, options));
}

MethodPlan planContourMean(const MethodTask& task) {
  return planAverage(task, averageOptions(task, ContourAverageKind::kMean));
}

MethodPlan planContourMedian(const MethodTask& task) {
  return planAverage(task, averageOptions(task, ContourAverageKind::kMedian));
}

MethodPlan planContourMode(const MethodTask& task) {
  ContourAverageOptions options = averageOptions(task, ContourAverageKind::kMode);
  options.width = task.parameter("width");
  return planAverage(task, options);
}

MethodPlan planPlainSlices(const MethodTask& task) {
  PlainSlicesOptions options;
  options.slices = task.settings.plan.slices;
  options.samples = task.settings.plan.samples;
  return planOf(std::make_shared<const PlainSlices>(objectsOf(task), commonVoxelSize(task), options));
}

MethodPlan planCylindrical(const MethodTask& task) {
  CylindricalOptions options;
  options.cap = task.parameter("cap");
  return planOf(std::make_shared<const CylindricalMorph>(objectsOf(task), commonVoxelSize(task), options));
}

MethodPlan planFeatureWarp(const MethodTask& task) {
  FeatureWarpOptions options;
  options.nearness = task.parameter("nearness");
  return planOf(std::make_shared<const FeatureWarp>(objectsOf(task), commonVoxelSize(task),
                                                    task.settings.plan.features, options));
}

}  // namespace

void addContourMethods(std::vector<MorphMethod>& table) {
  const MethodTraits surface;
  table.push_back(
      {"radial",
       "blends the radii of star-shaped objects",
       surface,
       planRadial,
       {{"tangent", "length of the tangents of Hermite paths along the surfaces' normals; 0: straight paths",
         "mean radii", RadialOptions().tangent, 0, 10}}});
  table.push_back({"contour-mean", "averages contours on parallel slices, matched by their hulls", surface,
                   planContourMean});
  table.push_back({"contour-median", "takes the median of contours so matched", surface, planContourMedian});
  table.push_back({"contour-mode",
                   "takes the mode of contours so matched",
                   surface,
                   planContourMode,
                   {{"width", "points nearer to each other than this count as one value", "mean radii",
                     ContourAverageOptions().width, 0.001, 10}}});
  table.push_back({"slices-plain", "is the slice method as published, matched by rays or angles", surface,
                   planPlainSlices});
  table.push_back({"cylindrical",
                   "blends objects that are star-shaped about an axis, which may bend",
                   surface,
                   planCylindrical,
                   {{"cap", "length of the cap at either end of the axis; 0: the object's mean radius",
                     "halves of the axis", CylindricalOptions().cap, 0, 0.9}}});
  MethodTraits warp;
  warp.features = true;
  table.push_back({"feature-warp",
                   "warps by pairs of features, which it needs, and blends distances",
                   warp,
                   planFeatureWarp,
                   {{"nearness", "added to distances from features, whose weights are their inverse squares",
                     "diagonals of the inputs' box", FeatureWarpOptions().nearness, 1e-6, 1}}});
}

}  // namespace slicemorph
