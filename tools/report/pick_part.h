#pragma once

#include "slicemorph/guidance.h"
#include "tools/report/pick_scene.h"

#include <string>
#include <vector>

namespace slicemorph {

/// The words that belong to a scene.
struct PickTexts {
  std::string file;  ///< name that the job file gets where it is saved
  /// The job file but for its features that are points, which may be moved on the page; empty: only these are shown.
  std::string job;
  std::vector<Feature> features = {};              ///< of the job file: points, and what else is only shown
  std::vector<std::vector<Vec3d>> landmarks = {};  ///< each a position per shape; only shown
  std::vector<std::string> notes = {};             ///< sentences
};

/// The part of a page in which a user points at what belongs together, as script elements for pageWith().
std::string pickPart(const PickScene& scene, const PickTexts& texts);

}  // namespace slicemorph
