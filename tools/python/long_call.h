#pragma once

#include "tools/job/job_events.h"

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace slicemorph {

namespace py = pybind11;

/// What one call from Python reports while it runs, kept for the thread that called.
class CallEvents : public JobEvents {
 public:
  struct Reported {
    std::string stage;
    double fraction = 0;
    bool operator==(const Reported& other) const {
      return stage == other.stage && fraction == other.fraction;
    }
  };

  void report(const char* stage, double fraction) override;
  bool cancelled() const override { return cancelled_; }
  void note(const Note& note) override;
  void fileWritten(const std::string& path, bool kept) override;

  void cancel() { cancelled_ = true; }
  Reported reported() const;
  const Notes& kept() const { return notes_; }
  const std::vector<std::string>& files() const { return files_; }

 private:
  mutable std::mutex mutex_;
  std::atomic<bool> cancelled_{false};
  Reported reported_;
  Notes notes_;
  std::vector<std::string> files_;
};

/// Waits without the interpreter's lock until `ready(time)` says so, passing what is reported on to `progress` (a callable
/// of stage and fraction, or None). An exception of it, or Ctrl-C, cancels the call and is thrown once that has ended.
void waitForCall(const std::function<bool(std::chrono::milliseconds)>& ready, CallEvents& events,
                 const py::object& progress);

/// Runs long work in a thread of its own, which must not touch Python's objects, so that the thread that called sees Ctrl-C
/// at any time. Returns, or throws, what it does.
template <typename Work>
auto runCall(CallEvents& events, const py::object& progress, Work work) {
  std::packaged_task<std::invoke_result_t<Work>()> task(std::move(work));
  auto result = task.get_future();
  std::thread worker(std::move(task));
  try {
    waitForCall(
        [&](std::chrono::milliseconds time) { return result.wait_for(time) == std::future_status::ready; },
        events, progress);
  } catch (...) {
    worker.join();
    throw;
  }
  worker.join();
  return result.get();
}

}  // namespace slicemorph
