#include "tools/job/program_build.h"

#include "slicemorph/slicemorph.h"

#include <elf.h>
#include <link.h>

#include <cstdint>
#include <cstring>

namespace slicemorph {
namespace {

/// Search among the loaded files for the one that holds an address.
struct BuildSearch {
  std::uintptr_t address;
  std::string build;  ///< its identifier in hexadecimal digits; empty: none
};

std::string hexadecimal(const unsigned char* bytes, size_t count) {
  static constexpr char kHexDigits[] = "0123456789abcdef";
  std::string text;
  for (size_t i = 0; i < count; ++i) text += {kHexDigits[bytes[i] >> 4], kHexDigits[bytes[i] & 15]};
  return text;
}

/// The identifier in a segment of notes, as `ld --build-id` writes it (ELF specification, "Note Section").
std::string buildIn(const unsigned char* notes, size_t size) {
  const auto padded = [](size_t length) { return (length + 3) / 4 * 4; };
  size_t at = 0;
  while (at + sizeof(ElfW(Nhdr)) <= size) {
    ElfW(Nhdr) header;
    std::memcpy(&header, notes + at, sizeof header);
    const size_t name = at + sizeof header, content = name + padded(header.n_namesz);
    at = content + padded(header.n_descsz);
    if (at > size) break;
    if (header.n_type == NT_GNU_BUILD_ID && header.n_namesz == 4 && !std::memcmp(notes + name, "GNU", 4))
      return hexadecimal(notes + content, header.n_descsz);
  }
  return "";
}

/// Callback of dl_iterate_phdr; returns 1, which ends the search, at the file that holds the address.
int visit(dl_phdr_info* file, size_t, void* data) {
  BuildSearch& search = *static_cast<BuildSearch*>(data);
  bool holds = false;
  std::string build;
  for (int i = 0; i < file->dlpi_phnum; ++i) {
    const ElfW(Phdr)& part = file->dlpi_phdr[i];
    const std::uintptr_t begin = file->dlpi_addr + part.p_vaddr;
    if (part.p_type == PT_LOAD)
      holds = holds || (search.address >= begin && search.address - begin < part.p_memsz);
    if (part.p_type == PT_NOTE && build.empty())
      build = buildIn(reinterpret_cast<const unsigned char*>(begin), part.p_memsz);
  }
  if (holds) search.build = build;
  return holds;
}

template <typename Function>
std::string buildOfFileWith(Function* function) {
  BuildSearch search{reinterpret_cast<std::uintptr_t>(function), ""};
  dl_iterate_phdr(visit, &search);
  return search.build;
}

}  // namespace

std::string programBuild() {
  // The engine may be in a shared library of its own.
  const std::string own = buildOfFileWith(&programBuild), engine = buildOfFileWith(&aloneIn);
  const std::string both = own == engine || engine.empty() ? own : own + "+" + engine;
  return SLICEMORPH_VERSION + (both.empty() ? "" : " (" + both + ")");
}

}  // namespace slicemorph
