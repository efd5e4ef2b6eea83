#include "io/image/length_unit.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

namespace slicemorph {

std::optional<double> millimetresOf(const std::string& unit) {
  std::string name;
  for (const unsigned char c : unit)
    if (c != ' ' && c != '"' && c != '\t') name += char(std::tolower(c));
  if (name.empty() || name == "?" || name == "???") return 1;
  // The sign for micro has two code points, and one in Latin-1; ImageJ writes it as an escape.
  for (const char* sign : {"\xc2\xb5", "\xce\xbc", "\xb5", "\\u00b5", "\\u03bc"})
    if (name.compare(0, std::string(sign).size(), sign) == 0) name.replace(0, std::string(sign).size(), "u");
  for (const char* plural : {"meters", "metres", "inches", "microns"})
    if (name.size() >= 6 && name.size() >= std::string(plural).size() &&
        name.compare(name.size() - std::string(plural).size(), std::string::npos, plural) == 0)
      name.resize(name.size() - (std::string(plural) == "inches" ? 2 : 1));
  if (name.size() > 5 && name.compare(name.size() - 5, 5, "metre") == 0)
    name.replace(name.size() - 5, 5, "meter");
  constexpr std::pair<const char*, double> kUnits[] = {
      {"mm", 1},          {"millimeter", 1},   {"um", 1e-3},    {"micrometer", 1e-3}, {"micron", 1e-3},
      {"nm", 1e-6},       {"nanometer", 1e-6}, {"cm", 10},      {"centimeter", 10},   {"dm", 100},
      {"decimeter", 100}, {"m", 1000},         {"meter", 1000}, {"inch", 25.4},       {"in", 25.4}};
  for (const auto& [known, factor] : kUnits)
    if (name == known) return factor;
  return std::nullopt;
}

void noteUnits(const std::vector<std::string>& units, Notes& notes) {
  std::vector<std::string> told;
  for (const std::string& unit : units) {
    const std::optional<double> factor = millimetresOf(unit);
    if (factor == 1 || std::find(told.begin(), told.end(), unit) != told.end()) continue;
    told.push_back(unit);
    std::ostringstream text;
    if (factor)
      text << "its lengths in '" << unit << "' became millimetres: multiplied by " << *factor;
    else
      text << "its unit of length '" << unit << "' is not known: taken as millimetres";
    notes.emplace_back(factor ? "image.unit-converted" : "image.unit-unknown",
                       factor ? Severity::kNote : Severity::kWarning, "", text.str());
  }
}

}  // namespace slicemorph
