#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>
#include <exception>
#include <vector>

namespace slicemorph {

/// Runs body(0) to body(count - 1), in parallel. What some throw is thrown when all are done, the first one's. (Out
/// of a plain tbb::parallel_for an exception cancels the loops within the other bodies, which then go on with half of
/// their results: a shape that is refused beside one that is fine was a segmentation fault.)
template <typename Body>
void parallelEach(size_t count, const Body& body) {
  std::vector<std::exception_ptr> errors(count);
  tbb::parallel_for(size_t(0), count, [&](size_t k) {
    try {
      body(k);
    } catch (...) {
      errors[k] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace slicemorph
