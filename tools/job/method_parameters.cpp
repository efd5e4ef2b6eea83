#include "tools/job/method_parameters.h"

#include "io/braces.h"
#include "slicemorph/errors.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace slicemorph {
namespace {

/// `1 to 1000 voxels`.
std::string limitsOf(const MethodParameter& parameter) {
  return formatNumber(parameter.least, 9) + " to " + formatNumber(parameter.most, 9) +
         (parameter.unit.empty() ? "" : " " + parameter.unit);
}

/// What follows a message on a parameter that there is not.
std::string describeAll(const std::string& method, const std::vector<MethodParameter>& parameters) {
  if (parameters.empty()) return "--method " + method + " has no parameters";
  std::string list;
  for (const MethodParameter& parameter : parameters)
    list += (list.empty() ? "" : "; ") + describeParameter(parameter);
  return "parameters of " + method + " are " + list;
}

double parsedValue(const std::string& said, const MethodParameter& parameter, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  // Limits are finite, so what is not finite is outside.
  if (!text.empty() && !*end && value >= parameter.least && value <= parameter.most &&
      (!parameter.whole || value == std::floor(value)))
    return value;
  throw InputError(said + ": " + parameter.name + " must be a " + (parameter.whole ? "whole " : "") +
                   "number from " + limitsOf(parameter) +
                   (text.empty() ? "; no value is given" : ", not " + text));
}

}  // namespace

double valueOf(const MethodParameter& parameter, const MethodValues& given) {
  const auto found = given.find(parameter.name);
  return found == given.end() ? parameter.fallback : found->second;
}

std::string describeParameter(const MethodParameter& parameter) {
  return parameter.name + ": " + parameter.help + " (" + limitsOf(parameter) + "; default " +
         formatExactly(parameter.fallback) + ")";
}

MethodValues parsedParameters(const std::string& said, const std::vector<MethodParameter>& parameters,
                              const BracedText& text) {
  MethodValues values;
  for (const BraceItem& item : text.items) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const MethodParameter& p) { return p.name == item.key; });
    if (found == parameters.end())
      throw InputError(said + ": there is no parameter '" + item.key + "'; " +
                       describeAll(text.name, parameters));
    if (!values.insert({item.key, parsedValue(said, *found, item.value)}).second)
      throw InputError(said + ": " + item.key + " is given twice");
  }
  if (!text.braces.empty() && values.empty())
    throw InputError(said + ": nothing stands in the braces; " + describeAll(text.name, parameters));
  return values;
}

}  // namespace slicemorph
