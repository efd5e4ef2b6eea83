#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace slicemorph {

/// Runs `work` on so many threads, whatever cores this process may use: the default arena has no more slots than
/// those.
template <class Work>
auto withThreads(size_t threads, const Work& work) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena{int(threads)};
  return arena.execute(work);
}

}  // namespace slicemorph
