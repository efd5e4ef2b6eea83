#pragma once

#include <string>
#include <vector>

/// The names by which keys and regions refer to a job's inputs, and by which files of jobs and plans name them.
namespace slicemorph {

/// An input or file by its whole path; what follows a file's name, as a grid's, stays behind it.
std::string wholePath(const std::string& input);

/// Name of an input's file without folder, extensions, `:grid` and `.####`.
std::string stemOfInput(const std::string& input);

/// Index of the input with that name: the input as typed, its stem, its number from 1, or, where none
/// of these fits, its letter from `a`. Throws InputError, listing all names, where there is none or
/// more than one.
size_t inputNamed(const std::string& name, const std::vector<std::string>& inputs);

/// The stem if only this input has it, else the number.
std::string nameOfInput(size_t input, const std::vector<std::string>& inputs);

}  // namespace slicemorph
