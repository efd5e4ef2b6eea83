#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/note.h"

#include <string>
#include <vector>

namespace slicemorph {

/// A lattice's box with cubic voxels: of the size that was asked for, or as many as were asked for along its
/// longest side.
ImageLattice cubicLattice(const ImageLattice& lattice, const LoadOptions& options);

/// The voxels that the in-betweens of images are put on: those of the first, and as many more around them as
/// the other objects' shapes need; the notes say where that is so.
struct LatticeChoice {
  ImageLattice lattice;
  Notes notes;
};
LatticeChoice latticeAround(const std::vector<LoadedObject>& objects);

/// Throws where the folder of an output is missing or its extension is none that a surface or image can be
/// written to.
void checkOutput(const std::string& path);

}  // namespace slicemorph
