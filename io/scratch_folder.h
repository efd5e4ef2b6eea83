#pragma once

#include <string>

namespace slicemorph {

/// A folder among the system's temporary files that nobody else can look or write into, under a name that nobody can
/// foresee. Goes away with all that is in it. Throws IoError.
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
