#include "tools/job/frame_claims.h"

#include "io/sequence.h"
#include "slicemorph/errors.h"

#include <filesystem>

namespace slicemorph {
namespace {

std::vector<int> numbersOf(const std::vector<FrameJob>& frames) {
  std::vector<int> numbers;
  for (const FrameJob& frame : frames) numbers.push_back(frame.number);
  return numbers;
}

std::string framesNamed(const std::vector<int>& numbers) {
  return (numbers.size() == 1 ? "frame " : "frames ") + listOfNumbers(numbers);
}

/// One file of several frames, or one frame without a number.
bool isOneFile(const MorphSettings& settings) { return !OutputName(settings.output).isSequence(); }

/// What a file holds, in a word: of one that holds several frames also which ones.
std::string purposeOf(const MorphSettings& settings, const std::string& job) {
  return isOneFile(settings) && !settings.options.range.empty() ? job + "-" + settings.options.range : job;
}

}  // namespace

bool FrameClaims::take(const FrameJob& job) {
  const std::string purpose = purposeOf(settings_, log_.jobName());
  claim_ = std::make_unique<FileClaim>(job.path, purpose);
  if (!claim_->held()) {
    const ClaimOwner& other = claim_->other();
    if (other.purpose != purpose)
      throw IoError(job.path,
                    "is being written by " + other.name() +
                        ", of other settings, frames or inputs than these; choose another name, or end " +
                        (other.isKnownAlive ? "it" : "it and delete " + claimFileOf(job.path)));
    if (owner_.empty()) owner_ = other.name();
    left_.push_back(job);
    claim_.reset();
    return false;
  }
  const ResumeLog::Maker maker = log_.madeMeanwhile(job);
  if (maker == ResumeLog::Maker::kNobody) return true;
  claim_.reset();
  if (maker == ResumeLog::Maker::kOtherJob)
    throw IoError(job.path,
                  "another process has written it, of other settings or inputs than these, since "
                  "this one began; choose another name");
  left_.push_back(job);
  return false;
}

Notes FrameClaims::finish() {
  if (left_.empty()) return {};
  std::vector<int> going, missing;
  std::string elsewhere;
  for (const FrameJob& job : left_) {
    const std::optional<ClaimOwner> owner = claimOn(job.path);
    std::error_code error;
    // The claim first: a process frees it when its frame is in the log.
    const bool made = isOneFile(settings_) ? std::filesystem::exists(job.path, error)
                                           : log_.madeMeanwhile(job) == ResumeLog::Maker::kSameJob;
    if (owner && owner->isKnownAlive)
      going.push_back(job.number);
    else if (!made)
      missing.push_back(job.number);
    if (owner && !owner->isKnownAlive && !made && elsewhere.empty())
      elsewhere = owner->name() +
                  ", which cannot be looked at from here, claims it; if it has ended, delete " +
                  claimFileOf(job.path);
  }
  const auto were = [&](const std::vector<int>& numbers) {
    return (isOneFile(settings_) ? "" : framesNamed(numbers) + " ") + (numbers.size() == 1 ? "was" : "were") +
           " left to ";
  };
  if (!missing.empty())
    throw IoError(settings_.output, were(missing) + "another process and " +
                                        (missing.size() == 1 ? "is" : "are") + " not there" +
                                        (elsewhere.empty() ? "; run again with --resume" : ": " + elsewhere));
  std::string text = were(numbersOf(left_)) + (owner_.empty() ? "another process" : owner_) +
                     ", which makes " + (left_.size() == 1 ? "it" : "them") + ", too";
  if (!going.empty())
    text += isOneFile(settings_) ? "; it is still at it" : "; it is still making " + framesNamed(going);
  return {{"range.left-to-another", Severity::kNote, settings_.output, text}};
}

}  // namespace slicemorph
