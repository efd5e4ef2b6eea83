#include "tools/commands/terminal_progress.h"

#include "engine/numerics/readable.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

/// Seconds between two drawings of the line, and after which it is drawn anew where nothing is reported.
constexpr double kRedrawn = 0.1, kCountedDown = 1;

/// Global, since a signal handler can access nothing else.
volatile sig_atomic_t interrupted = 0;

extern "C" void onInterrupt(int) { interrupted = 1; }

/// A time left: it is an estimate, so that from two minutes on seconds are told by tens.
std::string spokenTimeLeft(double seconds) {
  const double step = seconds < 120 ? 1 : 10, rounded = step * std::ceil(seconds / step);
  return rounded < 10 ? std::to_string(int(rounded)) + " s" : readableDuration(rounded);
}

}  // namespace

void cancelOnInterrupt() {
  struct sigaction action = {};
  action.sa_handler = onInterrupt;
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // The terminal was closed; under nohup this is ignored, and stays so.
  struct sigaction now = {};
  if (sigaction(SIGHUP, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

TerminalProgress::TerminalProgress(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO)) {}

TerminalProgress::~TerminalProgress() { clear(); }

double TerminalProgress::now() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

bool TerminalProgress::cancelled() const {
  if (shown_) {
    // Whoever holds the lock draws.
    const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
    if (lock && width_ > 0 && now() - lastDrawn_ >= kCountedDown) draw();
  }
  return interrupted != 0;
}

void TerminalProgress::report(const char* stage, double fraction) {
  if (!shown_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  left_.report(stage, fraction, now());
  const bool fresh = stage_ != stage;
  stage_ = stage;
  if (fresh || now() - lastDrawn_ >= kRedrawn) draw();
}

/// The lock must be held.
void TerminalProgress::draw() const {
  lastDrawn_ = now();
  std::string line = stage_ + " " + std::to_string(int(100 * left_.fraction())) + "%";
  if (const std::optional<double> left = left_.at(lastDrawn_)) line += ", " + spokenTimeLeft(*left) + " left";
  const size_t width = line.size();
  if (width < width_) line.append(width_ - width, ' ');
  width_ = width;
  std::fprintf(stderr, "\r%s", line.c_str());
  std::fflush(stderr);
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
