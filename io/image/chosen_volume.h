#pragma once

#include "io/image/raw_values.h"
#include "io/image/volume_reader.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

#include <cstddef>
#include <functional>
#include <string>

namespace slicemorph {

/// No volume is chosen of a file: the first is taken, or the luminance of its colours.
constexpr int kNoVolume = -1;

/// The number of the volume that an input chooses, or kNoVolume. Throws InputError where it is no number.
int volumeOf(const InputSpec& input);

/// Throws InputError where a file has no such volume.
void checkVolume(const std::string& path, int volume, int volumes);

/// Tells that the first of several volumes is taken. `kinds`: what tells them apart, as "time", "3D-vector"; may be
/// empty.
void noteFirstVolume(const std::string& path, const std::string& kinds, ImageFile& file);
/// Tells that colours are taken as luminance.
void noteLuminance(const std::string& path, ImageFile& file);

/// Tells how many whole numbers of 64 bits were too large for doubles, 2^53 and more, and so were rounded.
void noteRounded(RawType stored, ImageFile& file);

/// The luminance (ITU-R BT.709) of red, green and blue, which `colour(0)` to `colour(2)` give one after the other, in
/// their type; whole numbers are rounded.
ImageValues luminanceOf(const std::function<ImageValues(int)>& colour);

/// What decides of the type of a volume's values, so that those of one file have one.
TypeBy typeByOf(const ImageFile& file);

/// Makes the axes from `given` on, which a file does not tell, of one voxel and at right angles to those before.
void addFlatAxes(ImageLattice& lattice, size_t given);

/// Throws IoError where the axes of an image flatten space, or it is placed by what is not finite; with `force` it is
/// placed as well as can be told, with a warning.
void checkPlace(const std::string& path, bool force, ImageFile& file);

/// Reads numbers of a volume. Throws IoError where the file has not all of them.
void readOrRefuse(const std::string& path, VolumeReader& reader, void* to, size_t count, RawType type);

/// Throws IoError for slices with whole numbers that need more than 32 bits.
[[noreturn]] void refuseWideSlices(const std::string& path);

/// An image slice by slice. Where a file has one volume its slices refuse whole numbers beyond 32 bits, for only the whole
/// shows what type values of 64 bits become.
ImageSlices slicesOf(const std::string& path, ImageFile file, RawType type, VolumeReader reader);

}  // namespace slicemorph
