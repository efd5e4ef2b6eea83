#pragma once

#include <string>

namespace slicemorph {

/// A folder among the system's temporary files that only this user can read or write, with an unpredictable
/// name. The destructor removes it and all that is in it. The constructor throws IoError.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace slicemorph
