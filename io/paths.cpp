#include "io/paths.h"

#include "slicemorph/errors.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace slicemorph {
namespace {

std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

InputName splitAt(const std::string& input, size_t colon) {
  const std::string grid = input.substr(colon + 1);
  if (grid.empty()) throw InputError(input + ": no grid is named after the colon");
  return {input.substr(0, colon), grid};
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

}  // namespace

std::string extensionOf(const std::string& path) {
  return lowered(std::filesystem::path(path).extension().string());
}

std::uint64_t sizeOfInput(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw IoError(path + ": no such file");
  if (error) throw IoError(path + " cannot be read: " + error.message());
  if (std::filesystem::is_directory(status)) throw IoError(path + " is a folder, not a file");
  if (!std::filesystem::is_regular_file(status)) throw IoError(path + " is no regular file");
  if (::access(path.c_str(), R_OK) != 0) throw IoError(path + " cannot be read: " + std::strerror(errno));
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) throw IoError(path + " cannot be read: " + error.message());
  if (size == 0) throw IoError(path + " is empty");
  return size;
}

InputName splitInput(const std::string& input) {
  if (exists(input)) return {input, ""};
  const std::string mark = ".vdb:", text = lowered(input);
  size_t found = text.find(mark);
  for (size_t at = found; at != std::string::npos; at = text.find(mark, at + 1)) {
    const size_t end = at + mark.size() - 1;
    if (exists(input.substr(0, end))) {
      found = at;
      break;
    }
  }
  if (found == std::string::npos) return {input, ""};
  return splitAt(input, found + mark.size() - 1);
}

bool isSequenceInput(const std::string& input) {
  return !exists(splitSequenceInput(input).path) &&
         std::filesystem::path(splitSequenceInput(input).path).filename().string().find('#') !=
             std::string::npos;
}

InputName splitSequenceInput(const std::string& input) {
  const size_t mark = lowered(input).rfind(".vdb:");
  return mark == std::string::npos ? InputName{input, ""} : splitAt(input, mark + 4);
}

}  // namespace slicemorph
