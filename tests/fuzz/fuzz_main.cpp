#include "targets.h"

#include "slicemorph/io/vdb_reader.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>

/// Entry points of libFuzzer. The environment's SLICEMORPH_FUZZ_TARGET names the target.
namespace {
const slicemorph::fuzz::Target* chosen = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("SLICEMORPH_FUZZ_TARGET");
  chosen = slicemorph::fuzz::targetNamed(name ? name : "");
  if (!chosen) {
    std::fprintf(stderr, "SLICEMORPH_FUZZ_TARGET names one of:");
    for (const auto& target : slicemorph::fuzz::targets())
      std::fprintf(stderr, " %s%s", target.name, target.extension);
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  slicemorph::initialiseVdb();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slicemorph::fuzz::run(*chosen, {reinterpret_cast<const char*>(data), size});
  return 0;
}
