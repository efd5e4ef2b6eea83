#pragma once

#include <optional>
#include <string>

namespace slicemorph {

/// The process that has claimed a file.
struct ClaimOwner {
  std::string host;
  std::string
      processes;  ///< the Linux namespace that its number is from: the same number is another process elsewhere
  long process = 0;  ///< its number
  long long started =
      0;  ///< when it began, in the system's ticks; tells it from a later one of the same number
  std::string purpose;  ///< what it writes, as the constructor below was told
  bool isKnownAlive =
      true;  ///< it runs here; false: it is on another machine, where nobody can look from here

  /// "process 4711 on farm3".
  std::string name() const;
};

/// A process's claim on a file that it will write: `.NAME.claim` beside it, which another process that is to write the
/// same file finds. It is freed by the destructor. One whose owner, on this machine, is dead counts for nothing; one
/// from another machine is respected, since nobody can tell from here whether its owner lives.
class FileClaim {
 public:
  /// Claims `path` unless another process has; held() tells. `purpose`: one line that tells what will be written.
  /// What a dead owner left half written is removed. Throws IoError where no file can be made there.
  FileClaim(const std::string& path, const std::string& purpose);
  ~FileClaim();
  FileClaim(const FileClaim&) = delete;
  FileClaim& operator=(const FileClaim&) = delete;

  bool held() const { return held_; }
  /// Who has the claim, where this one is not held.
  const ClaimOwner& other() const { return other_; }

 private:
  std::string path_, claim_;
  bool held_ = false;
  ClaimOwner other_;
};

/// The file that holds a claim on `path`.
std::string claimFileOf(const std::string& path);
/// Who claims `path` now, this process included; none: nobody, or somebody who is dead.
std::optional<ClaimOwner> claimOn(const std::string& path);

}  // namespace slicemorph
