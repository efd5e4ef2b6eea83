#include "tools/slicer/slicer_events.h"

#include <algorithm>
#include <cstdio>

namespace slicemorph {
namespace {

/// Progress is told in steps of a two-hundredth: more than a bar shows, and little to read.
constexpr double kProgressStep = 0.005;

std::string inOneLine(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

}  // namespace

SlicerEvents::SlicerEvents(const std::string& filter) : filter_(filter) {
  cancelOnInterrupt();
  std::printf(
      "<filter-start>\n<filter-name>%s</filter-name>\n<filter-comment>starting</filter-comment>\n"
      "</filter-start>\n<filter-progress>0</filter-progress>\n",
      filter_.c_str());
  std::fflush(stdout);
}

void SlicerEvents::report(const char* stage, double fraction) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double progress = std::clamp(fraction, told_, 1.0);
  const bool enters = stage_ != stage;
  if (!enters && progress < told_ + kProgressStep) return;
  if (enters) std::printf("<filter-comment>%s</filter-comment>\n", stage);
  std::printf("<filter-progress>%.4g</filter-progress>\n", progress);
  std::fflush(stdout);
  stage_ = stage, told_ = progress;
}

void SlicerEvents::note(const Note& note) {
  if (note.severity == Severity::kDetail) return;
  const std::string line =
      (note.severity == Severity::kWarning ? "warning: " : "note: ") + inOneLine(note.sentence());
  const std::lock_guard<std::mutex> lock(mutex_);
  remarks_ += (remarks_.empty() ? "" : "; ") + line;
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

void SlicerEvents::fileWritten(const std::string& path, bool) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::printf("%s\n", path.c_str());
  std::fflush(stdout);
}

void SlicerEvents::finish() {
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  std::printf(
      "<filter-progress>1</filter-progress>\n<filter-end>\n<filter-name>%s</filter-name>\n"
      "<filter-time>%.3g</filter-time>\n</filter-end>\n",
      filter_.c_str(), seconds);
  std::fflush(stdout);
}

void WholeImages::note(const Note& note) {
  if (note.code == "image.volume-chosen")
    throw InputError(
        note.about,
        "holds several volumes: the layers of a segmentation whose segments overlap, or times; give a "
        "label map or one volume of it (by hand FILE:N takes the N-th, from 0)");
  to_.note(note);
}

}  // namespace slicemorph
