#include "tools/python/long_call.h"

#include <optional>

namespace slicemorph {
namespace {

/// Time between two looks at Ctrl-C and progress: nobody notices a twentieth of a second.
constexpr std::chrono::milliseconds kBetweenLooks(50);

void look(CallEvents& events, const py::object& progress, CallEvents::Reported& shown) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  const CallEvents::Reported now = events.reported();
  if (progress.is_none() || now == shown) return;
  shown = now;
  progress(now.stage, now.fraction);
}

}  // namespace

void CallEvents::report(const char* stage, double fraction) {
  const std::lock_guard<std::mutex> lock(mutex_);
  reported_ = {stage, fraction};
}

void CallEvents::note(const Note& note) {
  const std::lock_guard<std::mutex> lock(mutex_);
  notes_.push_back(note);
}

void CallEvents::fileWritten(const std::string& path, bool) {
  const std::lock_guard<std::mutex> lock(mutex_);
  files_.push_back(path);
}

CallEvents::Reported CallEvents::reported() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return reported_;
}

void waitForCall(const std::function<bool(std::chrono::milliseconds)>& ready, CallEvents& events,
                 const py::object& progress) {
  CallEvents::Reported shown;
  std::optional<py::error_already_set> raised;
  for (;;) {
    {
      const py::gil_scoped_release released;
      if (ready(kBetweenLooks)) break;
    }
    if (raised) continue;
    try {
      look(events, progress, shown);
    } catch (const py::error_already_set& error) {
      raised.emplace(error);
      events.cancel();
    }
  }
  if (raised) throw *raised;
}

}  // namespace slicemorph
