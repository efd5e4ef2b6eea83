#pragma once

#include "io/atomic_file.h"

#include <ImfIO.h>

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

}  // namespace slicemorph
