#include "io/file_claim.h"

#include "io/atomic_file.h"
#include "slicemorph/errors.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

namespace slicemorph {
namespace {

/// Tries to read a claim before one that stays unreadable counts as left by a process that died while it wrote it, and
/// the time between them: two seconds in all, where writing it takes microseconds.
constexpr int kClaimTries = 100;
constexpr std::chrono::milliseconds kClaimWait(20);

/// When a process began, in ticks since the system did: the 22nd field of /proc/PID/stat (proc(5)); 0: there is no such
/// process.
long long startOf(long process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  // The second field, the program's name in brackets, may hold anything.
  const size_t name = text.rfind(')');
  if (name == std::string::npos) return 0;
  std::istringstream fields(text.substr(name + 1));
  std::string field;
  for (int i = 3; i <= 22; ++i) fields >> field;
  return std::atoll(field.c_str());
}

ClaimOwner thisProcess(const std::string& purpose) {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  std::error_code error;
  return {host, std::filesystem::read_symlink("/proc/self/ns/pid", error).string(), ::getpid(),
          startOf(::getpid()), purpose};
}

std::string textOf(const ClaimOwner& owner) {
  return "host " + owner.host + "\nprocesses " + owner.processes + "\npid " + std::to_string(owner.process) +
         "\nstarted " + std::to_string(owner.started) + "\npurpose " + owner.purpose + "\nend\n";
}

/// None where the text is not whole.
std::optional<ClaimOwner> ownerIn(const std::string& text) {
  ClaimOwner owner;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const size_t blank = line.find(' ');
    const std::string key = line.substr(0, blank),
                      value = blank == std::string::npos ? "" : line.substr(blank + 1);
    if (key == "end") return owner;
    if (key == "host") owner.host = value;
    if (key == "processes") owner.processes = value;
    if (key == "pid") owner.process = std::atol(value.c_str());
    if (key == "started") owner.started = std::atoll(value.c_str());
    if (key == "purpose") owner.purpose = value;
  }
  return std::nullopt;
}

std::string readAll(int file) {
  std::string text(4096, '\0');
  const ssize_t count = ::pread(file, text.data(), text.size(), 0);
  text.resize(count < 0 ? 0 : size_t(count));
  return text;
}

bool writeAll(int file, const std::string& text) {
  return ::pwrite(file, text.data(), text.size(), 0) == ssize_t(text.size()) &&
         ::ftruncate(file, off_t(text.size())) == 0;
}

/// A file of the system that is closed at the end.
struct OpenFile {
  explicit OpenFile(int file) : file(file) {}
  ~OpenFile() {
    if (file >= 0) ::close(file);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int file;
};

/// The text of a claim; empty where there is none.
std::string claimText(const std::string& claim) {
  const OpenFile open(::open(claim.c_str(), O_RDONLY | O_CLOEXEC));
  return open.file < 0 ? "" : readAll(open.file);
}

bool isElsewhere(const ClaimOwner& owner) {
  const ClaimOwner here = thisProcess("");
  return owner.host != here.host || owner.processes != here.processes;
}

bool isDead(const ClaimOwner& owner) {
  return !isElsewhere(owner) && (startOf(owner.process) != owner.started || owner.started == 0);
}

/// Makes the file of a claim; false where it exists. Throws IoError.
bool createClaim(const std::string& path, const std::string& claim, const std::string& text) {
  const OpenFile open(::open(claim.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (open.file < 0 && errno == EEXIST) return false;
  if (open.file >= 0 && writeAll(open.file, text)) return true;
  const std::string reason = std::strerror(errno);
  if (open.file >= 0) ::unlink(claim.c_str());
  throw IoError(path, "cannot be created: " + reason);
}

/// Puts another text into a claim whose owner is dead. False where somebody else did so, or the claim is gone: of
/// those who try one alone holds the lock and still finds the dead one's text.
bool takeOver(const std::string& claim, const std::string& dead, const std::string& text) {
  const OpenFile open(::open(claim.c_str(), O_RDWR | O_CLOEXEC));
  if (open.file < 0 || (::flock(open.file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)) return false;
  struct stat opened = {}, there = {};
  if (::fstat(open.file, &opened) != 0 || ::stat(claim.c_str(), &there) != 0) return false;
  return opened.st_ino == there.st_ino && readAll(open.file) == dead && writeAll(open.file, text);
}

}  // namespace

std::string ClaimOwner::name() const { return "process " + std::to_string(process) + " on " + host; }

std::string claimFileOf(const std::string& path) {
  const std::filesystem::path file(path);
  return (file.parent_path() / ("." + file.filename().string() + ".claim")).string();
}

std::optional<ClaimOwner> claimOn(const std::string& path) {
  std::optional<ClaimOwner> owner = ownerIn(claimText(claimFileOf(path)));
  if (!owner || isDead(*owner)) return std::nullopt;
  owner->isKnownAlive = !isElsewhere(*owner);
  return owner;
}

FileClaim::FileClaim(const std::string& path, const std::string& purpose)
    : path_(path), claim_(claimFileOf(path)) {
  const std::string mine = textOf(thisProcess(purpose));
  for (int tries = 1; !held_; ++tries) {
    held_ = createClaim(path_, claim_, mine);
    if (held_) return;
    const std::string text = claimText(claim_);
    const std::optional<ClaimOwner> owner = ownerIn(text);
    if (owner && !isDead(*owner)) {
      other_ = *owner, other_.isKnownAlive = !isElsewhere(*owner);
      return;
    }
    if (owner || tries >= kClaimTries) held_ = takeOver(claim_, text, mine);
    if (held_ && owner) removeUnfinished(path_, owner->process);
    if (!held_ && tries >= 2 * kClaimTries)
      throw IoError(claim_, "is of a process that has ended, and cannot be taken over; delete it");
    if (!held_) std::this_thread::sleep_for(kClaimWait);
  }
}

FileClaim::~FileClaim() {
  if (held_) ::unlink(claim_.c_str());
}

}  // namespace slicemorph
