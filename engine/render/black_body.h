#pragma once

#include "engine/render/film.h"

namespace slicemorph {

/// The colour of a black body, 500 to 20000 kelvin: linear sRGB (Rec. 709), of luminance 1, beyond the gamut
/// cut off at 0. Planck's law seen by the CIE 1931 observer as fitted in [WSS13].
Colour blackBody(double kelvin);

}  // namespace slicemorph
