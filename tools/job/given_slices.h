#pragma once

#include "engine/reconstruct/drawn_slices.h"
#include "tools/job/reconstruct.h"

#include <string>

namespace slicemorph {

/// The slices that a job takes as given. `labelled`: of the file; `lattice`: of the file. Throws InputError, naming the
/// input and what would be right.
GivenSlices givenSlices(const ReconstructJob& job, const LabelledSlices& labelled,
                        const ImageLattice& lattice);

/// Whether the job leaves it to the map which slices are given.
bool areFound(const ReconstructJob& job);

/// Of slices that were found: without the empty ones that were not drawn, and the labels with slices of their own.
/// `labelled`, `slices`: of the whole map, along the found axis.
GivenSlices whatWasDrawn(GivenSlices found, const LabelledSlices& labelled, const DrawnSlices& slices);

/// The lattice with `between` more slices between every two.
ImageLattice expandedLattice(const ImageLattice& lattice, int axis, int between);

/// The stack with `between` empty slices between every two.
Image expandedStack(const Image& stack, int axis, int between);

/// For notes: how many, along which axis, how far apart.
std::string described(const GivenSlices& given);
/// What is to be said of the given slices. `labelled`: per slice along the axis, whether it holds a label.
Notes notesOf(const GivenSlices& given, const std::vector<char>& labelled);

}  // namespace slicemorph
