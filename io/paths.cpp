#include "io/paths.h"

#include "slicemorph/errors.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace slicemorph {
std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

std::string extensionOf(const std::string& path) {
  return lowered(std::filesystem::path(path).extension().string());
}

std::string fullExtensionOf(const std::string& path) {
  const std::string last = extensionOf(path);
  return last == ".gz" ? extensionOf(std::filesystem::path(path).stem().string()) + last : last;
}

bool endsWith(const std::string& path, const std::string& ending) {
  const std::string name = lowered(std::filesystem::path(path).filename().string());
  return name.size() > ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

std::uint64_t sizeOfInput(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw IoError(path, "no such file");
  if (error) throw IoError(path, "cannot be read: " + error.message());
  if (std::filesystem::is_directory(status)) throw IoError(path, "is a folder, not a file");
  if (!std::filesystem::is_regular_file(status)) throw IoError(path, "is no regular file");
  if (::access(path.c_str(), R_OK) != 0)
    throw IoError(path, std::string("cannot be read: ") + std::strerror(errno));
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) throw IoError(path, "cannot be read: " + error.message());
  if (size == 0) throw IoError(path, "is empty");
  return size;
}

void requireNamedFile(const std::string& path, const std::string& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error)) return;
  throw IoError(
      path, "its data file " + file + (error ? " cannot be read: " + error.message() : " does not exist"));
}

bool isNumbered(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::path(path).filename().string().find('#') != std::string::npos &&
         !std::filesystem::exists(path, ignored);
}

}  // namespace slicemorph
