#pragma once

#include <cstdint>
#include <string>

namespace slicemorph {

std::string lowered(std::string text);

/// Lower case, with the dot; empty: there is none.
std::string extensionOf(const std::string& path);
/// The same, with what is packed by gzip said: `.nii.gz`.
std::string fullExtensionOf(const std::string& path);

/// Size of a file that is there to be read. Throws IoError for a missing, empty or unreadable one and for
/// folders and devices.
std::uint64_t sizeOfInput(const std::string& path);

/// Whether a path stands for the files of a numbered sequence: its last part has a #, and there is no such
/// file.
bool isNumbered(const std::string& path);

}  // namespace slicemorph
