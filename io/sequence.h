#pragma once

#include <string>
#include <vector>

namespace slicemorph {

/// One file of a numbered sequence.
struct SequenceFile {
  int number = 0;
  std::string path;
};

/// The files that a name with a run of # stands for (`smoke.####.vdb`: smoke.0001.vdb, smoke.0002.vdb ...),
/// by number. Throws IoError where there is none.
std::vector<SequenceFile> findSequence(const std::string& pattern);

}  // namespace slicemorph
