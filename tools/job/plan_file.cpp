#include "tools/job/plan_file.h"

#include "io/atomic_file.h"
#include "io/sequence.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/input_names.h"
#include "tools/job/program_build.h"

#include <nlohmann/json.hpp>

#include <zlib.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

/// Begins the file; the number is raised whenever what follows changes.
const std::string kPlanMark = "slicemorph plan ", kPlanVersion = "2\n";
/// Most bytes of decisions: a lattice of a million nodes and ten objects takes 120 million.
constexpr std::uint64_t kMostDecisions = std::uint64_t(1) << 31;

/// Options that name files, but for the inputs.
bool isPath(const std::string& name) { return name == "config"; }

bool decidesPlans(const OptionRow& row) {
  if (row.name == "config") return true;
  if (row.name == "plan" || row.name == "check-landmarks") return false;
  return row.group == OptionGroup::kInputs || row.group == OptionGroup::kShape ||
         row.group == OptionGroup::kMatching || (row.group == OptionGroup::kImages && row.name != "like");
}

std::string spokenTexts(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : " ") + text;
  return all;
}

/// By zlib; nothing where memory is short. The bytes are mostly runs of zeros: looking for longer matches takes six
/// times as long, and saves 2 %.
std::optional<std::string> compressed(const std::string& bytes) {
  constexpr int kWindow = 15, kMemory = 8;  // zlib's defaults
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kWindow, kMemory, Z_RLE) != Z_OK)
    return std::nullopt;
  std::string packed(deflateBound(&stream, uLong(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(&packed[0]);
  stream.avail_out = uInt(packed.size());
  const int state = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return state == Z_STREAM_END ? std::optional(std::move(packed)) : std::nullopt;
}

}  // namespace

PlanFile planFileOf(const OptionSet& options) {
  PlanFile plan;
  plan.program = programBuild();
  for (const OptionRow* row : options.rows()) {
    std::vector<std::string> texts = options.texts(row->name);
    if (!decidesPlans(*row) || texts.empty()) continue;
    if (row->name == "inputs" || isPath(row->name))
      for (std::string& text : texts) text = wholePath(text);
    plan.options.emplace_back(row->name, std::move(texts));
  }
  return plan;
}

void writePlanFile(const std::string& path, const PlanFile& plan) {
  Json head = {{"program", plan.program},
               {"frame", plan.frame},
               {"options", Json::object()},
               {"bytes", plan.decisions.size()}};
  for (const auto& [name, texts] : plan.options) head["options"][name] = texts;
  if (plan.decisions.size() > kMostDecisions)
    throw IoError(path, "would hold more than 2 GiB; plan fewer inputs at once");
  const std::optional<std::string> packed = compressed(plan.decisions);
  if (!packed) throw IoError(path, "cannot be compressed: there is too little memory");
  AtomicFile file(path);
  file.write(kPlanMark + kPlanVersion);
  file.write(head.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  file.write(*packed);
  file.commit();
}

PlanFile readPlanFile(const std::string& path) {
  const std::string bytes = readWholeFile(path);
  if (bytes.compare(0, kPlanMark.size(), kPlanMark) != 0)
    throw IoError(path, "is no plan; `slicemorph plan` writes them");
  if (bytes.compare(kPlanMark.size(), kPlanVersion.size(), kPlanVersion) != 0)
    throw IoError(path, "is a plan of another version of slicemorph; make it anew");
  const auto damaged = [&]() -> IoError { return IoError(path, "is damaged or cut off; make it anew"); };
  const size_t from = kPlanMark.size() + kPlanVersion.size(), end = bytes.find('\n', from);
  if (end == std::string::npos) throw damaged();
  const Json head = Json::parse(bytes.substr(from, end - from), nullptr, false);
  if (!head.is_object() || !head.contains("options") || !head["options"].is_object() ||
      !head.contains("bytes") || !head["bytes"].is_number_unsigned() || !head.contains("frame") ||
      !head["frame"].is_number_unsigned())
    throw damaged();
  PlanFile plan;
  plan.program = head.value("program", std::string("unknown"));
  plan.frame = head["frame"].get<size_t>();
  for (const auto& [name, texts] : head["options"].items()) {
    if (!texts.is_array() ||
        !std::all_of(texts.begin(), texts.end(), [](const Json& t) { return t.is_string(); }))
      throw damaged();
    plan.options.emplace_back(name, texts.get<std::vector<std::string>>());
  }
  const std::uint64_t whole = head["bytes"].get<std::uint64_t>();
  // zlib makes nothing smaller than by a factor of 1032, so a short file cannot ask for much memory.
  if (whole > kMostDecisions || whole > 1032 * std::uint64_t(bytes.size())) throw damaged();
  plan.decisions.resize(size_t(whole));
  uLongf size = uLongf(whole);
  const int state =
      uncompress(reinterpret_cast<Bytef*>(&plan.decisions[0]), &size,
                 reinterpret_cast<const Bytef*>(bytes.data() + end + 1), uLong(bytes.size() - end - 1));
  if (state != Z_OK || size != whole) throw damaged();
  return plan;
}

int firstPlanNumber(const std::string& name) {
  const InputFrame first = framesOf(parseInput(name)).front();
  return first.number - int(readPlanFile(first.input.path).frame);
}

Notes applyPlanFile(OptionSet& options, size_t beside) {
  const std::string& name = options.values().planFile;
  if (name.empty()) return {};
  std::string path = name;
  if (OutputName(name).isSequence()) path = framesOf(parseInput(name)).front().input.path;
  const PlanFile plan = readPlanFile(path);
  for (const auto& [key, texts] : plan.options) {
    const auto row = std::find_if(options.rows().begin(), options.rows().end(),
                                  [&, key = key](const OptionRow* r) { return r->name == key; });
    if (row == options.rows().end())
      throw IoError(path,
                    "was made with '" + key + "', which this command does not know; make a plan without it");
    if (key == "inputs") {
      std::vector<std::string> inputs = texts;
      const std::vector<std::string> given = options.texts(key);
      inputs.insert(inputs.end(), given.begin(), given.end());
      if (given.size() <= beside) options.set(**row, inputs);
      continue;
    }
    if (!options.given(key)) {
      options.set(**row, texts);
      continue;
    }
    std::vector<std::string> given = options.texts(key);
    if (isPath(key))
      for (std::string& text : given) text = wholePath(text);
    if (given != texts)
      options.refuse(key, spelledName(**row) + " " + spokenTexts(given) + ": the plan " + path +
                              " was made with " + spokenTexts(texts) +
                              "; leave the option out, or make the plan anew");
  }
  for (const OptionRow* row : options.rows()) {
    // What is carried may be an image, of which these tell; objects that they change are not the plan's.
    const bool ofCarried = beside > 0 && row->group == OptionGroup::kImages;
    if (decidesPlans(*row) && row->name != "inputs" && row->name != "config" && !ofCarried &&
        options.given(row->name) &&
        std::none_of(plan.options.begin(), plan.options.end(),
                     [&](const auto& option) { return option.first == row->name; }))
      options.refuse(row->name, spelledName(*row) + ": the plan " + path +
                                    " was made without it; leave it out, or make the plan anew");
  }
  if (plan.program == programBuild()) return {};
  return {{"plan.other-program", Severity::kNote, path,
           "was made by version " + plan.program + ", and this is " + programBuild() +
               ": frames may differ in their last digits"}};
}

}  // namespace slicemorph
