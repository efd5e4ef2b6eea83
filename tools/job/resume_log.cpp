#include "tools/job/resume_log.h"

#include "io/atomic_file.h"
#include "slicemorph/io/input.h"
#include "tools/job/describe_job.h"
#include "tools/job/program_build.h"

#include <filesystem>
#include <fstream>

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

}  // namespace

ResumeLog::ResumeLog(const MorphSettings& settings) {
  if (!OutputName(settings.output).isSequence()) return;
  const fs::path output(settings.output);
  path_ = (output.parent_path() / ("." + output.filename().string() + ".slicemorph")).string();
  program_ = programBuild();
  job_ = describeJob(settings);
  for (const auto& [name, value] : settings.frameSettings) job_["options"][name] = value;
  job_["files"] = Json::array();
  for (const std::string& input : settings.inputs) job_["files"].push_back(fingerprint(input));
  if (settings.resume) read();
}

void ResumeLog::read() {
  std::ifstream file(path_);
  // A log that cannot be read is ignored: the frames are made again.
  const Json log = Json::parse(file, nullptr, false);
  if (!log.is_object() || !log.contains("job") || !log.contains("frames")) return;
  const auto refuse = [&](const char* code, const std::string& why) {
    notes_.emplace_back(code, Severity::kNote, "--resume", why + "; all frames are made anew");
  };
  if (log["job"] != job_)
    return refuse("resume.other-job", "the frames that are there are of other settings or inputs");
  // Frames of two builds need not match.
  const std::string program = log.value("program", std::string("unknown"));
  if (program != program_)
    return refuse("resume.other-program",
                  "the frames that are there were made by version " + program + ", and this is " + program_);
  for (const auto& [number, entry] : log["frames"].items())
    entries_[std::stoi(number)] = {entry.value("bytes", std::uintmax_t(0)), entry.value("row", Json())};
}

bool ResumeLog::has(const FrameJob& job) const {
  const auto entry = entries_.find(job.number);
  std::error_code error;
  return entry != entries_.end() && fs::file_size(job.path, error) == entry->second.bytes && !error;
}

Json ResumeLog::row(const FrameJob& job) const { return entries_.at(job.number).row; }

void ResumeLog::add(const FrameJob& job, const Json& row) {
  if (path_.empty()) return;
  entries_[job.number] = {fs::file_size(job.path), row};
  Json log = {{"program", program_}, {"job", job_}, {"frames", Json::object()}};
  for (const auto& [number, entry] : entries_)
    log["frames"][std::to_string(number)] = {{"bytes", entry.bytes}, {"row", entry.row}};
  writeTextFile(path_, log.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

void ResumeLog::remove() {
  std::error_code error;
  if (!path_.empty()) fs::remove(path_, error);
}

}  // namespace slicemorph
