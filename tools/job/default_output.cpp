#include "tools/job/default_output.h"

#include "io/file_claim.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/input_spec.h"
#include "tools/job/option_values.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// Names that are joined are cut to this, in bytes. File systems take 255 for the whole: four names, what joins and ends them,
/// and what files have in front and behind while they are written.
constexpr size_t kLongestName = 45;

/// A name for what a command makes, and the folder of its own that it goes into; empty: none.
struct OutputIdea {
  std::string name, folder, ending;
};

/// The last part of an input's path without number and extensions: "smoke" of `shots/smoke.####.vdb:density`.
std::string plainName(const std::string& input) {
  fs::path path = parseInput(input).path;
  if (!path.has_filename()) path = path.parent_path();  // folder/
  if (path == "." || path == ".." || path.empty()) path = fs::absolute(path).lexically_normal().parent_path();
  std::string name = path.filename().string();
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) name.resize(name.size() - fullExtensionOf(name).size());
  for (const char* ending : {".seg", ".rt"})
    if (endsWith(name, ending)) name.resize(name.size() - std::string(ending).size());
  while (!name.empty() && (name.back() == '#' || name.back() == '.' || name.back() == '_')) name.pop_back();
  std::replace(name.begin(), name.end(), '#', '_');
  if (name.size() > kLongestName) {
    size_t end = kLongestName;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0) == 0x80)
      --end;  // within a letter of UTF-8
    name.resize(end);
  }
  return name.empty() ? "slicemorph" : name;
}

/// An image's own form where it can be written, else NIfTI, which every program reads.
std::string imageEnding(const std::string& input) {
  const std::string own = fullExtensionOf(parseInput(input).path);
  return !own.empty() && isImageOutput("x" + own) ? own : ".nii.gz";
}

bool anyMoves(const std::vector<std::string>& inputs) {
  return std::any_of(inputs.begin(), inputs.end(), isMovingInput);
}

OutputIdea ideaOfMorph(const OptionSet& options) {
  const JobOptions& given = options.values();
  const bool blend = options.given("weights");
  const std::string name = joinedNames(given.inputs, blend ? "_and_" : "_to_");
  const bool one =
      blend || (options.given("at") ? given.at.find(',') == std::string::npos : given.frames == 1);
  const bool images = std::all_of(given.inputs.begin(), given.inputs.end(), isImageInput) &&
                      methodNamed(methodChoice(given.method).name).can.images;
  const std::string ending = images ? imageEnding(given.inputs[0]) : ".vdb";
  if (one && !anyMoves(given.inputs)) return {name, "", ending};
  return {name, name, ".####" + ending};
}

/// What is carried lies among the inputs, as the last one, but with --field.
OutputIdea ideaOfApply(const JobOptions& given) {
  const std::string& what = given.inputs.back();
  const bool images = std::all_of(given.inputs.begin(), given.inputs.end(), isImageInput);
  if (given.field)
    return {joinedNames(given.inputs, "_to_") + "_field", "", images ? imageEnding(given.inputs[0]) : ".vdb"};
  return {plainName(what) + "_carried", "", isImageInput(what) ? imageEnding(what) : extensionOf(what)};
}

OutputIdea ideaOfRender(const JobOptions& given) {
  const std::string name = plainName(given.inputs[0]);
  if (given.inputs.size() == 1 && given.turntable == 0 && !anyMoves(given.inputs)) return {name, "", ".png"};
  return {name, name + "_pictures", ".####.png"};
}

OutputIdea ideaFor(Command command, const OptionSet& options) {
  const JobOptions& given = options.values();
  switch (command) {
    case kMorph:
      return ideaOfMorph(options);
    case kApply:
      return ideaOfApply(given);
    case kRender:
      return ideaOfRender(given);
    case kSlice:
      return {plainName(given.input), plainName(given.input) + "_slices", ".####.exr"};
    case kRetime:
      return {plainName(given.input), plainName(given.input) + "_retimed", ".####.vdb"};
    default:
      break;
  }
  const bool pictures = extensionOf(parseInput(given.input).path) == ".exr" && given.spacing.empty();
  return {plainName(given.input) + (pictures ? "_rebuilt" : "_dense"), "",
          pictures ? ".vdb" : imageEnding(given.input)};
}

bool isWritable(const fs::path& folder) {
  return ::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0;
}

}  // namespace

std::string joinedNames(const std::vector<std::string>& inputs, const std::string& between) {
  std::string name;
  for (size_t k = 0; k < inputs.size(); ++k)
    if (inputs.size() <= 4 || k == 0 || k + 1 == inputs.size())
      name += (name.empty() ? "" : between) + plainName(inputs[k]);
  return name;
}

std::string freeName(const std::string& name, const std::function<bool(const std::string&)>& isFree) {
  for (int n = 1;; ++n)
    if (const std::string one = n == 1 ? name : name + "_" + std::to_string(n); isFree(one)) return one;
}

DefaultOutput::DefaultOutput(Command command, OptionSet& options) {
  const JobOptions& given = options.values();
  const std::vector<std::string> inputs =
      given.inputs.empty() && !given.input.empty() ? std::vector<std::string>{given.input} : given.inputs;
  if (!given.output.empty() || given.printConfig || inputs.size() < (command == kMorph ? 2 : 1)) return;
  if (given.resume) options.refuse("output", "--resume goes on with an output; name it by -o");
  const OutputIdea idea = ideaFor(command, options);
  // What is carried is what the result is a copy of.
  const std::string& beside = command == kApply && !given.field ? inputs.back() : inputs.front();
  checkInputExists(beside);
  fs::path path = parseInput(beside).path;
  if (!path.has_filename()) path = path.parent_path();
  fs::path folder = path.parent_path();
  if (!isWritable(folder)) folder.clear();
  if (!isWritable(folder))
    options.refuse("output", "-o is not given, and neither the folder of " + beside +
                                 " nor the current one can be written to; name an output by -o");
  if (idea.folder.empty()) {
    // Claimed before it is looked for: of two programs that look at once one alone gets the name. Not by the file's own
    // claim, which is that of the frame.
    const auto isFree = [&](const std::string& name) {
      const fs::path file = folder / (name + idea.ending);
      claim_ = std::make_unique<FileClaim>(file.string() + ".name", "output");
      return claim_->held() && !fs::exists(fs::symlink_status(file));
    };
    output_ = (folder / (freeName(idea.name, isFree) + idea.ending)).string();
  } else {
    // Also false where something else has the name; errors, as of a full disk, are thrown.
    const auto isFree = [&](const std::string& name) {
      return !fs::exists(fs::symlink_status(folder / name)) && fs::create_directory(folder / name);
    };
    folder_ = (folder / freeName(idea.folder, isFree)).string();
    output_ = folder_ + "/" + idea.name + idea.ending;
  }
  options.set(options.row("output"), {output_});
}

DefaultOutput::~DefaultOutput() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove(folder_, ignored);  // fails where it is not empty
}

Notes DefaultOutput::notes() const {
  if (output_.empty()) return {};
  return {{"output.chosen", Severity::kNote, "", "without -o the result is " + output_}};
}

}  // namespace slicemorph
