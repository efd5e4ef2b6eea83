#include "io/image/dicom_pixels.h"

#include "io/image/dicom_decode.h"
#include "io/image/dicom_rescale.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

namespace slicemorph {
namespace {

/// Fills `bytes` from the stored pixels, from byte `offset` of these on.
void readAt(const DicomFile& file, std::uint64_t offset, std::vector<char>& bytes) {
  std::ifstream in(file.path, std::ios::binary);
  in.seekg(std::streamoff(file.pixels.at + offset));
  if (!in.read(bytes.data(), std::streamsize(bytes.size())))
    throw IoError(file.path, "its pixels cannot be read");
}

/// A frame whose pixels are bits, which follow each other through all frames without a gap.
ImageValues bitsOf(const DicomFile& file, const DicomFrame& frame, const DecodedFile& decoded) {
  const size_t count = size_t(file.columns) * size_t(file.rows), first = count * size_t(frame.number);
  std::vector<char> bytes((first % 8 + count + 7) / 8);
  if (file.pixels.decode)
    std::copy_n(decoded.bytes.begin() + std::ptrdiff_t(first / 8), bytes.size(), bytes.begin());
  else
    readAt(file, first / 8, bytes);
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
  if (p.bits == 1) return bitsOf(file, frame, decoded);
  const PixelLayout layout = p.decode ? decoded.layout : layoutOf(p);
  const size_t size = size_t(layout.type.bytes), each = size_t(p.columns) * size_t(p.rows) * size;
  std::vector<char> stored(p.decode ? 0 : each);
  if (!p.decode) readAt(file, std::uint64_t(frame.number) * each, stored);
  const char* from = p.decode ? decoded.bytes.data() + size_t(frame.number) * each : stored.data();
  const size_t count = size_t(file.columns) * size_t(file.rows), row = size_t(file.columns) * size;
  std::vector<char> bytes(count * size);
  for (int j = 0; j < file.rows; ++j)
    std::memcpy(bytes.data() + size_t(j) * row,
                from + (size_t(frame.tile[1] + j) * size_t(p.columns) + size_t(frame.tile[0])) * size, row);
  keepUsedBits(bytes.data(), count, layout, p.padding, padded);
  return readValues(layout.type, count, [&](void* to) { std::memcpy(to, bytes.data(), bytes.size()); });
}

/// Looks stored values up; numbers that are no whole ones do not come with tables.
ImageValues lookedUp(const ImageValues& stored, const DicomTable& table) {
  std::vector<std::uint16_t> out;
  std::visit(
      [&](const auto& values) {
        out.resize(values.size());
        const double last = double(table.values.size() - 1);
        std::transform(values.begin(), values.end(), out.begin(), [&](auto v) {
          return table.values[size_t(std::clamp(double(v) - table.first, 0.0, last))];
        });
      },
      stored);
  return out;
}

/// So near below the least measurement, as a share of all measurements' range, padding is no surface of its own and
/// stays: MR images often state 0, where 1 is the least of others.
constexpr double kNearLeast = 0.01;

/// Gives padding the least value of all other pixels.
template <typename T>
void fillPadding(DicomValues& values, const std::vector<std::vector<bool>>& padded) {
  double least = INFINITY, most = -INFINITY, padLeast = INFINITY, padMost = -INFINITY;
  size_t count = 0;
  for (size_t k = 0; k < padded.size(); ++k) {
    const auto& slice = std::get<std::vector<T>>(values.slices[k]);
    for (size_t i = 0; i < slice.size(); ++i) {
      const double v = double(slice[i]);
      if (padded[k].empty() || !padded[k][i])
        least = std::min(least, v), most = std::max(most, v);
      else
        padLeast = std::min(padLeast, v), padMost = std::max(padMost, v), ++count;
    }
  }
  const bool near = padMost <= least && padLeast >= least - kNearLeast * (most - least);
  if (count == 0 || !(least <= most) || near) return;  // where nothing else is there, it stays, too
  for (size_t k = 0; k < padded.size(); ++k)
    for (size_t i = 0; i < padded[k].size(); ++i)
      if (padded[k][i]) std::get<std::vector<T>>(values.slices[k])[i] = T(least);
  values.padded = count, values.least = least;
}

/// Those files that need it, decoded.
std::vector<DecodedFile> decodeAll(const DicomSeries& series, const std::vector<DicomSliceRef>& slices) {
  std::vector<bool> used(series.files.size());
  for (const DicomSliceRef& r : slices) used[r.file] = series.files[r.file].pixels.decode;
  std::vector<DecodedFile> decoded(series.files.size());
  const bool any = std::find(used.begin(), used.end(), true) != used.end();
  if (!any) return decoded;
  const WithoutTerminal silence;
  tbb::parallel_for(size_t(0), decoded.size(), [&](size_t f) {
    if (used[f]) decoded[f] = decodeFile(series.files[f]);
  });
  return decoded;
}

}  // namespace

int bytesOfPixel(const DicomFile& file) { return std::max(1, (file.pixels.bits + 7) / 8); }

double bytesUnpacked(const DicomFile& file) {
  const DicomPixels& p = file.pixels;
  return p.decode ? double(p.columns) * p.rows * p.frames * p.bits / 8 : 0;
}

DicomValues readDicomValues(const DicomSeries& series, const std::vector<DicomSliceRef>& slices) {
  const std::vector<DecodedFile> decoded = decodeAll(series, slices);
  DicomValues out;
  out.slices.resize(slices.size());
  std::vector<std::vector<bool>> padded(slices.size());
  std::vector<Rescale> rescale(slices.size());
  tbb::parallel_for(size_t(0), slices.size(), [&](size_t i) {
    const DicomFrame& frame = series.frameOf(slices[i]);
    const DicomFile& file = series.files[slices[i].file];
    out.slices[i] = sliceOf(file, frame, decoded[slices[i].file], padded[i]);
    if (file.table)
      out.slices[i] = lookedUp(out.slices[i], *file.table);
    else
      rescale[i] = {frame.slope, frame.intercept};
  });
  rescaleAll(out.slices, rescale);
  const auto& padding = series.files[slices[0].file].pixels.padding;
  if (padding) out.padding = padding->first;
  const bool any = std::any_of(padded.begin(), padded.end(), [](const auto& p) { return !p.empty(); });
  if (any)
    std::visit(
        [&](const auto& v) { fillPadding<typename std::decay_t<decltype(v)>::value_type>(out, padded); },
        out.slices[0]);
  return out;
}

std::vector<ImageValues> readStoredFrames(const DicomFile& file) {
  DecodedFile decoded;
  if (file.pixels.decode) {
    const WithoutTerminal silence;
    decoded = decodeFile(file);
  }
  std::vector<ImageValues> out(file.frames.size());
  tbb::parallel_for(size_t(0), out.size(), [&](size_t k) {
    std::vector<bool> padded;
    out[k] = sliceOf(file, file.frames[k], decoded, padded);
  });
  return out;
}

}  // namespace slicemorph
