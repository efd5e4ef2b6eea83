#include "io/braces.h"

#include <algorithm>
#include <sstream>

namespace slicemorph {

BracedText splitBraces(const std::string& text) {
  const size_t open = text.rfind('{');
  if (text.empty() || text.back() != '}' || open == std::string::npos) return {text, "", {}};
  BracedText result{text.substr(0, open), text.substr(open), {}};
  std::istringstream items(text.substr(open + 1, text.size() - open - 2));
  for (std::string item; std::getline(items, item, ',');) {
    item.erase(std::remove(item.begin(), item.end(), ' '), item.end());
    const size_t equals = item.find('=');
    const bool pair = equals != std::string::npos;
    result.items.push_back({item, item.substr(0, equals), pair ? item.substr(equals + 1) : ""});
  }
  return result;
}

}  // namespace slicemorph
