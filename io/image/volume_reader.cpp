#include "io/image/volume_reader.h"

#include <algorithm>
#include <utility>

namespace slicemorph {
namespace {

/// Bytes that are read at once where numbers of several volumes are mixed.
constexpr size_t kBuffer = 1 << 20;

}  // namespace

VolumeReader::VolumeReader(std::vector<StoredAxis> axes, size_t volume, size_t bytes, ByteReader next)
    : axes_(std::move(axes)), at_(axes_.size(), 0), bytes_(bytes), next_(std::move(next)), plain_(true) {
  for (const StoredAxis& axis : axes_) {
    wanted_.push_back(axis.domain ? 0 : volume % axis.size);
    if (!axis.domain) volume /= axis.size;
    if (!axis.domain && axis.size > 1) plain_ = false;
  }
}

bool VolumeReader::fill() {
  buffer_.resize(kBuffer - kBuffer % bytes_);
  there_ = next_(buffer_.data(), buffer_.size());
  there_ -= there_ % bytes_;
  taken_ += there_;
  from_ = 0;
  return there_ > 0;
}

size_t VolumeReader::read(void* to, size_t count) {
  if (plain_) {
    const size_t got = next_(to, count * bytes_);
    taken_ += got;
    return got / bytes_;
  }
  auto* out = static_cast<char*>(to);
  size_t got = 0;
  while (got < count) {
    if (from_ == there_ && !fill()) break;
    bool mine = true;
    for (size_t a = 1; a < axes_.size(); ++a) mine &= axes_[a].domain || at_[a] == wanted_[a];
    // What of the row along the fastest axis is in the buffer.
    size_t part = std::min(axes_[0].size - at_[0], (there_ - from_) / bytes_);
    if (mine && axes_[0].domain) {
      part = std::min(part, count - got);
      std::copy_n(&buffer_[from_], part * bytes_, out + got * bytes_);
      got += part;
    } else if (mine && at_[0] <= wanted_[0] && wanted_[0] - at_[0] < part) {
      std::copy_n(&buffer_[from_ + (wanted_[0] - at_[0]) * bytes_], bytes_, out + got * bytes_);
      ++got;
    }
    from_ += part * bytes_, at_[0] += part;
    if (at_[0] < axes_[0].size) continue;
    at_[0] = 0;
    for (size_t a = 1; a < axes_.size() && ++at_[a] == axes_[a].size; ++a) at_[a] = 0;
  }
  return got;
}

}  // namespace slicemorph
