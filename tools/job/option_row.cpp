#include "tools/job/option_row.h"

#include "io/braces.h"
#include "slicemorph/errors.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>

namespace slicemorph {
namespace {

/// A number's limits in words: "8 to 1024", "above 0", "0 or more"; empty where it has none.
std::string describeRange(const OptionRange& range) {
  if (!std::isfinite(range.least)) return "";
  if (std::isfinite(range.most)) return formatNumber(range.least, 9) + " to " + formatNumber(range.most, 9);
  return range.open ? "above " + formatNumber(range.least) : formatNumber(range.least) + " or more";
}

[[noreturn]] void refuseNumber(const OptionRow& row, const std::string& text) {
  const OptionRange& range = row.range;
  const std::string said = spelledName(row) + " " + text, unit = row.unit.empty() ? "" : " " + row.unit;
  const bool whole = row.type == OptionType::kInteger;
  if (std::isfinite(range.least) && std::isfinite(range.most))
    throw InputError(said + " is out of range; it must be " + describeRange(range) + unit);
  if (range.open) throw InputError(said + " must be a number above " + formatNumber(range.least));
  if (std::isfinite(range.least)) throw InputError(said + " must be " + describeRange(range));
  throw InputError(said + " must be a " + (whole ? "whole" : "finite") + " number");
}

bool isWithin(double value, const OptionRange& range) {
  return std::isfinite(value) && (range.open ? value > range.least : value >= range.least) &&
         value <= range.most;
}

[[noreturn]] void refuseText(const OptionRow& row, const std::string& text, const char* kind) {
  const std::string limits = describeRange(row.range);
  throw InputError(spelledName(row) + " " + text + " is not a " + kind +
                   (limits.empty() ? "" : "; expected " + limits));
}

int parseInteger(const OptionRow& row, const std::string& text) {
  char* end = nullptr;
  errno = 0;
  const long value = std::strtol(text.c_str(), &end, 10);
  if (text.empty() || *end != 0) refuseText(row, text, "whole number");
  if (errno == ERANGE || long(int(value)) != value || !isWithin(double(value), row.range))
    refuseNumber(row, text);
  return int(value);
}

double parseNumber(const OptionRow& row, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0) refuseText(row, text, "number");
  if (!isWithin(value, row.range)) refuseNumber(row, text);
  return value;
}

/// `a, b or c`.
std::string listOfChoices(const std::vector<std::string>& choices) {
  std::string list;
  for (size_t i = 0; i < choices.size(); ++i)
    list += (i == 0 ? "" : i + 1 < choices.size() ? ", " : " or ") + choices[i];
  return list;
}

void checkChoice(const OptionRow& row, const std::string& text) {
  const std::string choice = row.braces ? splitBraces(text).name : text;
  if (row.choices.empty() || std::count(row.choices.begin(), row.choices.end(), choice)) return;
  throw InputError(spelledName(row) + " " + text + ": expected " + listOfChoices(row.choices) +
                   (row.braces ? ", its parameters in braces behind it: {NAME=VALUE,...}" : ""));
}

std::string joinedBy(const std::string& separator, const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// A field's value as the command line spells it.
struct SpelledField {
  std::string operator()(std::monostate) const { return ""; }
  std::string operator()(const bool* flag) const { return *flag ? "true" : ""; }
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const double* value) const { return formatExactly(*value); }
  std::string operator()(const std::string* text) const { return *text; }
  std::string operator()(const std::vector<std::string>* texts) const { return joinedBy(" ", *texts); }
};

}  // namespace

std::string titleOf(OptionGroup group) {
  switch (group) {
    case OptionGroup::kInputs:
      return "Inputs";
    case OptionGroup::kShape:
      return "Shape";
    case OptionGroup::kMatching:
      return "Matching";
    case OptionGroup::kOutputs:
      return "Outputs";
    case OptionGroup::kImages:
      return "Images";
    case OptionGroup::kPictures:
      return "Pictures";
    case OptionGroup::kFarm:
      break;
  }
  return "Farm";
}

std::string spelledName(const OptionRow& row) {
  if (!row.positional.empty()) return row.positional;
  return row.name == "output" ? "-o" : "--" + row.name;
}

std::string formOf(const OptionRow& row) {
  return row.choices.empty() || !row.form.empty() ? row.form : joinedBy("|", row.choices);
}

std::string helpOf(const OptionRow& row) {
  std::string limits = describeRange(row.range);
  const bool both = std::isfinite(row.range.least) && std::isfinite(row.range.most);
  if (!row.unit.empty())
    limits = both ? limits + " " + row.unit : row.unit + (limits.empty() ? "" : ", ") + limits;
  const std::string value = row.fallback.empty() ? defaultOf(row) : row.fallback;
  std::string facts = limits;
  if (row.type == OptionType::kFlag)
    facts = "default off";
  else if (!row.required && row.positional.empty())
    facts += (facts.empty() ? "" : "; ") + ("default " + (value.empty() ? "none" : value));
  return row.help + (facts.empty() ? "" : " (" + facts + ")");
}

std::string defaultOf(const OptionRow& row) { return spelledValue(row, JobOptions()); }

std::string spelledValue(const OptionRow& row, const JobOptions& options) {
  if (!row.field) return "";
  JobOptions copy = options;  // rows lead to fields that can be set
  const std::string value = std::visit(SpelledField(), row.field(copy));
  return value == "0" && !row.fallback.empty() ? "" : value;
}

void setField(const OptionRow& row, const std::vector<std::string>& texts, JobOptions& options) {
  const OptionField field = row.field(options);
  const std::string& text = texts.back();
  for (const std::string& each : texts) {
    if (each.empty()) throw InputError(spelledName(row) + " needs a value");
    checkChoice(row, each);
  }
  if (bool* const* flag = std::get_if<bool*>(&field)) **flag = text == "true";
  if (int* const* value = std::get_if<int*>(&field)) **value = parseInteger(row, text);
  if (double* const* value = std::get_if<double*>(&field)) **value = parseNumber(row, text);
  if (std::string* const* value = std::get_if<std::string*>(&field)) **value = text;
  if (std::vector<std::string>* const* value = std::get_if<std::vector<std::string>*>(&field))
    **value = texts;
}

}  // namespace slicemorph
