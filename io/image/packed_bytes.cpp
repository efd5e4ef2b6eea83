#include "io/image/packed_bytes.h"

#include "slicemorph/errors.h"

#include <algorithm>

namespace slicemorph {

PackedBytes::PackedBytes(const std::string& path, std::uint64_t from, bool packed)
    : file_(path, std::ios::binary), packed_(packed), in_(packed ? 1 << 18 : 0) {
  constexpr int kEither = 32 + 15;  // zlib's windowBits: gzip or zlib, with the largest window
  file_.seekg(std::streamoff(from));
  if (!file_ || (packed && inflateInit2(&stream_, kEither) != Z_OK)) throw IoError(path, "cannot be read");
}

PackedBytes::~PackedBytes() {
  if (packed_) inflateEnd(&stream_);
}

size_t PackedBytes::read(void* to, size_t bytes) {
  auto* out = static_cast<char*>(to);
  if (!packed_) return size_t(file_.read(out, std::streamsize(bytes)).gcount());
  size_t got = 0;
  while (got < bytes && state_ == Z_OK) {
    if (stream_.avail_in == 0) {
      const auto there = file_.read(in_.data(), std::streamsize(in_.size())).gcount();
      if (there == 0) break;
      stream_.next_in = reinterpret_cast<Bytef*>(in_.data()), stream_.avail_in = uInt(there);
    }
    const uInt room = uInt(std::min<size_t>(bytes - got, 1u << 30));
    stream_.next_out = reinterpret_cast<Bytef*>(out + got), stream_.avail_out = room;
    state_ = inflate(&stream_, Z_NO_FLUSH);
    got += room - stream_.avail_out;
  }
  return got;
}

bool PackedBytes::endsWell() {
  std::vector<char> spare(1 << 16);
  while (read(spare.data(), spare.size()) > 0) {
  }
  return state_ == Z_STREAM_END;
}

}  // namespace slicemorph
