#pragma once

#include <cstddef>

/// What the plug-in `libslicemorph_pictures.so` exports. OpenImageIO costs a quarter of a second and 137 MB
/// when a program starts, so only the plug-in links it, and it is loaded when pictures are read.
extern "C" {

/// One page of a picture file.
struct SlicemorphPicture {
  int width, height, channels;
  int bytes;     ///< of a value: 1, 2 or 4
  int kind;      ///< 0 unsigned, 1 signed, 2 float
  int pages;     ///< of the file
  void* values;  ///< interleaved, rows from the top; from malloc, the caller frees it; null where none were
                 ///< asked for
};

/// Reads page `page` (from 0); `values` 0: only the description. Returns null, or a description of what went
/// wrong, which is valid until the next call from the same thread.
typedef const char* (*SlicemorphReadPicture)(const char* path, int page, int values,
                                             SlicemorphPicture* picture);
const char* slicemorphReadPicture(const char* path, int page, int values, SlicemorphPicture* picture);
}
