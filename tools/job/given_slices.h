#pragma once

#include "engine/reconstruct/label_slices.h"
#include "tools/job/reconstruct.h"

#include <string>

namespace slicemorph {

/// The slices that a job takes as given. `labelled`: of the file; `lattice`: of the file. Throws InputError, naming the
/// input and what would be right.
GivenSlices givenSlices(const ReconstructJob& job, const LabelledSlices& labelled,
                        const ImageLattice& lattice);

/// The lattice with `between` more slices between every two.
ImageLattice expandedLattice(const ImageLattice& lattice, int axis, int between);

/// For notes: how many, along which axis, how far apart.
std::string described(const GivenSlices& given);

}  // namespace slicemorph
