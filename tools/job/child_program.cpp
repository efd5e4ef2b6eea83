#include "tools/job/child_program.h"

#include "slicemorph/errors.h"
#include "tools/job/stopwatch.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

extern char** environ;

namespace slicemorph {
namespace {

constexpr const char* kSelf = "/proc/self/exe";
/// How often cancelling is asked for, milliseconds.
constexpr int kWait = 100;

/// A pipe whose ends are closed with it and in programs that are started.
struct Pipe {
  Pipe() {
    if (::pipe2(ends, O_CLOEXEC) != 0) throw IoError(kSelf, std::string("no pipe: ") + std::strerror(errno));
  }
  ~Pipe() {
    ::close(ends[0]);
    closeInput();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void closeInput() {
    if (ends[1] >= 0) ::close(ends[1]);
    ends[1] = -1;
  }
  int ends[2] = {-1, -1};  ///< to read from, and to write to
};

pid_t start(const std::vector<std::string>& arguments, const Pipe& said) {
  std::error_code ignored;
  const std::string path = std::filesystem::read_symlink(kSelf, ignored).string();
  std::vector<std::string> words = {path.empty() ? kSelf : path};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, said.ends[1], STDERR_FILENO);
  pid_t process = -1;
  const int failed = ::posix_spawn(&process, kSelf, &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) throw IoError(words[0], std::string("cannot be started: ") + std::strerror(failed));
  return process;
}

/// Reads until the program closes its end, as it does when it ends. Returns false where it was cancelled.
bool readAll(int from, std::string& text, const Progress& cancel) {
  for (;;) {
    if (cancel.cancelled()) return false;
    pollfd ready = {from, POLLIN, 0};
    if (::poll(&ready, 1, kWait) <= 0) continue;
    char buffer[4096];
    const ssize_t count = ::read(from, buffer, sizeof buffer);
    if (count == 0) return true;
    if (count > 0) text.append(buffer, size_t(count));
    if (count < 0 && errno != EINTR) throw IoError(kSelf, std::strerror(errno));
  }
}

double secondsOf(const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); }

}  // namespace

ChildEnd runOwnProgram(const std::vector<std::string>& arguments, const Progress& cancel) {
  Stopwatch watch;
  Pipe said;
  const pid_t process = start(arguments, said);
  said.closeInput();
  ChildEnd end;
  const bool whole = readAll(said.ends[0], end.said, cancel);
  if (!whole) ::kill(process, SIGKILL);
  int status = 0;
  rusage usage = {};
  while (::wait4(process, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  if (!whole) throw Cancelled();
  end.seconds = watch.lap();
  end.processorSeconds = secondsOf(usage.ru_utime) + secondsOf(usage.ru_stime);
  end.peakBytes = std::int64_t(usage.ru_maxrss) * 1024;
  end.done = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (WIFSIGNALED(status))
    end.trouble =
        "ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return end;
}

}  // namespace slicemorph
