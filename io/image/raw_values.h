#pragma once

#include "slicemorph/image.h"

#include <functional>

namespace slicemorph {

/// A number type as files name it.
struct RawType {
  int bytes = 1;  ///< 1, 2, 4 or 8
  enum Kind { kUnsigned, kSigned, kFloat } kind = kUnsigned;
};

/// What decides of the type of values that are widened or rescaled: these values, or all that the file's type can hold,
/// so that every volume of a file gets the same.
enum class TypeBy { kValues, kRange };

/// Gets `count` values of a file's type from `read`, which writes them to the address given. Types that
/// ImageValues lacks are widened: 8-bit signed to 16-bit; 32-bit unsigned and 64-bit to 32-bit signed where
/// all values fit, else to double.
ImageValues readValues(RawType type, size_t count, const std::function<void(void*)>& read,
                       TypeBy by = TypeBy::kValues);

/// No values, of the type that readValues() gives those of a file's type that are in range.
ImageValues noValues(RawType type, TypeBy by = TypeBy::kValues);

/// Bytes that a value takes while it is read, at most: in the file's type and in that of the values where it is another,
/// or in the latter and as `scaled` by rescaled().
size_t bytesWhileRead(RawType type, bool scaled = false);

/// Called with an image's size and the bytes that its values will take, before they are taken; throws where these are
/// too many.
using SizeCheck = std::function<void(const openvdb::Coord& size, double bytes)>;

/// value * slope + intercept. Integers become the smallest integer type (16 or 32 bits) that holds the results, or those of
/// all that their type can hold, where slope and intercept are whole numbers; else values become float, and 32-bit
/// integers and doubles double.
ImageValues rescaled(ImageValues values, double slope, double intercept, TypeBy by = TypeBy::kValues);

/// The type of the values.
RawType rawTypeOf(const ImageValues& values);

/// Swaps the bytes of `count` numbers of `bytes` bytes each in place, for files of the other byte order.
void swapBytes(void* data, size_t count, int bytes);

}  // namespace slicemorph
