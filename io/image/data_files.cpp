#include "io/image/data_files.h"

#include "io/image/packed_bytes.h"
#include "io/paths.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>

namespace slicemorph {
namespace {

/// Where the lines to pass over end.
std::uint64_t afterLines(const std::string& path, std::uint64_t from, std::uint64_t lines) {
  if (lines == 0) return from;
  std::ifstream in(path, std::ios::binary);
  in.seekg(std::streamoff(from));
  std::string line;
  for (std::uint64_t n = 0; n < lines; ++n)
    if (!std::getline(in, line))
      throw IoError(path, "has fewer lines than its line skip " + std::to_string(lines));
  return std::uint64_t(in.tellg());
}

template <typename T>
void appendNumber(const std::string& path, const std::string& word, std::string& bytes) {
  char* end = nullptr;
  T value{};
  bool fits = true;
  errno = 0;
  if constexpr (std::is_floating_point_v<T>) {
    value = T(std::strtod(word.c_str(), &end));
  } else if constexpr (std::is_signed_v<T>) {
    const long long whole = std::strtoll(word.c_str(), &end, 10);
    value = T(whole), fits = errno == 0 && (long long)(value) == whole;
  } else {
    const unsigned long long whole = std::strtoull(word.c_str(), &end, 10);
    value = T(whole), fits = errno == 0 && word[0] != '-' && (unsigned long long)(value) == whole;
  }
  if (*end || !fits) throw IoError(path, "its text '" + word.substr(0, 40) + "' is no number of its type");
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void appendNumber(const std::string& path, RawType type, const std::string& word, std::string& bytes) {
  if (type.kind == RawType::kFloat)
    return type.bytes == 4 ? appendNumber<float>(path, word, bytes) : appendNumber<double>(path, word, bytes);
  const bool negative = type.kind == RawType::kSigned;
  switch (type.bytes) {
    case 1:
      return negative ? appendNumber<std::int8_t>(path, word, bytes)
                      : appendNumber<std::uint8_t>(path, word, bytes);
    case 2:
      return negative ? appendNumber<std::int16_t>(path, word, bytes)
                      : appendNumber<std::uint16_t>(path, word, bytes);
    case 4:
      return negative ? appendNumber<std::int32_t>(path, word, bytes)
                      : appendNumber<std::uint32_t>(path, word, bytes);
    default:
      return negative ? appendNumber<std::int64_t>(path, word, bytes)
                      : appendNumber<std::uint64_t>(path, word, bytes);
  }
}

std::string numbersOfText(const std::string& path, RawType type, const std::string& text) {
  std::string bytes, word;
  for (const char c : text + " ") {
    const bool between = c == ',' || std::isspace(static_cast<unsigned char>(c));
    if (!between) word += c;
    if (between && !word.empty()) appendNumber(path, type, word, bytes), word.clear();
  }
  return bytes;
}

std::string bytesOfHex(const std::string& path, const std::string& text) {
  std::string bytes;
  int high = -1;
  for (const char c : text) {
    if (std::isspace(static_cast<unsigned char>(c))) continue;
    const char* const digits = "0123456789abcdef";
    const char* const digit = std::strchr(digits, std::tolower(static_cast<unsigned char>(c)));
    if (!c || !digit) throw IoError(path, std::string("its hex data have the character '") + c + "'");
    const int value = int(digit - digits);
    if (high >= 0) bytes += char(high * 16 + value);
    high = high >= 0 ? -1 : value;
  }
  return bytes;
}

/// Where the data of one file begin; of packed ones, where their stream does. Throws IoError where it is not there, or
/// raw and too short.
std::uint64_t beginOfPart(const std::string& path, const DataFiles& data, const std::string& file,
                          std::uint64_t bytes) {
  requireNamedFile(path, file);
  const std::uint64_t size = sizeOfInput(file), begin = afterLines(file, data.from, data.lineSkip);
  if (data.encoding == DataFiles::kGzip || data.encoding == DataFiles::kBzip2) return begin;
  const bool last = data.byteSkip < 0;
  const std::uint64_t from = last ? size - std::min(size, bytes) : begin + std::uint64_t(data.byteSkip);
  if (data.encoding != DataFiles::kRaw) return std::min(from, size);
  if (from > size || size - from < bytes)
    throw IoError(path, "is truncated: " + (file == path ? "it" : file) + " has " +
                            std::to_string(size - std::min(from, size)) + " bytes of voxels, " +
                            std::to_string(bytes) + " are needed");
  return from;
}

/// The numbers of one file.
ByteReader openPart(const std::string& path, const DataFiles& data, const std::string& file, RawType type,
                    std::uint64_t bytes) {
  const std::uint64_t from = beginOfPart(path, data, file, bytes);
  if (data.encoding == DataFiles::kText || data.encoding == DataFiles::kHex) {
    const std::string whole = readWholeFile(file).substr(from);
    auto numbers = std::make_shared<std::string>(
        data.encoding == DataFiles::kText ? numbersOfText(path, type, whole) : bytesOfHex(path, whole));
    return [numbers, at = size_t(0)](void* to, size_t wanted) mutable {
      const size_t part = std::min(wanted, numbers->size() - at);
      std::memcpy(to, numbers->data() + at, part);
      at += part;
      return part;
    };
  }
  const bool plain = data.encoding == DataFiles::kRaw;
  auto stream = std::make_shared<PackedBytes>(file, from,
                                              plain                               ? PackedAs::kPlain
                                              : data.encoding == DataFiles::kGzip ? PackedAs::kDeflate
                                                                                  : PackedAs::kBzip2);
  if (!plain && !stream->skip(std::uint64_t(data.byteSkip)))
    throw IoError(path, "is truncated or damaged: it ends before its byte skip");
  return [stream](void* to, size_t wanted) { return stream->read(to, wanted); };
}

}  // namespace

std::vector<std::string> namedDataFiles(const std::string& path, const std::string& given,
                                        const std::string& list) {
  std::vector<std::string> names;
  std::istringstream words(given);
  std::string pattern;
  int low = 0, high = 0, step = 1;
  if (given.compare(0, 4, "LIST") == 0) {
    std::istringstream lines(list);
    for (std::string name; std::getline(lines, name);) {
      name.erase(name.find_last_not_of(" \t\r") + 1);
      if (!name.empty()) names.push_back(name);
    }
  } else if (given.find('%') != std::string::npos && words >> pattern >> low >> high) {
    if (!(words >> step)) step = 1;
    const size_t mark = pattern.find('%'), end = pattern.find_first_not_of("0123456789", mark + 1);
    if (end == std::string::npos || pattern[end] != 'd' || end > mark + 4 ||
        pattern.find('%', end) != std::string::npos || step == 0)
      throw IoError(path, "its data file '" + given + "' is no pattern as name.%03d.raw 1 20 1");
    if (std::abs((double(high) - low) / step) > 1e6)
      throw IoError(path, "its data file '" + given + "' means too many files");
    for (long n = low; step > 0 ? n <= high : n >= high; n += step) {
      std::vector<char> name(pattern.size() + 1024);
      std::snprintf(name.data(), name.size(), pattern.c_str(), int(n));
      names.emplace_back(name.data());
    }
  } else {
    names.push_back(given);
  }
  if (names.empty()) throw IoError(path, "its data file '" + given + "' means no file");
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

ByteReader openDataFiles(const std::string& path, const DataFiles& data, RawType type, std::uint64_t bytes) {
  const std::uint64_t files = data.files.size(), each = bytes / files;
  if (each * files != bytes)
    throw IoError(path, "its " + std::to_string(files) + " data files cannot hold " + std::to_string(bytes) +
                            " bytes in equal parts");
  for (const std::string& file : data.files) beginOfPart(path, data, file, each);
  const bool swap = data.bigEndian && data.encoding != DataFiles::kText && type.bytes > 1;
  return
      [=, part = ByteReader(), next = size_t(0), left = std::uint64_t(0)](void* to, size_t wanted) mutable {
        auto* out = static_cast<char*>(to);
        size_t got = 0;
        while (got < wanted) {
          if (left == 0) {
            if (next == data.files.size()) break;
            part = openPart(path, data, data.files[next++], type, each), left = each;
          }
          const size_t now = part(out + got, size_t(std::min<std::uint64_t>(left, wanted - got)));
          if (now == 0) break;
          got += now, left -= now;
        }
        if (swap) swapBytes(to, got / size_t(type.bytes), type.bytes);
        return got;
      };
}

}  // namespace slicemorph
