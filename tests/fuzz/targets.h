#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Readers as functions of bytes, for fuzzing: whatever the bytes are, a target returns. What the library refuses on
/// purpose (slicemorph::Error) is no finding; any other exception, crash, or memory beyond `kMemory` is.
namespace slicemorph::fuzz {

struct Target {
  const char* name;
  const char* extension;  ///< of the file that holds the bytes
  void (*read)(const std::string& path, std::string_view bytes);
};

/// What readers that take a limit may use.
constexpr double kMemory = 400e6;

const std::vector<Target>& targets();
/// Null where there is none.
const Target* targetNamed(std::string_view name);

/// Reads `bytes` by a target, from a file of its own in a scratch folder.
void run(const Target& target, std::string_view bytes);

}  // namespace slicemorph::fuzz
