#pragma once

#include <cstddef>
#include <cstdint>

/// What the plug-in `libslicemorph_pictures.so` exports. OpenImageIO costs a quarter of a second and 137 MB
/// when a program starts, so only the plug-in links it, and it is loaded when pictures are read.
extern "C" {

/// How the pages of a file make volumes: page z * sliceStride + c * channelStride + t * timeStride.
struct SlicemorphPages {
  int slices, channels, times;  ///< 0: the file does not say
  int sliceStride, channelStride, timeStride;
  double spacing[3];  ///< between pixels, rows and slices, in `unit`; 0: not said
  double origin[3];   ///< of the first pixel, in pixels and slices
  char unit[32];      ///< of length, as the file has it
  char program[32];   ///< whose description of the pages it is; empty: there is none
};

/// One page of a picture file.
struct SlicemorphPicture {
  int width, height, channels;  ///< of EXR the display window's
  int bytes;                    ///< of a value: 1, 2, 4 or 8
  int kind;                     ///< 0 unsigned, 1 signed, 2 float
  int bits;                     ///< of a value as it is stored, for whole numbers
  int pages;                    ///< of the file
  int whiteIsZero;              ///< 1: the file says that 0 is shown white; values are as stored
  int cut;                      ///< 1: pixels outside the display window of an EXR file were left out
  SlicemorphPages layout;
  void* values;  ///< interleaved, rows from the top; from malloc, the caller frees it; null where none were
                 ///< asked for
};

/// Reads page `page` (from 0); `values` 0: only the description. Returns null, or a description of what went
/// wrong, which is valid until the next call from the same thread.
typedef const char* (*SlicemorphReadPicture)(const char* path, int page, int values,
                                             SlicemorphPicture* picture);
const char* slicemorphReadPicture(const char* path, int page, int values, SlicemorphPicture* picture);
}
