#pragma once

#include "engine/render/film.h"

namespace slicemorph {

/// The colour of a black body of 500 to 20000 kelvin: linear sRGB (Rec. 709) of luminance 1; components
/// outside the gamut are clamped to 0. Planck's law as seen by the CIE 1931 observer, fitted in [WSS13].
Colour blackBody(double kelvin);

}  // namespace slicemorph
