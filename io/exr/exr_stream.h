#pragma once

#include "io/atomic_file.h"

#include <ImfIO.h>
#include <ImfThreading.h>
#include <tbb/global_control.h>

namespace slicemorph {

/// OpenEXR's output into an AtomicFile.
class ExrStream : public Imf::OStream {
 public:
  ExrStream(AtomicFile& file, const std::string& name) : Imf::OStream(name.c_str()), stream_(file.stream()) {}

  void write(const char bytes[], int count) override {
    stream_.write(bytes, count);
    position_ += uint64_t(count);
  }
  /// To be called after OpenEXR's file object is gone and before the AtomicFile is committed.
  void flush() { stream_.flush(); }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override {
    stream_.seekp(std::streamoff(position));
    position_ = position;
  }

 private:
  std::ostream& stream_;
  uint64_t position_ = 0;
};

/// Level of ZIP compression, 1 to 9. Measured: a fifth faster than OpenEXR's default of 4, with files
/// 1 % larger.
constexpr int kExrZipLevel = 2;

/// Number of threads that the caller allows.
inline int threadCount() {
  return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

/// The same number, after setting OpenEXR's global thread pool to it.
inline int exrThreads() {
  Imf::setGlobalThreadCount(threadCount());
  return threadCount();
}

}  // namespace slicemorph
