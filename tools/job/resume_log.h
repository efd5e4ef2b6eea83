#pragma once

#include "slicemorph/note.h"
#include "tools/job/morph_settings.h"

#include <nlohmann/json.hpp>

#include <map>
#include <string>

namespace slicemorph {

/// Which frames of a sequence are done: the hidden file `.NAME.slicemorph` (NAME as given, with its ####) beside the
/// output, which exists until all frames of the whole sequence are made. Each process that makes some of them adds a
/// line for each; the last line of a frame counts. It lets --resume tell the frames of the same job (same settings,
/// inputs of the same size and time, same build of the program) from older files of the same names, and processes that
/// make frames of one sequence at the same time what the others have made. Single frames have no log.
class ResumeLog {
 public:
  /// Reads the lines that are there.
  explicit ResumeLog(const MorphSettings& settings);

  /// Why the frames of an earlier run are not used, if there are some and --resume was given.
  const Notes& notes() const { return notes_; }
  /// What makes the job the same as another, in one word: settings, inputs and build.
  std::string jobName() const { return job_ + "-" + program_; }
  /// Whether --resume was given, the frame was made by an earlier run, and its file is still there at its size.
  bool has(const FrameJob& job) const;
  /// The frame's row of the report; null where that run measured nothing.
  nlohmann::ordered_json row(const FrameJob& job) const;

  enum class Maker { kNobody, kSameJob, kOtherJob };
  /// Who else has made a frame, which this run has not, since this run began. Reads the lines that were added.
  Maker madeMeanwhile(const FrameJob& job);

  /// Adds the line of a finished frame. Throws IoError.
  void add(const FrameJob& job, const nlohmann::ordered_json& row);
  /// Removes the log if all frames of the whole sequence are made.
  void finish();

 private:
  struct Entry {
    std::uintmax_t bytes = 0;
    std::string job, program;
    nlohmann::ordered_json row;
    bool earlier = false;  ///< its line was there when this run began
  };
  void read(bool earlier);
  void noteOthers();
  bool isOfThisJob(const Entry& entry) const { return entry.job == job_ && entry.program == program_; }
  bool isThere(const FrameJob& job) const;

  const MorphSettings& settings_;
  std::string path_;           ///< empty: no sequence
  std::string job_, program_;  ///< the settings and inputs, and the build, as the lines tell them
  std::uintmax_t seen_ = 0;    ///< bytes of the file that are read
  std::map<int, Entry> entries_;
  Notes notes_;
};

}  // namespace slicemorph
