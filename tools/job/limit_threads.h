#pragma once

#include <tbb/global_control.h>

#include <memory>

namespace slicemorph {

/// As long as this lives, no more than so many threads are used; 0: all.
inline std::unique_ptr<tbb::global_control> limitThreads(int threads) {
  if (threads == 0) return nullptr;
  return std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, size_t(threads));
}

}  // namespace slicemorph
