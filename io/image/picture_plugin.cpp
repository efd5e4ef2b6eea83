#include "io/image/picture_plugin.h"

#include "io/image/picture_pages.h"

#include <OpenImageIO/imageio.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace slicemorph {
namespace {

using namespace OIIO;

struct CloseTiff {
  void operator()(TIFF* file) const { TIFFClose(file); }
};

/// Where pages lie that have no description of their own: one after the other behind the first, as ImageJ and tifffile
/// write them. Throws std::runtime_error where they cannot.
struct HiddenPages {
  std::uint64_t from = 0, bytes = 0;
  bool swapped = false;
};
HiddenPages hiddenPagesOf(const char* path, const ImageSpec& spec, int pages) {
  TIFFSetErrorHandler(nullptr), TIFFSetWarningHandler(nullptr);
  const std::unique_ptr<TIFF, CloseTiff> file(TIFFOpen(path, "r"));
  std::uint64_t* offsets = nullptr;
  std::uint16_t compression = COMPRESSION_NONE, planes = PLANARCONFIG_CONTIG;
  if (file) TIFFGetFieldDefaulted(file.get(), TIFFTAG_COMPRESSION, &compression);
  if (file) TIFFGetFieldDefaulted(file.get(), TIFFTAG_PLANARCONFIG, &planes);
  const std::string told = "it tells of " + std::to_string(pages) + " pictures, but has one page, ";
  if (!file || compression != COMPRESSION_NONE || planes != PLANARCONFIG_CONTIG || TIFFIsTiled(file.get()) ||
      !TIFFGetField(file.get(), TIFFTAG_STRIPOFFSETS, &offsets) || !offsets)
    throw std::runtime_error(told + "whose values do not lie in one piece");
  HiddenPages hidden{offsets[0], spec.image_bytes(true), bool(TIFFIsByteSwapped(file.get()))};
  std::ifstream bytes(path, std::ios::binary | std::ios::ate);
  const auto there = std::uint64_t(bytes.tellg());
  if (hidden.bytes == 0 || there < hidden.from || (there - hidden.from) / hidden.bytes < std::uint64_t(pages))
    throw std::runtime_error(told + "and the file is too short for more");
  return hidden;
}

void readHidden(const char* path, const HiddenPages& hidden, int page, size_t bytesOfValue, void* to) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(std::streamoff(hidden.from + hidden.bytes * std::uint64_t(page)));
  if (!file.read(static_cast<char*>(to), std::streamsize(hidden.bytes)))
    throw std::runtime_error("it is cut short");
  auto* at = static_cast<char*>(to);
  for (std::uint64_t i = 0; hidden.swapped && i < hidden.bytes; i += bytesOfValue)
    std::reverse(at + i, at + i + bytesOfValue);
}

/// Numbers that OpenImageIO spread over the whole range of a type, or turned round, as they are stored.
template <typename T>
void asStored(void* values, size_t count, int shift, bool inverted) {
  auto* v = static_cast<T*>(values);
  for (size_t i = 0; i < count; ++i) v[i] = T((inverted ? T(~v[i]) : v[i]) >> shift);
}

void undoDisplay(void* values, size_t count, const SlicemorphPicture& picture) {
  const int shift = 8 * picture.bytes - picture.bits;
  // Of all types OpenImageIO turns round only this one.
  const bool inverted = picture.whiteIsZero && picture.bytes == 1;
  if (picture.kind != 0 || (shift == 0 && !inverted)) return;
  if (picture.bytes == 1) asStored<std::uint8_t>(values, count, shift, inverted);
  if (picture.bytes == 2) asStored<std::uint16_t>(values, count, shift, inverted);
  if (picture.bytes == 4) asStored<std::uint32_t>(values, count, shift, inverted);
}

/// The pixels of a data window within the display window, 0 outside.
void* placedInDisplay(const ImageSpec& spec, const void* from, size_t pixel) {
  void* to = std::calloc(size_t(spec.full_width) * size_t(spec.full_height), pixel);
  if (!to) return nullptr;
  const int x = spec.x - spec.full_x, y = spec.y - spec.full_y;
  const int first = std::max(0, -x), last = std::min(spec.width, spec.full_width - x);
  for (int row = std::max(0, -y); row < std::min(spec.height, spec.full_height - y) && first < last; ++row)
    std::memcpy(
        static_cast<char*>(to) + (size_t(row + y) * size_t(spec.full_width) + size_t(first + x)) * pixel,
        static_cast<const char*>(from) + (size_t(row) * size_t(spec.width) + size_t(first)) * pixel,
        size_t(last - first) * pixel);
  return to;
}

/// A message of the library without the name of the file, which the error begins with.
std::string withoutPath(std::string text, const std::string& path) {
  for (const std::string& name : {"\"" + path + "\"", path})
    for (size_t at; (at = text.find(name)) != std::string::npos;) text.replace(at, name.size(), "it");
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text;
}

TypeDesc typeToRead(const TypeDesc& stored) {
  if (stored == TypeDesc::DOUBLE) return stored;
  if (stored.is_floating_point()) return TypeDesc::FLOAT;
  if (stored.basesize() > 4)
    throw std::runtime_error("its values are whole numbers of 64 bits, which are not read");
  return stored;
}

