#pragma once

#include "io/mesh/glb_writer.h"
#include "io/usd/usda_text.h"
#include "slicemorph/io/input.h"
#include "slicemorph/io/output.h"
#include "slicemorph/io/vdb_writer.h"
#include "slicemorph/slicemorph.h"
#include "tools/job/job_options.h"
#include "tools/job/key_times.h"
#include "tools/job/landmarks.h"
#include "tools/job/methods.h"
#include "tools/job/picture_options.h"
#include "tools/job/slice_options.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// The content of .exr outputs.
enum class ExrContent { kPicture, kSlices };

/// One frame of a job.
struct FrameJob {
  int number = 1;           ///< in names and metadata; the first one's is --start
  std::optional<double> t;  ///< none for a blend given by weights
  Weights weights;
  std::string path;
  size_t inputFrame = 0;  ///< of inputs that are sequences, from 0
  Weights rate;           ///< change of the weights per second; empty where the job has no speed
  double speed = 1;       ///< of `retime`: file numbers per frame, by which the inputs' own velocities change
  std::string given = {};  ///< of `retime`: the file that the frame is; empty: it is made
  bool wanted = true;      ///< false: --range leaves it out, but what the others depend on counts all frames
};

/// How long a shutter is open before or after its frame at most, in frames (a 360 degree shutter centred on
/// the frame). Velocities are kept as far around shapes as these move in that time.
constexpr double kShutter = 0.5;

/// By how much a velocity that is interpolated between its grid's voxels may be wrong, in voxels of the frame per frame.
/// What a shutter sees is half of it. Chosen: frames 8 and 14 of 24 from a bunny to an armadillo at 256 voxels have .07 on voxels
/// four times as large. See FramesFollowTheirVelocities in tests/engine/rebuild/pullback_test.cpp.
constexpr double kVelocityError = 0.1;

/// The velocity grid of VDB outputs.
struct VelocitySettings {
  std::string name = "vel";  ///< "none": no velocities
  bool perFrame = false;     ///< world units per frame, else per second
  bool add = false;          ///< the inputs' own velocities, morphed, are added
  bool half = false;         ///< half floats, whatever the inputs are
  bool onlyIfNone = false;   ///< none where the inputs have their own

  bool wanted() const { return name != "none"; }
};

/// What `slicemorph morph` is to do; values are checked.
struct MorphSettings {
  std::vector<std::string> inputs;
  HeldInputs held;  ///< those of the inputs that are in memory
  std::string output;
  LoadOptions load;
  MorphOptions plan;
  bool alignGiven = false;        ///< --align was given; else inputs of one simulation keep their directions
  std::string method = "slices";  ///< its name in methods.h
  MethodValues parameters;        ///< those of the method's parameters that were given
  std::vector<FrameJob> frames;   ///< of the whole sequence, whatever --range asks for
  WeightCourse course;            ///< of the frames; without keys where the weights are given
  double framesPerSecond = 24;
  std::vector<std::string> grids;  ///< of the output; empty: all
  bool conserve = false;
  VelocitySettings velocity;
  std::vector<std::string> reports;  ///< .json, .csv, .html
  std::string sliceFolder;           ///< empty: none
  std::string planFile;              ///< by which frames are made; of sequences a pattern; empty: none
  std::string like;                  ///< image whose voxels in-between images get; empty: the first input's
  GlbSpace glb;                      ///< of .glb outputs
  UsdaStage stage;                   ///< of .usda outputs
  std::string usdVolume;  ///< .usda that shows the VDB files which `output` names; empty: none is wanted
  ExrContent exrContent = ExrContent::kPicture;
  PictureOptions picture;  ///< of .exr and .png outputs
  SliceOptions exrSlices;  ///< of .exr outputs that hold slices
  std::vector<std::pair<std::string, std::string>> pictureOptions,
      sliceOptions;                      ///< those that were given, with values
  std::vector<Landmark> landmarks;       ///< also among the plan's features
  std::vector<Landmark> checkLandmarks;  ///< only measured, not used
  bool quiet = false, resume = false;
  bool eachAlone = false;  ///< plans of sequences do not follow each other
  JobOptions options;      ///< as typed, for code that needs no more
  std::string jobText;     ///< as a job file but for features that are points; empty: no file can say it
  std::vector<std::pair<std::string, std::string>> frameSettings;  ///< all options that frames depend on

  /// What the method can do.
  const MethodTraits& can() const { return methodNamed(method).can; }
  /// The frames that are to be made.
  std::vector<FrameJob> wantedFrames() const;
  /// An input as it is described by its name, or by itself where it is in memory.
  InputSpec input(size_t k) const;
  bool allImages() const;
  /// Whether an input is a sequence, so that one plan does not serve all frames.
  bool moving() const;
  /// Every frame is written as a picture or as EXR slices.
  bool toFrameImages() const;
  bool toPictures() const { return toFrameImages() && exrContent == ExrContent::kPicture; }
  /// The output shows all grids of a frame, not only its surface: a .vdb, slices, a picture.
  bool holdsGrids() const { return isGridOutput(output) || toFrameImages(); }
  /// All frames go into one .glb file.
  bool oneGlb() const;
  /// All frames go into one .usda file, as the samples of one mesh.
  bool oneUsda() const;
  /// All frames go into one NIfTI file, as its volumes.
  bool oneImage() const;
  bool oneFile() const { return oneGlb() || oneUsda() || oneImage(); }
};

}  // namespace slicemorph
