#include "io/image/dicom_pixels.h"

#include "io/image/raw_values.h"
#include "slicemorph/errors.h"

#include <gdcmImageReader.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace slicemorph {
namespace {

/// How decoded or stored pixels lie in memory.
struct PixelLayout {
  RawType type;
  int bitsUsed = 16, highBit = 15;
};

PixelLayout layoutOf(const DicomPixels& p) {
  const RawType::Kind kind = p.kind != DicomPixels::kWhole ? RawType::kFloat
                             : p.isSigned                  ? RawType::kSigned
                                                           : RawType::kUnsigned;
  return {{std::max(1, p.bits / 8), kind}, p.bitsUsed, p.highBit};
}

/// All frames of a file, decoded by GDCM.
struct DecodedFile {
  PixelLayout layout;
  std::vector<char> bytes;
};

DecodedFile decode(const DicomFile& file) {
  gdcm::ImageReader reader;
  reader.SetFileName(file.path.c_str());
  DecodedFile out;
  try {
    if (!reader.Read())
      throw IoError(file.path, "its pixels cannot be decoded: they are damaged or of an unknown compression");
    const gdcm::Image& image = reader.GetImage();
    const gdcm::PixelFormat& format = image.GetPixelFormat();
    out.bytes.resize(image.GetBufferLength());
    if (!image.GetBuffer(out.bytes.data()))
      throw IoError(file.path, std::string("its pixels cannot be decoded (") +
                                   image.GetTransferSyntax().GetString() + ")");
    const bool real = format == gdcm::PixelFormat::FLOAT32 || format == gdcm::PixelFormat::FLOAT64;
    out.layout = {{format.GetBitsAllocated() <= 8    ? 1
                   : format.GetBitsAllocated() <= 16 ? 2
                                                     : format.GetBitsAllocated() / 8,
                   real                              ? RawType::kFloat
                   : format.GetPixelRepresentation() ? RawType::kSigned
                                                     : RawType::kUnsigned},
                  format.GetBitsStored(),
                  format.GetHighBit()};
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(file.path, std::string("its pixels cannot be decoded: ") + error.what());
  }
  const DicomPixels& p = file.pixels;
  const size_t needed = size_t(p.columns) * size_t(p.rows) * size_t(p.frames) * size_t(out.layout.type.bytes);
  if (out.bytes.size() < needed)
    throw IoError(file.path, "its pixels unpack to " + std::to_string(out.bytes.size()) + " bytes, " +
                                 std::to_string(needed) + " are needed");
  return out;
}

/// Bytes of one stored frame that is not compressed.
std::vector<char> storedBytes(const DicomFile& file, int frame, size_t each) {
  std::ifstream in(file.path, std::ios::binary);
  in.seekg(std::streamoff(file.pixels.at + std::uint64_t(frame) * each));
  std::vector<char> bytes(each);
  if (!in.read(bytes.data(), std::streamsize(each))) throw IoError(file.path, "its pixels cannot be read");
  return bytes;
}

/// A frame whose pixels are bits, which follow each other through all frames without a gap.
ImageValues bitsOf(const DicomFile& file, const DicomFrame& frame) {
  const size_t count = size_t(file.columns) * size_t(file.rows), first = count * size_t(frame.number);
  std::ifstream in(file.path, std::ios::binary);
  in.seekg(std::streamoff(file.pixels.at + first / 8));
  std::vector<char> bytes((first % 8 + count + 7) / 8);
  if (!in.read(bytes.data(), std::streamsize(bytes.size())))
    throw IoError(file.path, "its pixels cannot be read");
  std::vector<std::uint8_t> values(count);
  for (size_t i = 0; i < count; ++i) {
    const size_t bit = first % 8 + i;
    values[i] = std::uint8_t(static_cast<unsigned char>(bytes[bit / 8]) >> (bit % 8) & 1);
  }
  return values;
}

template <typename T>
T signExtended(T raw, const PixelLayout& layout) {
  using Bits = std::make_unsigned_t<T>;
  const int width = int(sizeof(T)) * 8;
  if (layout.bitsUsed >= width) return raw;
  const Bits up = Bits(Bits(raw) << (width - 1 - layout.highBit));
  return T(T(up) >> (width - layout.bitsUsed));  // arithmetic for signed types
}

template <typename T>
void keepUsedBits(char* bytes, size_t count, const PixelLayout& layout,
                  const std::optional<std::pair<double, double>>& padding, std::vector<bool>& padded) {
  T* values = reinterpret_cast<T*>(bytes);
  for (size_t i = 0; i < count; ++i) {
    const T raw = values[i];
    if constexpr (std::is_integral_v<T>) values[i] = signExtended(raw, layout);
    // Padding may lie beyond the bits in use.
    const auto isPadding = [&](T v) { return double(v) >= padding->first && double(v) <= padding->second; };
    if (padding && (isPadding(raw) || isPadding(values[i]))) {
      if (padded.empty()) padded.resize(count);
      padded[i] = true;
    }
  }
}

void keepUsedBits(char* bytes, size_t count, const PixelLayout& layout,
                  const std::optional<std::pair<double, double>>& padding, std::vector<bool>& padded) {
  const auto run = [&](auto asSigned, auto asUnsigned) {
    if (layout.type.kind == RawType::kSigned)
      keepUsedBits<decltype(asSigned)>(bytes, count, layout, padding, padded);
    else
      keepUsedBits<decltype(asUnsigned)>(bytes, count, layout, padding, padded);
  };
  if (layout.type.kind == RawType::kFloat) return;
  switch (layout.type.bytes) {
    case 1:
      return run(std::int8_t(), std::uint8_t());
    case 2:
      return run(std::int16_t(), std::uint16_t());
    case 4:
      return run(std::int32_t(), std::uint32_t());
    default:
      return run(std::int64_t(), std::uint64_t());
  }
}

/// The stored values of one slice. `padded`: its pixels that are padding; empty: none.
ImageValues sliceOf(const DicomFile& file, const DicomFrame& frame, const DecodedFile& decoded,
                    std::vector<bool>& padded) {
  const DicomPixels& p = file.pixels;
  if (p.bits == 1) return bitsOf(file, frame);
  const PixelLayout layout = p.decode ? decoded.layout : layoutOf(p);
  const size_t size = size_t(layout.type.bytes), each = size_t(p.columns) * size_t(p.rows) * size;
  const std::vector<char> stored = p.decode ? std::vector<char>() : storedBytes(file, frame.number, each);
  const char* from = p.decode ? decoded.bytes.data() + size_t(frame.number) * each : stored.data();
  const size_t count = size_t(file.columns) * size_t(file.rows), row = size_t(file.columns) * size;
  std::vector<char> bytes(count * size);
  for (int j = 0; j < file.rows; ++j)
    std::memcpy(bytes.data() + size_t(j) * row,
                from + (size_t(frame.tile[1] + j) * size_t(p.columns) + size_t(frame.tile[0])) * size, row);
  keepUsedBits(bytes.data(), count, layout, p.padding, padded);
  return readValues(layout.type, count, [&](void* to) { std::memcpy(to, bytes.data(), bytes.size()); });
}

bool isWhole(double v) { return v == std::rint(v); }

/// What the rescaled values of all slices need.
struct ValueRange {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool whole = true, wide = false;  ///< only whole numbers; floats would lose digits
};

struct Rescale {
  double slope = 1, intercept = 0;
};

ValueRange rangeOf(const std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale) {
  std::vector<ValueRange> each(slices.size());
  tbb::parallel_for(size_t(0), slices.size(), [&](size_t i) {
    std::visit(
        [&](const auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          const Rescale& r = rescale[i];
          ValueRange& range = each[i];
          range.whole = std::is_integral_v<T> && isWhole(r.slope) && isWhole(r.intercept);
          range.wide = std::is_same_v<T, double> || std::is_same_v<T, std::int32_t>;
          if (values.empty()) return;
          const auto [low, high] = std::minmax_element(values.begin(), values.end());
          const double a = double(*low) * r.slope + r.intercept, b = double(*high) * r.slope + r.intercept;
          range.least = std::min(a, b), range.most = std::max(a, b);
        },
        slices[i]);
  });
  ValueRange all;
  for (const ValueRange& r : each) {
    all.least = std::min(all.least, r.least), all.most = std::max(all.most, r.most);
    all.whole = all.whole && r.whole, all.wide = all.wide || r.wide;
  }
  return all;
}

template <typename To>
void convert(std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale) {
  tbb::parallel_for(size_t(0), slices.size(), [&](size_t i) {
    const Rescale r = rescale[i];
    if (std::holds_alternative<std::vector<To>>(slices[i]) && r.slope == 1 && r.intercept == 0) return;
    slices[i] = std::visit(
        [&](const auto& values) -> ImageValues {
          std::vector<To> out(values.size());
          std::transform(values.begin(), values.end(), out.begin(),
                         [&](auto v) { return To(double(v) * r.slope + r.intercept); });
          return out;
        },
        slices[i]);
  });
}

template <typename T>
bool holds(const ValueRange& range) {
  return range.least >= double(std::numeric_limits<T>::min()) &&
         range.most <= double(std::numeric_limits<T>::max());
}

/// Rescales each slice, all to one type.
void rescaleAll(std::vector<ImageValues>& slices, const std::vector<Rescale>& rescale) {
  const bool identity = std::all_of(rescale.begin(), rescale.end(),
                                    [](const Rescale& r) { return r.slope == 1 && r.intercept == 0; });
  const bool oneType = std::all_of(slices.begin(), slices.end(),
                                   [&](const ImageValues& s) { return s.index() == slices[0].index(); });
  if (identity && oneType) return;
  const ValueRange range = rangeOf(slices, rescale);
  if (range.whole && holds<std::int16_t>(range)) return convert<std::int16_t>(slices, rescale);
  if (range.whole && holds<std::uint16_t>(range)) return convert<std::uint16_t>(slices, rescale);
  if (range.whole && holds<std::int32_t>(range)) return convert<std::int32_t>(slices, rescale);
  if (range.wide) return convert<double>(slices, rescale);
  convert<float>(slices, rescale);
}

/// Gives padding the least value of all other pixels.
void fillPadding(DicomValues& values, const std::vector<std::vector<bool>>& padded) {
  for (const std::vector<bool>& p : padded) values.padded += size_t(std::count(p.begin(), p.end(), true));
  if (values.padded == 0) return;
  std::visit(
      [&](const auto& first) {
        using T = typename std::decay_t<decltype(first)>::value_type;
        bool any = false;
        T least = 0;
        for (size_t k = 0; k < padded.size(); ++k) {
          const auto& slice = std::get<std::vector<T>>(values.slices[k]);
          for (size_t i = 0; i < slice.size(); ++i)
            if ((padded[k].empty() || !padded[k][i]) && (!any || slice[i] < least))
              least = slice[i], any = true;
        }
        values.least = double(least);
        if (!any) {
          values.padded = 0;  // nothing else is there: what is stored stays
          return;
        }
        for (size_t k = 0; k < padded.size(); ++k)
          for (size_t i = 0; i < padded[k].size(); ++i)
            if (padded[k][i]) std::get<std::vector<T>>(values.slices[k])[i] = least;
      },
      values.slices[0]);
}

/// Those files that need it, decoded.
std::vector<DecodedFile> decodeAll(const DicomSeries& series, const std::vector<DicomSliceRef>& slices) {
  std::vector<bool> used(series.files.size());
  for (const DicomSliceRef& r : slices) used[r.file] = series.files[r.file].pixels.decode;
  std::vector<DecodedFile> decoded(series.files.size());
  tbb::parallel_for(size_t(0), decoded.size(), [&](size_t f) {
    if (used[f]) decoded[f] = decode(series.files[f]);
  });
  return decoded;
}

}  // namespace