/// Bits of a grey value of a PNG file, which OpenImageIO does not tell; 0: of colours.
int bitsOfPng(const char* path) {
  char head[26] = {};  // signature, IHDR's length, name, width and height, bits, kind of colour
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  return head[25] == 0 ? head[24] : 0;
}

/// How many bits a value has in the file.
int bitsOf(const char* path, const char* format, const ImageSpec& spec, const TypeDesc& type) {
  if (std::strcmp(format, "png") == 0) {
    const int bits = bitsOfPng(path);
    if (bits > 0 && bits < 8) return bits;
  }
  const int all = int(8 * type.basesize()), stored = spec.get_int_attribute("oiio:BitsPerSample", all);
  const bool palette = spec.get_int_attribute("tiff:PhotometricInterpretation", -1) == PHOTOMETRIC_PALETTE;
  return type.is_floating_point() || palette || stored < 1 || stored > all ? all : stored;
}

int pagesToldBy(const SlicemorphPages& layout) { return layout.slices * layout.channels * layout.times; }

/// Colours of one page count as channels in OME: takes them off the channels that lie in pages of their own.
void leaveOutColours(int colours, SlicemorphPages& layout) {
  for (int* stride : {&layout.sliceStride, &layout.timeStride})
    if (*stride > layout.channelStride) *stride /= colours;
  layout.channels /= colours;
}

void describe(const char* path, ImageInput& input, int page, SlicemorphPicture& picture) {
  int pages = 1;
  while (input.seek_subimage(pages, 0)) ++pages;
  input.geterror();
  if (!input.seek_subimage(0, 0)) throw std::runtime_error("it has no pictures");
  const bool tiff = std::strcmp(input.format_name(), "tiff") == 0;
  if (tiff) {
    const ImageSpec& first = input.spec();
    const double resolution[] = {first.get_float_attribute("XResolution"),
                                 first.get_float_attribute("YResolution")};
    picture.layout = pagesFromDescription(first.get_string_attribute("ImageDescription"), resolution);
    const std::int64_t values = std::int64_t(pages) * std::max(1, first.nchannels);
    if (first.nchannels > 1 && pagesToldBy(picture.layout) == values &&
        picture.layout.channels % first.nchannels == 0)
      leaveOutColours(first.nchannels, picture.layout);
    const int told = pagesToldBy(picture.layout);
    if (told > 1 && pages == 1) hiddenPagesOf(path, first, told), pages = told;
    if (told > 0 && told != pages)
      throw std::runtime_error("its description (" + std::string(picture.layout.program) + ") tells of " +
                               std::to_string(told) + " pictures, and it has " + std::to_string(pages));
  }
  picture.pages = pages;
  if (page >= pages) throw std::runtime_error("it has " + std::to_string(pages) + " pages");
  if (!input.seek_subimage(page, 0)) input.seek_subimage(0, 0);
  input.geterror();
  const ImageSpec& spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) throw std::runtime_error("it has no pixels");
  const TypeDesc type = typeToRead(spec.format);
  const bool windows = std::strcmp(input.format_name(), "openexr") == 0;
  picture.width = windows ? spec.full_width : spec.width,
  picture.height = windows ? spec.full_height : spec.height;
  picture.channels = spec.nchannels;
  picture.bytes = int(type.basesize());
  picture.kind = type.is_floating_point() ? 2 : int(type.is_signed());
  picture.bits = bitsOf(path, input.format_name(), spec, type);
  picture.whiteIsZero =
      tiff && spec.get_int_attribute("tiff:PhotometricInterpretation", -1) == PHOTOMETRIC_MINISWHITE;
  picture.cut = windows && (spec.x < spec.full_x || spec.y < spec.full_y ||
                            spec.x + spec.width > spec.full_x + spec.full_width ||
                            spec.y + spec.height > spec.full_y + spec.full_height);
}

void readValues(const char* path, ImageInput& input, int page, SlicemorphPicture& picture) {
  const ImageSpec spec = input.spec();
  const TypeDesc type = typeToRead(spec.format);
  const size_t count = size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels);
  std::unique_ptr<void, decltype(&std::free)> values(std::malloc(count * type.basesize()), &std::free);
  if (!values) throw std::runtime_error("out of memory");
  if (page > 0 && input.current_subimage() != page) {
    readHidden(path, hiddenPagesOf(path, spec, picture.pages), page, type.basesize(), values.get());
  } else {
    if (!input.read_image(page, 0, 0, spec.nchannels, type, values.get()))
      throw std::runtime_error(withoutPath(input.geterror(), path));
    undoDisplay(values.get(), count, picture);
  }
  if (std::strcmp(input.format_name(), "openexr") == 0)
    picture.values = placedInDisplay(spec, values.get(), size_t(spec.nchannels) * type.basesize());
  else
    picture.values = values.release();
  if (!picture.values) throw std::runtime_error("out of memory");
}

}  // namespace
}  // namespace slicemorph

const char* slicemorphReadPicture(const char* path, int page, int values, SlicemorphPicture* picture) {
  thread_local std::string problem;
  *picture = {};
  try {
    const auto input = OIIO::ImageInput::open(path);
    if (!input) throw std::runtime_error(slicemorph::withoutPath(OIIO::geterror(), path));
    slicemorph::describe(path, *input, page, *picture);
    if (values) slicemorph::readValues(path, *input, page, *picture);
    return nullptr;
  } catch (const std::exception& error) {
    problem = error.what();
    return problem.c_str();
  }
}
