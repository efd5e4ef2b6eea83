#include "io/image/packed_bytes.h"

#include "slicemorph/errors.h"

#include <algorithm>

namespace slicemorph {

PackedBytes::PackedBytes(const std::string& path, std::uint64_t from, PackedAs as)
    : file_(path, std::ios::binary), as_(as), in_(as == PackedAs::kPlain ? 0 : 1 << 18) {
  constexpr int kEither = 32 + 15;  // zlib's windowBits: gzip or zlib, with the largest window
  file_.seekg(std::streamoff(from));
  if (!file_ || (as == PackedAs::kDeflate && inflateInit2(&deflated_, kEither) != Z_OK) ||
      (as == PackedAs::kBzip2 && BZ2_bzDecompressInit(&zipped_, 0, 0) != BZ_OK))
    throw IoError(path, "cannot be read");
}

PackedBytes::~PackedBytes() {
  if (as_ == PackedAs::kDeflate) inflateEnd(&deflated_);
  if (as_ == PackedAs::kBzip2) BZ2_bzDecompressEnd(&zipped_);
}

size_t PackedBytes::read(void* to, size_t bytes) {
  auto* out = static_cast<char*>(to);
  if (as_ == PackedAs::kPlain) return size_t(file_.read(out, std::streamsize(bytes)).gcount());
  size_t got = 0;
  while (got < bytes && (more_ || ended_)) {
    if (at_ == there_) {
      at_ = 0, there_ = size_t(file_.read(in_.data(), std::streamsize(in_.size())).gcount());
      if (there_ == 0) break;
    }
    if (!more_ && !restart()) break;
    const size_t room = std::min<size_t>(bytes - got, 1u << 30);
    got += as_ == PackedAs::kDeflate ? inflated(out + got, room) : unzipped(out + got, room);
  }
  return got;
}

size_t PackedBytes::inflated(char* to, size_t room) {
  deflated_.next_in = reinterpret_cast<Bytef*>(&in_[at_]), deflated_.avail_in = uInt(there_ - at_);
  deflated_.next_out = reinterpret_cast<Bytef*>(to), deflated_.avail_out = uInt(room);
  const int state = inflate(&deflated_, Z_NO_FLUSH);
  at_ = there_ - deflated_.avail_in;
  more_ = state == Z_OK, ended_ = state == Z_STREAM_END;
  return room - deflated_.avail_out;
}

size_t PackedBytes::unzipped(char* to, size_t room) {
  zipped_.next_in = &in_[at_], zipped_.avail_in = unsigned(there_ - at_);
  zipped_.next_out = to, zipped_.avail_out = unsigned(room);
  const int state = BZ2_bzDecompress(&zipped_);
  at_ = there_ - zipped_.avail_in;
  more_ = state == BZ_OK, ended_ = state == BZ_STREAM_END;
  return room - zipped_.avail_out;
}

bool PackedBytes::restart() {
  // Programs that pack in parallel write streams one after the other.
  const char* magic = as_ == PackedAs::kDeflate ? "\x1f\x8b" : "BZ";
  if (there_ - at_ < 2 || in_[at_] != magic[0] || in_[at_ + 1] != magic[1]) return false;
  const bool again = as_ == PackedAs::kDeflate ? inflateReset(&deflated_) == Z_OK
                                               : BZ2_bzDecompressEnd(&zipped_) == BZ_OK &&
                                                     BZ2_bzDecompressInit(&zipped_, 0, 0) == BZ_OK;
  more_ = again, ended_ = false;
  return again;
}

bool PackedBytes::skip(std::uint64_t bytes) {
  std::vector<char> spare(1 << 16);
  while (bytes > 0) {
    const size_t got = read(spare.data(), size_t(std::min<std::uint64_t>(bytes, spare.size())));
    if (got == 0) return false;
    bytes -= got;
  }
  return true;
}

bool PackedBytes::endsWell() {
  std::vector<char> spare(1 << 16);
  while (read(spare.data(), spare.size()) > 0) {
  }
  return ended_;
}

}  // namespace slicemorph
