#pragma once

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

struct BracedText;

/// One parameter of a method, as `--method NAME{PARAMETER=VALUE}` has it; help, checks and messages are made of it.
struct MethodParameter {
  std::string name;
  std::string help;  ///< what it is: "radius of the bounding ball"
  std::string unit;  ///< "voxels"; empty: none
  double fallback = 0;
  double least = 0, most = 0;  ///< both are allowed
  bool whole = false;          ///< no fractions
};

/// Values by the names of parameters.
using MethodValues = std::map<std::string, double>;

/// The value that was given, else the default.
double valueOf(const MethodParameter& parameter, const MethodValues& given);

/// What a parameter is, its limits and default: "steps: at most so many (1 to 1000; default 20)".
std::string describeParameter(const MethodParameter& parameter);

/// Reads what stands in braces behind a method's name. `said` is the option as it was typed, for messages: `--method
/// levelset{steps=0}`. Throws InputError for parameters that there are not, values out of range, empty braces.
MethodValues parsedParameters(const std::string& said, const std::vector<MethodParameter>& parameters,
                              const BracedText& text);

}  // namespace slicemorph
