#pragma once

#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"

#include <nlohmann/json.hpp>

#include <map>
#include <string>

namespace slicemorph {

/// Which frames of a sequence are done: the hidden file `.NAME.slicemorph` (NAME as given, with its ####)
/// beside the output, which exists while frames are made. It lets --resume tell the frames of the same job
/// (same settings, inputs of the same size and time, same build of the program) from older files of the same
/// names. Single frames have no log.
class ResumeLog {
 public:
  /// Reads the log of an earlier run where `settings.resume` is set and the log is of the same job.
  explicit ResumeLog(const MorphSettings& settings);

  /// Why the frames of an earlier run are not used, if there are some.
  const Notes& notes() const { return notes_; }
  /// Whether the frame was made and its file is still there at its size.
  bool has(const FrameJob& job) const;
  /// The frame's row of the report; null where that run measured nothing.
  nlohmann::ordered_json row(const FrameJob& job) const;
  /// Adds a finished frame and writes the log. Throws IoError.
  void add(const FrameJob& job, const nlohmann::ordered_json& row);
  void remove();

 private:
  struct Entry {
    std::uintmax_t bytes = 0;
    nlohmann::ordered_json row;
  };
  void read();

  std::string path_;  ///< empty: no sequence
  nlohmann::ordered_json job_;
  std::string program_;
  std::map<int, Entry> entries_;
  Notes notes_;
};

}  // namespace slicemorph
