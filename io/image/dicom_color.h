#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace slicemorph {

/// sRGB as CIE L*a*b* of white D50, in DICOM's three 16-bit numbers (PS3.3 C.10.7.1.1).
std::vector<std::uint16_t> dicomLabOf(const std::array<std::uint8_t, 3>& color);
/// The way back; what sRGB cannot show becomes the nearest that it can, channel by channel. `stored`: three numbers.
std::array<std::uint8_t, 3> colorOfDicomLab(const std::vector<double>& stored);

}  // namespace slicemorph