int bytesOfPixel(const DicomFile& file) { return std::max(1, (file.pixels.bits + 7) / 8); }

DicomValues readDicomValues(const DicomSeries& series, const std::vector<DicomSliceRef>& slices) {
  const std::vector<DecodedFile> decoded = decodeAll(series, slices);
  DicomValues out;
  out.slices.resize(slices.size());
  std::vector<std::vector<bool>> padded(slices.size());
  std::vector<Rescale> rescale(slices.size());
  tbb::parallel_for(size_t(0), slices.size(), [&](size_t i) {
    const DicomFrame& frame = series.frameOf(slices[i]);
    rescale[i] = {frame.slope, frame.intercept};
    out.slices[i] = sliceOf(series.files[slices[i].file], frame, decoded[slices[i].file], padded[i]);
  });
  rescaleAll(out.slices, rescale);
  const auto& padding = series.files[slices[0].file].pixels.padding;
  if (padding) out.padding = padding->first;
  fillPadding(out, padded);
  return out;
}

std::vector<ImageValues> readStoredFrames(const DicomFile& file) {
  const DecodedFile decoded = file.pixels.decode ? decode(file) : DecodedFile();
  std::vector<ImageValues> out(file.frames.size());
  tbb::parallel_for(size_t(0), out.size(), [&](size_t k) {
    std::vector<bool> padded;
    out[k] = sliceOf(file, file.frames[k], decoded, padded);
  });
  return out;
}

}  // namespace slicemorph
