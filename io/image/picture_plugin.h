#pragma once

#include <cstddef>

/// What the library `libslicemorph_pictures.so` exports. OpenImageIO costs a quarter of a second and 137 MB
/// when a program starts, so only this library links it and it is loaded when pictures are read.
extern "C" {

/// One page of a picture file. Strings are static until the next call from the same thread.
struct SlicemorphPicture {
  int width, height, channels;
  int bytes;     ///< of a value: 1, 2 or 4
  int kind;      ///< 0 unsigned, 1 signed, 2 float
  int pages;     ///< of the file
  void* values;  ///< interleaved, rows from the top; from malloc, the caller frees it; null where none were
                 ///< asked for
};

/// Returns 0, or a description of what went wrong.
typedef const char* (*SlicemorphReadPicture)(const char* path, int page, int values,
                                             SlicemorphPicture* picture);
const char* slicemorphReadPicture(const char* path, int page, int values, SlicemorphPicture* picture);
}
