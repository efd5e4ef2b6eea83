#pragma once

#include "slicemorph/image.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// The two transforms of a NIfTI file as its header has them, in RAS millimetres; code 0: not given.
struct NiftiForms {
  ImageLattice lattice;  ///< where the reader put the voxels
  int sformCode = 0, qformCode = 0;
  double sform[3][4] = {};                    ///< rows of the affine
  double quaternion[3] = {}, offset[3] = {};  ///< b, c, d; place of the first voxel
  double spacing[3] = {}, handedness = 1;     ///< of the qform; -1: its third axis is turned round
};

/// What a file calls one of its labels.
struct LabelName {
  int label = 0;
  std::string name;                                  ///< empty: it has none
  std::optional<std::array<std::uint8_t, 3>> color;  ///< red, green, blue, as sRGB
};

/// What a file says beside lattice and values, and what is written of it says again.
struct ImageHeader {
  double timeStep = 0;    ///< from one volume to the next; 0: not told, or volumes are no times
  bool inSeconds = true;  ///< the unit of `timeStep`; else the file tells none
  std::optional<NiftiForms> forms;
  std::vector<LabelName> labels;
};

}  // namespace slicemorph
