// Preloaded into the program (LD_PRELOAD), makes a chosen call of the system library fail, changes a file under the
// reader's hands, or lets clocks jump. Only files in one folder count, so that messages get through.
//   FAULT_FOLDER   the folder
//   FAULT_CALL     the call, by the system library's name: write, fsync, rename ...
//   FAULT_NTH      which of these calls, from 1
//   FAULT_ACTION   errno that it fails with; `short`: writes half of what it was given; `remove`, `cut`: its file is
//                  removed, or cut to half its length, before the call is made
//   FAULT_STAYS    1: all later calls fail, too, as where a disk is full
//   FAULT_COUNTS   file that tells, at the end, how often each call was made, and under `fired` how often one failed
//   FAULT_CLOCK    back: each look at a clock is a second earlier than the one before; jump: days forth and back
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

namespace {

enum Call {
  kOpen,
  kRead,
  kPread,
  kFread,
  kMmap,
  kWrite,
  kWritev,
  kPwrite,
  kFwrite,
  kFsync,
  kFtruncate,
  kClose,
  kRename,
  kMkdir,
  kCalls
};
constexpr const char* kNames[kCalls] = {"open",   "read",   "pread", "fread",     "mmap",  "write",  "writev",
                                        "pwrite", "fwrite", "fsync", "ftruncate", "close", "rename", "mkdir"};

std::atomic<long> counts[kCalls], fired, looks;

const char* setting(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// What FAULT_ACTION asks of this call.
enum class Fate { kNone, kFails, kShort, kRemoved, kCut };

/// Counts a call on a file, and tells its fate.
Fate fateOf(Call call, const char* path) {
  const char* folder = setting("FAULT_FOLDER");
  if (!*folder || !path || std::strncmp(path, folder, std::strlen(folder)) != 0) return Fate::kNone;
  const long number = ++counts[call], nth = std::atol(setting("FAULT_NTH"));
  if (nth == 0 || std::strcmp(setting("FAULT_CALL"), kNames[call]) != 0) return Fate::kNone;
  const bool stays = std::strcmp(setting("FAULT_STAYS"), "1") == 0;
  if (number != nth && !(stays && number > nth)) return Fate::kNone;
  ++fired;
  const char* action = setting("FAULT_ACTION");
  if (std::strcmp(action, "short") == 0) return Fate::kShort;
  if (std::strcmp(action, "remove") == 0) return Fate::kRemoved;
  if (std::strcmp(action, "cut") == 0) return Fate::kCut;
  errno = std::atoi(action);
  return Fate::kFails;
}

/// Does to the file what its fate is.
bool failsAfter(Fate fate, const char* path) {
  struct stat status;
  if (fate == Fate::kRemoved) ::unlink(path);
  if (fate == Fate::kCut && ::stat(path, &status) == 0) ::truncate(path, status.st_size / 2);
  return fate == Fate::kFails;
}

/// The path of an open file.
struct PathOf {
  explicit PathOf(int file) {
    char link[64];
    const int error = errno;
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t size = ::readlink(link, text, sizeof text - 1);
    text[size > 0 ? size : 0] = 0;
    errno = error;
  }
  char text[4096];
};

bool fails(Call call, const char* path) { return failsAfter(fateOf(call, path), path); }
bool fails(Call call, int file) { return fails(call, PathOf(file).text); }

template <class Function>
Function* real(Function*, const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define REAL(name) static const auto original = real(&::name, #name)

__attribute__((destructor)) void tellCounts() {
  const char* path = setting("FAULT_COUNTS");
  if (!*path) return;
  char text[1024];
  int size = std::snprintf(text, sizeof text, "fired %ld\n", fired.load());
  for (int call = 0; call < kCalls; ++call)
    size +=
        std::snprintf(text + size, sizeof text - size_t(size), "%s %ld\n", kNames[call], counts[call].load());
  const long file = ::syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (file >= 0) ::syscall(SYS_write, file, text, size), ::syscall(SYS_close, file);
}

/// Seconds that a clock is wrong by.
long wrongBy() {
  const char* clock = setting("FAULT_CLOCK");
  const long look = ++looks;
  if (std::strcmp(clock, "back") == 0) return -look;
  if (std::strcmp(clock, "jump") == 0) return look % 2 ? 86400 : -86400;
  return 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  REAL(open);
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return fails(kOpen, path) ? -1 : original(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  REAL(open64);
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return fails(kOpen, path) ? -1 : original(path, flags, mode);
}
FILE* fopen(const char* path, const char* mode) {
  REAL(fopen);
  return fails(kOpen, path) ? nullptr : original(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  REAL(fopen64);
  return fails(kOpen, path) ? nullptr : original(path, mode);
}
ssize_t read(int file, void* bytes, size_t size) {
  REAL(read);
  return fails(kRead, file) ? -1 : original(file, bytes, size);
}
ssize_t pread(int file, void* bytes, size_t size, off_t at) {
  REAL(pread);
  return fails(kPread, file) ? -1 : original(file, bytes, size, at);
}
ssize_t pread64(int file, void* bytes, size_t size, off64_t at) {
  REAL(pread64);
  return fails(kPread, file) ? -1 : original(file, bytes, size, at);
}
size_t fread(void* bytes, size_t size, size_t count, FILE* file) {
  REAL(fread);
  return fails(kFread, fileno(file)) ? 0 : original(bytes, size, count, file);
}
void* mmap(void* at, size_t size, int protection, int flags, int file, off_t offset) {
  REAL(mmap);
  return file >= 0 && fails(kMmap, file) ? MAP_FAILED : original(at, size, protection, flags, file, offset);
}
void* mmap64(void* at, size_t size, int protection, int flags, int file, off64_t offset) {
  REAL(mmap64);
  return file >= 0 && fails(kMmap, file) ? MAP_FAILED : original(at, size, protection, flags, file, offset);
}
ssize_t write(int file, const void* bytes, size_t size) {
  REAL(write);
  const PathOf path(file);
  const Fate fate = fateOf(kWrite, path.text);
  if (fate == Fate::kShort) return original(file, bytes, (size + 1) / 2);
  return failsAfter(fate, path.text) ? -1 : original(file, bytes, size);
}
ssize_t writev(int file, const iovec* parts, int count) {
  REAL(writev);
  return fails(kWritev, file) ? -1 : original(file, parts, count);
}
ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  REAL(pwrite);
  const PathOf path(file);
  const Fate fate = fateOf(kPwrite, path.text);
  if (fate == Fate::kShort) return original(file, bytes, (size + 1) / 2, at);
  return failsAfter(fate, path.text) ? -1 : original(file, bytes, size, at);
}
ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  return pwrite(file, bytes, size, at);
}
size_t fwrite(const void* bytes, size_t size, size_t count, FILE* file) {
  REAL(fwrite);
  return fails(kFwrite, fileno(file)) ? 0 : original(bytes, size, count, file);
}
int fsync(int file) {
  REAL(fsync);
  return fails(kFsync, file) ? -1 : original(file);
}
int ftruncate(int file, off_t size) {
  REAL(ftruncate);
  return fails(kFtruncate, file) ? -1 : original(file, size);
}
int ftruncate64(int file, off64_t size) { return ftruncate(file, size); }
/// Linux has closed the file also where it tells of an error.
int close(int file) {
  REAL(close);
  const bool failed = fails(kClose, file);
  const int error = errno, result = original(file);
  if (failed) errno = error;
  return failed ? -1 : result;
}
int rename(const char* from, const char* to) {
  REAL(rename);
  return fails(kRename, to) ? -1 : original(from, to);
}
int mkdir(const char* path, mode_t mode) {
  REAL(mkdir);
  return fails(kMkdir, path) ? -1 : original(path, mode);
}
int clock_gettime(clockid_t clock, timespec* time) {
  REAL(clock_gettime);
  const int result = original(clock, time);
  time->tv_sec += wrongBy();
  return result;
}
}
