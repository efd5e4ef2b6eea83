#pragma once

#include <string>
#include <vector>

/// What a job's inputs are called where keys and regions speak of them.
namespace slicemorph {

/// Name of an input's file without folder, extensions, `:grid` and `.####`.
std::string stemOfInput(const std::string& input);

/// Index of the input that a name stands for: as it is typed, its stem, its number from 1, or, where no stem
/// is that, a letter from `a`. Throws InputError, listing all names, where there is none or more than one.
size_t inputNamed(const std::string& name, const std::vector<std::string>& inputs);

/// The stem where that stands for this input alone, else its number.
std::string nameOfInput(size_t input, const std::vector<std::string>& inputs);

}  // namespace slicemorph
