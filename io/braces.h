#pragma once

#include <string>
#include <vector>

namespace slicemorph {

/// One `key=value` in braces, or one that is no such pair.
struct BraceItem {
  std::string text;        ///< as it was typed, without blanks
  std::string key, value;  ///< the value is empty where there is no `=`
};

/// What is named, and what stands in braces behind the name: `blade.obj{scale=0.001,upright=z}`.
struct BracedText {
  std::string name;
  std::string braces;  ///< as typed, with the braces; empty: there are none
  std::vector<BraceItem> items;
};

/// Splits a text at the braces at its end; a text that does not end with a closing one, or has no opening one, is a name
/// alone.
BracedText splitBraces(const std::string& text);

}  // namespace slicemorph
