#include "io/exr/exr_check.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace slicemorph {
namespace {

/// Rows of one chunk, by the number of the compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
constexpr std::array<std::int64_t, 10> kChunkRows{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
/// Bytes of the table of offsets for each chunk, which every file has.
constexpr double kOffsetBytes = 8;
/// Pixels that a byte can hold at most: with PIZ, the densest, a chunk of 32 equal rows takes some 40 bytes.
constexpr double kPixelsPerByte = 1 << 16;
/// Names and texts of a header are far shorter, and no program writes that many attributes or parts.
constexpr size_t kMostName = 256, kMostAttributes = 100000;

/// What a part claims.
struct Claim {
  std::int64_t width = 0, height = 0, tileWidth = 0, tileHeight = 0;
  size_t compression = 0;

  double chunks() const {
    if (tileWidth > 0 && tileHeight > 0)
      return std::ceil(double(width) / double(tileWidth)) * std::ceil(double(height) / double(tileHeight));
    return std::ceil(double(height) / double(kChunkRows[std::min(compression, kChunkRows.size() - 1)]));
  }
};

class HeaderReader {
 public:
  explicit HeaderReader(const std::string& path) : file_(path, std::ios::binary) {}

  /// The parts of the file; none where it is no EXR, or its header ends early.
  std::vector<Claim> claims() {
    std::vector<Claim> parts;
    const std::optional<std::uint32_t> magic = number(), version = number();
    if (!version || *magic != 20000630) return parts;
    const bool several = *version & 0x1000;
    size_t left = kMostAttributes;
    while (const std::optional<Claim> part = header(left)) {
      parts.push_back(*part);
      // The headers of several parts end with an empty one.
      if (!several || file_.peek() == 0) break;
    }
    return parts;
  }

 private:
  std::optional<std::uint32_t> number() {
    std::array<unsigned char, 4> b{};
    if (!file_.read(reinterpret_cast<char*>(b.data()), b.size())) return std::nullopt;
    return std::uint32_t(b[0]) | std::uint32_t(b[1]) << 8 | std::uint32_t(b[2]) << 16 |
           std::uint32_t(b[3]) << 24;
  }
  std::string text() {
    std::string text;
    for (char c = 0; text.size() < kMostName && file_.get(c) && c != 0;) text += c;
    return text;
  }
  std::optional<Claim> header(size_t& left) {
    Claim claim;
    for (; left > 0 && file_; --left) {
      const std::string name = text();
      if (name.empty()) return file_ ? std::optional(claim) : std::nullopt;
      text();
      const std::optional<std::uint32_t> size = number();
      if (!size || *size > std::uint32_t(INT32_MAX)) return std::nullopt;
      const std::streamoff next = std::streamoff(file_.tellg()) + std::streamoff(*size);
      attribute(name, claim);
      file_.clear();
      file_.seekg(next);
    }
    return std::nullopt;
  }
  void attribute(const std::string& name, Claim& claim) {
    if (name == "compression") claim.compression = size_t(file_.get());
    if (name == "tiles") claim.tileWidth = number().value_or(0), claim.tileHeight = number().value_or(0);
    if (name != "dataWindow") return;
    std::array<std::int64_t, 4> window{};
    for (std::int64_t& edge : window) edge = std::int32_t(number().value_or(0));
    claim.width = window[2] - window[0] + 1, claim.height = window[3] - window[1] + 1;
  }

  std::ifstream file_;
};

}  // namespace

void checkExrHeader(const std::string& path) {
  std::error_code error;
  const double bytes = double(std::filesystem::file_size(path, error));
  if (error) return;
  for (const Claim& claim : HeaderReader(path).claims()) {
    if (claim.width < 1 || claim.height < 1) continue;
    const double pixels = double(claim.width) * double(claim.height);
    if (pixels <= kPixelsPerByte * bytes && kOffsetBytes * claim.chunks() <= bytes) continue;
    std::ostringstream why;
    why << "is damaged: its header claims " << claim.width << " x " << claim.height
        << " pixels, and the file has " << std::uint64_t(bytes) << " bytes";
    throw IoError(path, why.str());
  }
}

}  // namespace slicemorph
