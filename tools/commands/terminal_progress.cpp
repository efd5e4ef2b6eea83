#include "tools/commands/terminal_progress.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

/// Global, since a signal handler can access nothing else.
volatile sig_atomic_t interrupted = 0;

extern "C" void onInterrupt(int) { interrupted = 1; }

std::string formatSeconds(double seconds) {
  const long s = std::lround(seconds);
  char text[32];
  if (s >= 3600)
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  else
    std::snprintf(text, sizeof text, "%ld:%02ld", s / 60, s % 60);
  return text;
}

}  // namespace

void cancelOnInterrupt() {
  struct sigaction action = {};
  action.sa_handler = onInterrupt;
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

TerminalProgress::TerminalProgress(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO)) {}

TerminalProgress::~TerminalProgress() { clear(); }

bool TerminalProgress::cancelled() const { return interrupted != 0; }

void TerminalProgress::report(const char* stage, double fraction) {
  if (!shown_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  const Clock::time_point now = Clock::now();
  if (stage_ != stage) {
    stage_ = stage;
    stageFraction_ = fraction;
    stageStart_ = now;
  } else if (now - lastDrawn_ < std::chrono::milliseconds(100)) {
    return;
  }
  lastDrawn_ = now;
  std::string line = stage_ + " " + std::to_string(int(100 * std::clamp(fraction, 0.0, 1.0))) + "%" +
                     timeLeft(now, fraction);
  const size_t width = line.size();
  if (width < width_) line.append(width_ - width, ' ');
  width_ = width;
  std::fprintf(stderr, "\r%s", line.c_str());
  std::fflush(stderr);
}

/// Estimated from the current stage alone, since stages differ in speed; empty in its first half second.
std::string TerminalProgress::timeLeft(Clock::time_point now, double fraction) const {
  const double done = fraction - stageFraction_;
  const double seconds = std::chrono::duration<double>(now - stageStart_).count();
  if (done <= 0 || seconds < 0.5) return {};
  return ", " + formatSeconds(seconds * (1 - fraction) / done) + " left";
}

void TerminalProgress::clear() {
  if (!shown_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!width_) return;
  std::fprintf(stderr, "\r%s\r", std::string(width_, ' ').c_str());
  std::fflush(stderr);
  width_ = 0;
}

}  // namespace slicemorph
