#pragma once

#include <cstdint>
#include <string>

namespace slicemorph {

/// In lower case.
std::string lowered(std::string text);

/// In lower case, with the dot; empty where there is none.
std::string extensionOf(const std::string& path);
/// The same, but with the extension before `.gz`: `.nii.gz`.
std::string fullExtensionOf(const std::string& path);

/// Whether a path ends with an extension of several parts, in any case: `.seg.dcm`, and has a name before it.
bool endsWith(const std::string& path, const std::string& ending);

/// Size of an input file in bytes. Throws IoError where it is missing, empty, unreadable, a folder
/// or a device.
std::uint64_t sizeOfInput(const std::string& path);

/// Throws IoError about `path` where the file that it names is missing, or its name is none that a file can have.
void requireNamedFile(const std::string& path, const std::string& file);

/// Whether a path stands for the files of a numbered sequence: its last part has a #, and no file
/// has that name.
bool isNumbered(const std::string& path);

}  // namespace slicemorph
