#pragma once

#include "io/atomic_file.h"

#include <ImfIO.h>
#include <ImfThreading.h>
#include <tbb/global_control.h>

namespace slicemorph {

/// An EXR on its way into a file that appears whole or not at all.
class ExrStream : public Imf::OStream {
 public:
  ExrStream(AtomicFile& file, const std::string& name) : Imf::OStream(name.c_str()), stream_(file.stream()) {}

  void write(const char bytes[], int count) override {
    stream_.write(bytes, count);
    position_ += uint64_t(count);
  }
  /// Before the file is committed, and after OpenEXR has ended it.
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

/// ZIP's level, of 9: a fifth faster than OpenEXR's own 4, for 1 % larger files.
constexpr int kExrZipLevel = 2;

/// As many threads as the job may use.
inline int threadCount() {
  return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

/// The same, which OpenEXR is then ready to use.
inline int exrThreads() {
  Imf::setGlobalThreadCount(threadCount());
  return threadCount();
}

}  // namespace slicemorph
