#include "tools/job/option_set.h"

#include "tools/job/option_table.h"

#include <algorithm>
#include <stdexcept>

namespace slicemorph {

OptionSet::OptionSet(Command command) {
  for (const OptionRow& row : optionTable())
    if (row.isOf(command)) rows_.push_back(&row);
}

const OptionRow& OptionSet::row(const std::string& name) const {
  const auto found =
      std::find_if(rows_.begin(), rows_.end(), [&](const OptionRow* row) { return row->name == name; });
  if (found == rows_.end()) throw std::logic_error("the command has no option named " + name);
  return **found;
}

void OptionSet::set(const OptionRow& row, const std::vector<std::string>& texts) {
  setField(row, texts, values_);
  texts_[row.name] = texts;
}

bool OptionSet::given(const std::string& name) const {
  return texts_.count(row(name).name) > 0 || sources_.count(name) > 0;
}

std::vector<std::string> OptionSet::texts(const std::string& name) const {
  const auto found = texts_.find(row(name).name);
  return found == texts_.end() ? std::vector<std::string>() : found->second;
}

std::string OptionSet::source(const std::string& name) const {
  const auto found = sources_.find(row(name).name);
  return found == sources_.end() ? "" : found->second;
}

bool OptionSet::silenced(const OptionRow& row) const {
  const auto typed = [&](const std::string& name) { return texts_.count(name) && !sources_.count(name); };
  return typed(row.name) || std::any_of(row.excludes.begin(), row.excludes.end(), typed) ||
         std::any_of(row.silencedBy.begin(), row.silencedBy.end(), typed);
}

void OptionSet::checkExclusions() const {
  for (const OptionRow* row : rows_)
    for (const std::string& other : row->excludes)
      if (given(row->name) && given(other))
        refuse(row->name, spelledName(*row) + " and --" + other + " exclude each other; give one of them");
}

void OptionSet::refuse(const std::string& name, const std::string& message) const {
  throw InputError(source(name) + message);
}

OptionSet::Pairs OptionSet::frameSettings() const {
  Pairs pairs;
  for (const OptionRow* row : rows_) {
    const std::string value = row->inFrames ? spelledValue(*row, values_) : "";
    if (!value.empty()) pairs.push_back({row->name, value});
  }
  return pairs;
}

OptionSet::Pairs OptionSet::givenFor(OptionTarget target) const {
  Pairs pairs;
  for (const OptionRow* row : rows_) {
    if (row->target != target || !given(row->name)) continue;
    std::string all;
    for (const std::string& text : texts(row->name)) all += (all.empty() ? "" : " ") + text;
    pairs.push_back({row->name, all});
  }
  return pairs;
}

}  // namespace slicemorph
