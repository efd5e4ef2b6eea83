#include "tools/job/input_names.h"

#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_file.h"

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

/// `input 1 'amphora' (assets/amphora.ply), input 2 ...`
std::string inputList(const std::vector<std::string>& inputs) {
  std::string list;
  for (size_t k = 0; k < inputs.size(); ++k)
    list += (k ? ", " : "") + std::to_string(k + 1) + " '" + stemOfInput(inputs[k]) + "' (" + inputs[k] + ")";
  return list;
}

template <class Is>
std::vector<size_t> inputsThat(const std::vector<std::string>& inputs, const Is& is) {
  std::vector<size_t> found;
  for (size_t k = 0; k < inputs.size(); ++k)
    if (is(k)) found.push_back(k);
  return found;
}

/// Inputs that are typed like `name`; else those whose stem or number it is; else that whose letter it is.
std::vector<size_t> inputsCalled(const std::string& name, const std::vector<std::string>& inputs) {
  const std::vector<size_t> typed = inputsThat(inputs, [&](size_t k) { return inputs[k] == name; });
  if (!typed.empty()) return typed;
  const std::vector<size_t> known = inputsThat(
      inputs, [&](size_t k) { return stemOfInput(inputs[k]) == name || std::to_string(k + 1) == name; });
  if (!known.empty()) return known;
  return inputsThat(inputs, [&](size_t k) { return k < 26 && name == std::string(1, char('a' + k)); });
}

}  // namespace

std::string wholePath(const std::string& input) {
  return input.empty() || input[0] == '/' ? input : (std::filesystem::current_path() / input).string();
}

std::string stemOfInput(const std::string& input) {
  std::string path = parseInput(input).path;
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  fs::path name = fs::path(path).filename();
  if (extensionOf(path) == ".gz") name = name.stem();
  std::string stem = name.stem().string();
  stem.erase(std::min(stem.find('#'), stem.size()));
  while (stem.size() > 1 && (stem.back() == '.' || stem.back() == '_')) stem.pop_back();
  return stem.empty() ? name.string() : stem;
}

size_t inputNamed(const std::string& name, const std::vector<std::string>& inputs) {
  const std::vector<size_t> found = inputsCalled(name, inputs);
  if (found.size() == 1) return found[0];
  throw InputError("'" + name + "' is " + (found.empty() ? "no input" : "more than one input") +
                   "; inputs are " + inputList(inputs) +
                   (found.empty() ? "" : "; tell them apart by number or as typed"));
}

std::string nameOfInput(size_t input, const std::vector<std::string>& inputs) {
  const std::string stem = stemOfInput(inputs[input]);
  return inputsCalled(stem, inputs) == std::vector<size_t>{input} ? stem : std::to_string(input + 1);
}

}  // namespace slicemorph
