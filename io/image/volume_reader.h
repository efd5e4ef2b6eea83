#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace slicemorph {

/// An axis of the numbers in a file.
struct StoredAxis {
  size_t size = 1;
  bool domain = true;  ///< of space; else it tells volumes apart: times, components of a voxel
};

/// Writes the next bytes of a file's data; returns how many there were: less where they end.
using ByteReader = std::function<size_t(void* to, size_t bytes)>;

/// Picks one volume out of numbers that are stored along several axes, as they come.
class VolumeReader {
 public:
  /// `axes`: the fastest first. `volume`: counted along the axes that are not of space, the fastest of them first.
  /// `bytes`: of a number.
  VolumeReader(std::vector<StoredAxis> axes, size_t volume, size_t bytes, ByteReader next);

  /// The next `count` numbers of the volume. Returns how many there were.
  size_t read(void* to, size_t count);
  /// Bytes of the file that were read.
  size_t bytesRead() const { return taken_; }

 private:
  bool fill();

  std::vector<StoredAxis> axes_;
  std::vector<size_t> wanted_;  ///< the index along each axis that is not of space
  std::vector<size_t> at_;      ///< of the next number of buffer_
  size_t bytes_;
  ByteReader next_;
  bool plain_;                ///< the file has no other volume
  std::vector<char> buffer_;  ///< whole numbers
  size_t from_ = 0, there_ = 0, taken_ = 0;
};

}  // namespace slicemorph
