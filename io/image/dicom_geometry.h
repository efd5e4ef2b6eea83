#pragma once

#include "io/image/dicom_file.h"

namespace slicemorph {

/// The directions along a row and down a column of ImageOrientationPatient; none where these are no unit vectors at right
/// angles.
std::optional<std::array<Vec3d, 2>> dicomAxes(const std::vector<double>& orientation);
/// Of directions that are no such the nearest that are; none where they do not span a plane.
std::optional<std::array<Vec3d, 2>> nearestAxes(const std::vector<double>& orientation);
/// A position, millimetres; none where there are not three numbers, or they are beyond all bodies.
std::optional<Vec3d> dicomPlace(const std::vector<double>& position);
/// The distances from pixel to pixel along a row and down a column; none where PixelSpacing is no such.
std::optional<std::array<double, 2>> dicomPixel(const std::vector<double>& spacing);

/// A number with up to six digits.
std::string shortText(double value);

/// Places frames of a file that has one position at most: dose grids, secondary captures, nuclear medicine, films. The
/// first frame holds what the file says of all. Marks those of several volumes; sets `uncertain` and `assumed`.
void placeDicomFrames(const DicomElements& data, DicomFile& file);

}  // namespace slicemorph
