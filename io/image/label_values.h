#pragma once

#include "slicemorph/image.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// Rounds floating point values that all are whole numbers from 0 on but for 1e-3: labels as programs store them that
/// compute in floating point. Without `asked` only where they then look like labels. A note tells how many were changed.
void takeLabels(Image& image, bool asked, Notes& notes);

}  // namespace slicemorph
