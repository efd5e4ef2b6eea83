#pragma once

#include "engine/measure/measure.h"
#include "slicemorph/conventions.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What `slicemorph survey` found: the same objects morphed by every method.
namespace slicemorph {

/// How far a frame is from a shape that it should be.
struct SurveyDistance {
  std::string to;            ///< the shape's name, as typed
  SurfaceDistance distance;  ///< symmetric, world units
  double diagonal = 0;       ///< of the box around that shape, world units
  double percent() const { return 100 * distance.mean / diagonal; }
};

struct SurveyFrame {
  int number = 1;
  double t = 0;
  std::vector<double> weights;   ///< one per input
  ShapeMeasures shape;           ///< all 0 where the frame has no surface
  std::optional<double> change;  ///< to the frame before: volume that is in one alone, world units cubed
  std::optional<double> meanStretch, worstStretch;  ///< of a method that maps surfaces, see FrameStrain
  std::optional<SurveyDistance>
      distance;  ///< of the first and last frame to their inputs, of others to the truth
};

/// Points of a method, see scoreOf(); the fewer the better. What is not part of the score is 0.
struct SurveyScore {
  double ends = 0, parts = 0, size = 0, area = 0, change = 0, truth = 0;
  double points() const { return ends + parts + size + area + change + truth; }
};

/// One method and what it made.
struct SurveyMethod {
  std::string name;                     ///< as --method has it
  bool surface = true;                  ///< it makes one; else only values
  std::string does;                     ///< what it does, after its name: "blends distances point by point"
  std::string refusal;                  ///< why there are no frames, in its own words; empty: there are
  std::string unranked;                 ///< why it has frames and no score; empty: it has one
  std::vector<std::string> notes = {};  ///< sentences
  double seconds = 0, processorSeconds = 0;
  std::int64_t peakBytes = 0;  ///< of its process
  std::vector<SurveyFrame> frames = {};
  std::string sheet = {};  ///< contact sheet, a PNG; empty: nothing is to be seen
  std::optional<SurveyScore> score = {};
};

/// A shape that the morph is compared with.
struct SurveyShape {
  std::string name;  ///< as typed
  ShapeMeasures shape;
  double t = 0;  ///< when the morph should be there
};

struct SurveyResult {
  std::vector<SurveyShape> inputs, truths;
  std::vector<SurveyMethod>
      methods;                     ///< the best first, then those without a score, then those without frames
  std::vector<std::string> notes;  ///< sentences that hold for all methods
  std::string voxels;              ///< "64 voxels along the longest side"
  /// Of the pictures of every sheet, where all are in one row; empty: there are several, and each says its time.
  std::vector<double> sheetTimes;
  std::string truthSheet;  ///< as SurveyMethod::sheet, with the true frames where they belong; empty: none
};

}  // namespace slicemorph
