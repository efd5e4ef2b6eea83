#include "tools/job/resume_log.h"

#include "io/sequence.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"
#include "tools/job/describe_job.h"
#include "tools/job/program_build.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json fileFingerprint(const std::string& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  return {{"bytes", fs::file_size(path, error)}, {"time", std::int64_t(time.time_since_epoch().count())}};
}

/// Size and time of an input's file or files, without its `:grid`.
Json fingerprint(const std::string& input) {
  const std::vector<std::string> names = filesOfInput(parseInput(input));
  if (names.size() == 1) return fileFingerprint(names[0]);
  Json files = Json::array();
  for (const std::string& file : names) files.push_back(fileFingerprint(file));
  return files;
}

/// All that frames depend on, but for the program, in a word.
std::string nameOfJob(const MorphSettings& settings) {
  Json job = describeJob(settings);
  for (const auto& [name, value] : settings.frameSettings)
    if (name != "output") job["options"][name] = value;
  job.erase("output");  // the log is beside it, by whichever path
  job["files"] = Json::array();
  for (size_t k = 0; k < settings.inputs.size(); ++k)
    job["files"].push_back(heldAt(settings.held, k) ? Json("in memory") : fingerprint(settings.inputs[k]));
  char text[17];
  std::snprintf(text, sizeof text, "%016zx",
                std::hash<std::string>()(job.dump(-1, ' ', false, Json::error_handler_t::replace)));
  return text;
}

}  // namespace

ResumeLog::ResumeLog(const MorphSettings& settings)
    : settings_(settings), job_(nameOfJob(settings)), program_(programBuild()) {
  if (!OutputName(settings.output).isSequence()) return;
  const fs::path output(settings.output);
  path_ = (output.parent_path() / ("." + output.filename().string() + ".slicemorph")).string();
  read(true);
  if (settings.resume) noteOthers();
}

void ResumeLog::read(bool earlier) {
  std::ifstream file(path_, std::ios::binary);
  file.seekg(std::streamoff(seen_));
  for (std::string line; std::getline(file, line);) {
    // A line without its end is still being written, or was cut when its writer was killed: then one more follows.
    if (file.eof()) break;
    seen_ += line.size() + 1;
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object() || !json.contains("frame") || !json["frame"].is_number_integer()) continue;
    entries_[json["frame"]] = {json.value("bytes", std::uintmax_t(0)), json.value("job", std::string()),
                               json.value("program", std::string("unknown")), json.value("row", Json()),
                               earlier};
  }
}

/// Frames of other settings, or of two builds, need not match.
void ResumeLog::noteOthers() {
  if (entries_.empty() && seen_ > 0)
    notes_.emplace_back("resume.other-program", Severity::kNote, "--resume",
                        "what " + path_ +
                            " tells of the frames that are there is of another version; all "
                            "frames are made anew");
  std::vector<int> ofOtherJob, ofOtherProgram;
  std::string program;
  size_t kept = 0;
  for (const FrameJob& job : settings_.frames) {
    const auto entry = entries_.find(job.number);
    if (!job.wanted || entry == entries_.end()) continue;
    if (isOfThisJob(entry->second))
      ++kept;
    else if (entry->second.program != program_)
      ofOtherProgram.push_back(job.number), program = entry->second.program;
    else
      ofOtherJob.push_back(job.number);
  }
  const auto add = [&](const char* code, const std::vector<int>& numbers, const std::string& what) {
    const std::string which = kept ? "of the frames that are there " + listOfNumbers(numbers) + " "
                                   : std::string("the frames that are there ");
    notes_.emplace_back(code, Severity::kNote, "--resume",
                        which + what + "; " + (kept ? "these" : "all frames") + " are made anew");
  };
  if (!ofOtherProgram.empty())
    add("resume.other-program", ofOtherProgram,
        "were made by version " + program + ", and this is " + program_);
  if (!ofOtherJob.empty()) add("resume.other-job", ofOtherJob, "are of other settings or inputs");
}

bool ResumeLog::isThere(const FrameJob& job) const {
  const auto entry = entries_.find(job.number);
  std::error_code error;
  return entry != entries_.end() && isOfThisJob(entry->second) &&
         fs::file_size(job.path, error) == entry->second.bytes && !error;
}

bool ResumeLog::has(const FrameJob& job) const {
  return settings_.resume && isThere(job) && entries_.at(job.number).earlier;
}

Json ResumeLog::row(const FrameJob& job) const { return entries_.at(job.number).row; }

ResumeLog::Maker ResumeLog::madeMeanwhile(const FrameJob& job) {
  if (path_.empty()) return Maker::kNobody;
  read(false);
  const auto entry = entries_.find(job.number);
  if (entry == entries_.end() || entry->second.earlier) return Maker::kNobody;
  return isOfThisJob(entry->second) ? Maker::kSameJob : Maker::kOtherJob;
}

void ResumeLog::add(const FrameJob& job, const Json& row) {
  if (path_.empty()) return;
  Json line = {
      {"frame", job.number}, {"bytes", fs::file_size(job.path)}, {"program", program_}, {"job", job_}};
  if (!row.is_null()) line["row"] = row;
  // Before it an end for a line that was cut.
  const std::string text = "\n" + line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  // A line that was cut counts for nothing: it is written again, as one.
  ssize_t done = -1;
  if (file >= 0) do {
      done = ::write(file, text.data(), text.size());
    } while (done < 0 ? errno == EINTR : done < ssize_t(text.size()));
  const bool written = done == ssize_t(text.size());
  const std::string reason = std::strerror(errno);
  if (file >= 0) ::close(file);
  if (!written) throw IoError(path_, "cannot be written: " + reason);
  read(false);
}

void ResumeLog::finish() {
  if (path_.empty()) return;
  read(false);
  const std::vector<FrameJob>& all = settings_.frames;
  if (!std::all_of(all.begin(), all.end(), [this](const FrameJob& job) { return isThere(job); })) return;
  std::error_code error;
  fs::remove(path_, error);
}

}  // namespace slicemorph
