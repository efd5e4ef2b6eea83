#pragma once

#include "slicemorph/image.h"

#include <functional>

namespace slicemorph {

/// A number type as files name it.
struct RawType {
  int bytes = 1;  ///< 1, 2, 4 or 8
  enum Kind { kUnsigned, kSigned, kFloat } kind = kUnsigned;
};

/// Gets `count` values of a file's type from `read`, which writes them to the address given. Types that
/// ImageValues lacks are widened: 8-bit signed to 16-bit; 32-bit unsigned and 64-bit to 32-bit signed where
/// all values fit, else to double.
ImageValues readValues(RawType type, size_t count, const std::function<void(void*)>& read);

/// No values, of the type that readValues() gives those of a file's type that are in range.
ImageValues noValues(RawType type);

/// Bytes that a value takes while it is read: in the file's type, and in that of the values where it is another.
size_t bytesWhileRead(RawType type);

/// Called with an image's size and the bytes that its values will take, before they are taken; throws where these are
/// too many.
using SizeCheck = std::function<void(const openvdb::Coord& size, double bytes)>;

/// value * slope + intercept. Integers become the smallest integer type (16 or 32 bits) that holds the
/// result where slope and intercept are whole numbers; else values become float, and 32-bit integers
/// and doubles double.
ImageValues rescaled(ImageValues values, double slope, double intercept);

/// The type of the values.
RawType rawTypeOf(const ImageValues& values);

/// Swaps the bytes of `count` numbers of `bytes` bytes each in place, for files of the other byte order.
void swapBytes(void* data, size_t count, int bytes);

}  // namespace slicemorph
