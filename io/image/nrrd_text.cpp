#include "io/image/nrrd_text.h"

#include "io/paths.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <utility>
#include <vector>

namespace slicemorph {
namespace {

/// A header is far shorter; what has no end is none.
constexpr std::uint64_t kMostBytes = 1 << 24;

std::string trimmedField(std::string text) {
  text.erase(0, std::min(text.find_first_not_of(" \t"), text.size()));
  text.erase(text.find_last_not_of(" \t\r") + 1);
  return text;
}

/// Names of fields have several spellings.
std::string fieldName(std::string name) {
  name = lowered(std::move(name));
  const std::pair<const char*, const char*> spellings[] = {
      {"datafile", "data file"}, {"lineskip", "line skip"}, {"byteskip", "byte skip"},
      {"axismins", "axis mins"}, {"axismaxs", "axis maxs"}, {"centerings", "centers"}};
  for (const auto& [other, own] : spellings)
    if (name == other) return own;
  return name;
}

/// Which axes have a direction, by the field `space directions`: vectors in brackets, `none` for axes without.
std::vector<bool> directedAxes(const std::string& directions) {
  std::vector<bool> directed;
  for (size_t at = 0; at < directions.size(); ++at) {
    if (directions[at] == '(') {
      directed.push_back(true);
      at = std::min(directions.find(')', at), directions.size());
    } else if (directions[at] != ' ' && directions[at] != '\t') {
      directed.push_back(false);
      at = std::min(directions.find_first_of(" \t(", at), directions.size()) - 1;
    }
  }
  return directed;
}

/// Whether a field of values for each axis tells something of an axis that has a direction: a number, a unit.
bool tellsOfDirected(const std::string& name, const std::string& value, const std::vector<bool>& directed) {
  const std::vector<std::string> words = quotedWords(value);
  for (size_t a = 0; a < std::min(words.size(), directed.size()); ++a)
    if (directed[a] &&
        (name == "units" ? !words[a].empty() && words[a] != "???" : lowered(words[a]) != "nan"))
      return true;
  return false;
}

}  // namespace

std::vector<std::string> quotedWords(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> std::ws, in >> std::quoted(word);) words.push_back(word);
  return words;
}

NrrdText readNrrdText(const std::string& path) {
  const std::uint64_t bytes = sizeOfInput(path);
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line.size() > 16 || line.compare(0, 7, "NRRD000") != 0)
    throw IoError(path, "is no NRRD file: it does not begin with NRRD0001 to NRRD0005");
  NrrdText text;
  std::vector<std::pair<std::string, std::string>> lines;
  bool list = false;
  for (text.end = bytes; std::getline(in, line);) {
    if (line.empty() || line == "\r") {
      text.end = std::uint64_t(in.tellg());
      break;
    }
    if (!in.eof() && std::uint64_t(in.tellg()) > kMostBytes)
      throw IoError(path, "is damaged: its NRRD header does not end");
    if (list) {
      text.dataFiles += trimmedField(line) + "\n";
      continue;
    }
    const size_t mark = line.find(':');
    if (line[0] == '#' || mark == std::string::npos) continue;
    if (line.compare(mark, 2, ":=") == 0) {
      text.keys[line.substr(0, mark)] = line.substr(mark + 2, line.find_last_not_of('\r') - mark - 1);
      continue;
    }
    const std::string name = fieldName(trimmedField(line.substr(0, mark))),
                      value = trimmedField(line.substr(mark + 1));
    if (text.fields.count(name))
      throw IoError(path, "is damaged: its header has the field '" + name + "' twice");
    text.fields[name] = value;
    lines.emplace_back(name, value);
    list = name == "data file" && value.compare(0, 4, "LIST") == 0;
  }
  const bool directions = text.hasDirections();
  // `dimension` and then `space` stand first: others need them.
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) {
    const auto rank = [](const std::string& name) {
      return name == "dimension" ? 0 : name == "space" || name == "space dimension" ? 1 : 2;
    };
    return rank(a.first) < rank(b.first);
  });
  const std::vector<bool> directed = directedAxes(text.field("space directions"));
  text.rest = "NRRD0005\n";
  for (const auto& [name, value] : lines) {
    if (name == "data file" || name == "line skip" || name == "byte skip" || name == "encoding") continue;
    // Beside directions the library takes these of no axis, also where they tell of those without a direction alone.
    const bool leftOut =
        directions && (name == "spacings" || name == "units" || name == "axis mins" || name == "axis maxs");
    if (!leftOut)
      text.rest += name + ": " + value + "\n";
    else if (tellsOfDirected(name, value, directed))
      text.dropped += (text.dropped.empty() ? "'" : ", '") + name + "'";
  }
  // The encoding is not the library's business: it knows no bzip2. Text has no byte order.
  const std::string encoding = lowered(text.field("encoding"));
  const bool asText = encoding == "text" || encoding == "txt" || encoding == "ascii";
  text.rest +=
      asText && !text.fields.count("endian") ? "endian: little\nencoding: raw\n\n" : "encoding: raw\n\n";
  return text;
}

}  // namespace slicemorph
