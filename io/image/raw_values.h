#pragma once

#include "slicemorph/image.h"

#include <functional>

namespace slicemorph {

/// A number type as files name it.
struct RawType {
  int bytes = 1;  ///< 1, 2, 4 or 8
  enum Kind { kUnsigned, kSigned, kFloat } kind = kUnsigned;
};

/// `count` values of a file's type, put into memory by `read`. Types that ImageValues lacks become the next
/// that holds all of their values: 8-bit signed 16-bit; 32-bit unsigned and 64-bit 32-bit signed where they
/// fit, else double.
ImageValues readValues(RawType type, size_t count, const std::function<void(void*)>& read);

/// value * slope + intercept: whole numbers stay whole where slope and intercept are, else they become float
/// (of 32-bit integers and doubles double).
ImageValues rescaled(ImageValues values, double slope, double intercept);

/// As a file names the type of values.
RawType rawTypeOf(const ImageValues& values);

/// Bytes swapped in place, for files of the other byte order.
void swapBytes(void* data, size_t count, int bytes);

}  // namespace slicemorph
