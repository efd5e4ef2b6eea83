#include "io/image/itk_reader.h"

#include "io/image/itk_values.h"
#include "io/image/packed_bytes.h"
#include "io/paths.h"
#include "io/scratch_folder.h"

#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

namespace slicemorph {
namespace {

using Io = itk::ImageIOBase;

/// Fills the lattice and the number of volumes of an image of 2 to 4 dimensions. Throws IoError where these
/// make no sense, InputError where there is no volume `volume`.
void describe(const std::string& path, const Io& io, int volume, ImageFile& file) {
  const unsigned dimensions = io.GetNumberOfDimensions();
  const std::int64_t most = std::int64_t(1) << 40;
  std::int64_t all = 1, volumes = io.GetNumberOfComponents();
  for (unsigned d = 0; d < dimensions; ++d) {
    const std::int64_t n = std::int64_t(io.GetDimensions(d));
    if (n < 1 || n > most / all)
      throw IoError(
          path, "its size along axis " + std::to_string(d) + ", " + std::to_string(n) + ", makes no sense");
    all *= n;
    if (d < 3)
      file.image.lattice.size[int(d)] = int(n);
    else
      volumes *= n;
  }
  for (unsigned d = dimensions; d < 3; ++d) file.image.lattice.size[int(d)] = 1;
  file.volumes = int(std::min<std::int64_t>(volumes, 1 << 30));
  if (volume < 0 || volume >= file.volumes)
    throw InputError(path, "has no volume " + std::to_string(volume) + "; it has " +
                               std::to_string(file.volumes) + ", numbered from 0");
  ImageLattice& lattice = file.image.lattice;
  for (unsigned d = 0; d < std::min(dimensions, 3u); ++d) {
    lattice.origin[int(d)] = io.GetOrigin(d);
    const std::vector<double> direction = io.GetDirection(d);
    for (unsigned r = 0; r < 3; ++r)
      lattice.step[d][int(r)] = (r < direction.size() ? direction[r] : r == d) * io.GetSpacing(d);
  }
  if (dimensions < 3) lattice.step[2] = lattice.step[0].cross(lattice.step[1]).unit();
  const double flat = lattice.step[0].dot(lattice.step[1].cross(lattice.step[2]));
  if (!std::isfinite(flat) ||
      std::abs(flat) <= 1e-6 * lattice.spacing()[0] * lattice.spacing()[1] * lattice.spacing()[2])
    throw IoError(path, "its axes and spacing flatten space; they must be independent and not 0");
}

/// Reads all volumes and keeps one. In the file the components of a voxel are interleaved and times
/// follow each other.
ImageValues chosenValues(RawType type, const Io& io, const ImageFile& file, int volume,
                         const SizeCheck& check, const std::function<void(void*)>& readAll) {
  const size_t count = file.image.lattice.count(), components = io.GetNumberOfComponents();
  check(file.image.lattice.size, double(count) * type.bytes * (file.volumes == 1 ? 1 : file.volumes + 1));
  if (file.volumes == 1) return readValues(type, count, readAll);
  std::vector<char> bytes(count * size_t(file.volumes) * size_t(type.bytes));
  readAll(bytes.data());
  const size_t time = size_t(volume) / components, component = size_t(volume) % components;
  return readValues(type, count, [&](void* to) {
    auto* out = static_cast<char*>(to);
    for (size_t i = 0; i < count; ++i)
      std::copy_n(&bytes[((time * count + i) * components + component) * size_t(type.bytes)], type.bytes,
                  out + i * size_t(type.bytes));
  });
}

void readHeader(const std::string& path, Io& io, const char* format) {
  sizeOfInput(path);
  itk::Object::GlobalWarningDisplayOff();
  io.SetFileName(path);
  try {
    if (!io.CanReadFile(path.c_str()))
      throw IoError(path, "is no " + std::string(format) + " file, or its header is damaged");
    io.ReadImageInformation();
  } catch (const itk::ExceptionObject& error) {
    throw IoError(path, "cannot be read: " + reasonOf(error));
  }
}

void readWhole(const std::string& path, Io& io, void* to) {
  itk::ImageIORegion region(io.GetNumberOfDimensions());
  for (unsigned d = 0; d < io.GetNumberOfDimensions(); ++d) region.SetSize(d, io.GetDimensions(d));
  io.SetIORegion(region);
  try {
    io.Read(to);
  } catch (const itk::ExceptionObject& error) {
    throw IoError(path, "is truncated or damaged: " + reasonOf(error));
  }
}

std::string withoutSpaceAtTheEnds(std::string text) {
  text.erase(0, std::min(text.find_first_not_of(" \t"), text.size()));
  text.erase(text.find_last_not_of(" \t\r") + 1);
  return text;
}

/// The `key = value` lines of a MetaImage header and where its data begins.
struct MetaHeader {
  std::map<std::string, std::string> value;
  std::uint64_t bytes = 0;

  bool is(const char* key) const {
    const auto at = value.find(key);
    return at != value.end() && !at->second.empty() &&
           (at->second[0] == 'T' || at->second[0] == 't' || at->second[0] == '1');
  }
  bool bigEndian() const { return is("BinaryDataByteOrderMSB") || is("ElementByteOrderMSB"); }
};

MetaHeader metaHeader(const std::string& path) {
  MetaHeader header;
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    const size_t mark = line.find('=');
    if (mark == std::string::npos) continue;
    const std::string key = withoutSpaceAtTheEnds(line.substr(0, mark));
    header.value[key] = withoutSpaceAtTheEnds(line.substr(mark + 1));
    if (key == "ElementDataFile") break;
  }
  if (!header.value.count("ElementDataFile")) throw IoError(path, "its header has no ElementDataFile");
  header.bytes = std::uint64_t(file.tellg());
  return header;
}

/// Whether a MetaImage's data are in one file, by the name it gives.
bool isOneFile(const std::string& name) {
  return name.find('%') == std::string::npos && name.rfind("LIST", 0) != 0;
}

/// The file that a MetaImage's data are in; its own path where they follow the header.
std::string dataFileOf(const std::string& path, const std::string& name) {
  const bool local = name == "LOCAL" || name == "Local" || name == "local";
  return local ? path : (std::filesystem::path(path).parent_path() / name).string();
}

[[noreturn]] void refuseShort(const std::string& path, size_t got, size_t bytes) {
  throw IoError(path, "is truncated or damaged: its data unpack to " + std::to_string(got) + " bytes, " +
                          std::to_string(bytes) + " are needed");
}

void readMetaData(const std::string& path, const MetaHeader& header, RawType type, size_t count, Io& io,
                  ImageFile& file, void* to) {
  const std::string name = header.value.at("ElementDataFile"), data = dataFileOf(path, name);
  const bool local = data == path, single = isOneFile(name);
  const size_t bytes = count * size_t(type.bytes);
  if (single && !std::filesystem::exists(data))
    throw IoError(path, "its data file " + data + " does not exist");
  if (single) sizeOfInput(data);
  if (!header.is("CompressedData")) {
    const std::uint64_t from = local ? header.bytes : 0, there = single ? sizeOfInput(data) : 0;
    if (single && there < from + bytes)
      throw IoError(path, "is truncated: " + data + " has " + std::to_string(there - std::min(from, there)) +
                              " bytes of voxels, " + std::to_string(bytes) + " are needed");
    return readWhole(path, io, to);
  }
  if (!single) throw IoError(path, "compressed data in several files cannot be read");
  PackedBytes stream(data, local ? header.bytes : 0, true);
  const size_t got = stream.read(to, bytes);
  if (got < bytes) refuseShort(path, got, bytes);
  if (!stream.endsWell())
    throw IoError(path, "is damaged: its compressed data do not end after the last voxel");
  const auto stated = header.value.find("CompressedDataSize");
  if (stated != header.value.end() && stated->second != std::to_string(stream.packedBytes()))
    file.notes.emplace_back("image.header-repaired", Severity::kNote, "",
                            "its header states " + stated->second + " bytes of compressed data, there are " +
                                std::to_string(stream.packedBytes()) + ": all were read");
  if (header.bigEndian()) swapBytes(to, count, type.bytes);
}

/// An NRRD header that names a space but gives spacings instead of directions: forbidden by the
/// format, yet common.
struct OddNrrdHeader {
  std::string space;  ///< empty: the header is not of that kind
  std::string text;   ///< the header without its `space` and with the absolute path of its data file
};

/// Reads such a header if it is detached; headers in one file with their data are left to ITK.
OddNrrdHeader oddHeaderOf(const std::string& path) {
  OddNrrdHeader header;
  bool spacings = false, detached = false;
  std::string space;
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line) && !line.empty() && line != "\r";) {
    if (line.rfind("space:", 0) == 0) {
      space = withoutSpaceAtTheEnds(line.substr(6));
      continue;
    }
    spacings |= line.rfind("spacings:", 0) == 0;
    for (const char* key : {"data file: ", "datafile: "})
      if (line.rfind(key, 0) == 0 && line.find("LIST") == std::string::npos) {
        const std::string name = line.substr(std::string(key).size());
        line = key + (std::filesystem::absolute(path).parent_path() / name).string();
        detached = true;
      }
    header.text += line + "\n";
  }
  if (detached && spacings) header.space = space;
  return header;
}

/// Sets the axes from the name of the space alone, with a note.
void placeWithoutSpace(const std::string& space, ImageFile& file) {
  const bool leftHanded = space.rfind("3D-left-handed", 0) == 0;
  if (leftHanded) file.image.lattice.step[2] = -file.image.lattice.step[2];
  file.notes.emplace_back(
      "image.space-without-directions", Severity::kWarning, "",
      "its space '" + space +
          "' comes with spacings alone: voxels are placed by these, axes as left, back, " +
          (leftHanded ? "down (a left-handed space; with up it would be mirrored)" : "up"));
}

/// Where the values of a file of one volume lie, in one piece.
struct RawData {
  std::string path;
  std::uint64_t from = 0;
  bool packed = false, bigEndian = false;
};

/// The values slice by slice. `path`: for errors.
ImageSlices slicesOf(const std::string& path, ImageFile file, RawType type, const RawData& where) {
  const openvdb::Coord& size = file.image.lattice.size;
  const size_t each = size_t(size[0]) * size_t(size[1]), bytes = each * size_t(type.bytes);
  auto stream = std::make_shared<PackedBytes>(where.path, where.from, where.packed);
  const size_t all = bytes * size_t(size[2]);
  file.image.values = noValues(type);
  return {std::move(file), bytesWhileRead(type), [=, done = size_t(0), swap = where.bigEndian]() mutable {
            return readValues(type, each, [&](void* to) {
              const size_t got = stream->read(to, bytes);
              done += got;
              if (got < bytes) refuseShort(path, done, all);
              if (swap) swapBytes(to, each, type.bytes);
            });
          }};
}

/// Where the data of an NRRD file lie that follow its header, plain or by gzip; nothing for others.
std::optional<RawData> rawDataOfNrrd(const std::string& path) {
  RawData data{path};
  bool known = false;
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line == "\r") {
      data.from = std::uint64_t(in.tellg());
      return known ? std::optional(data) : std::nullopt;
    }
    const size_t mark = line.find(": ");
    if (mark == std::string::npos) continue;
    const std::string key = line.substr(0, mark), value = withoutSpaceAtTheEnds(line.substr(mark + 2));
    if (key == "data file" || key == "datafile" || key == "line skip" || key == "lineskip" ||
        key == "byte skip" || key == "byteskip")
      return std::nullopt;
    if (key == "encoding")
      data.packed = value == "gzip" || value == "gz", known = data.packed || value == "raw";
    if (key == "endian") data.bigEndian = value == "big";
  }
  return std::nullopt;
}

}  // namespace

ImageFile readNrrd(const std::string& path, int volume, const SizeCheck& check) {
  sizeOfInput(path);
  const OddNrrdHeader odd = oddHeaderOf(path);
  std::optional<ScratchFolder> scratch;
  std::string header = path;
  if (!odd.space.empty()) {
    // ITK reads from files only.
    header = scratch.emplace().file("header.nhdr");
    if (!(std::ofstream(header, std::ios::binary) << odd.text << std::flush))
      throw IoError(header, "cannot be written");
  }
  const auto io = itk::NrrdImageIO::New();
  readHeader(header, *io, "NRRD");
  ImageFile file;
  file.format = "NRRD";
  describe(path, *io, volume, file);
  if (!odd.space.empty()) placeWithoutSpace(odd.space, file);
  const RawType type = rawTypeOf(path, io->GetComponentType());
  file.image.values =
      chosenValues(type, *io, file, volume, check, [&](void* to) { readWhole(path, *io, to); });
  return file;
}

std::optional<ImageSlices> openNrrd(const std::string& path, int volume) {
  const std::optional<RawData> data = rawDataOfNrrd(path);
  if (!data) return std::nullopt;
  const auto io = itk::NrrdImageIO::New();
  readHeader(path, *io, "NRRD");
  ImageFile file;
  file.format = "NRRD";
  describe(path, *io, volume, file);
  if (file.volumes > 1) return std::nullopt;
  return slicesOf(path, std::move(file), rawTypeOf(path, io->GetComponentType()), *data);
}

std::optional<ImageSlices> openMetaImage(const std::string& path, int volume) {
  const auto io = itk::MetaImageIO::New();
  readHeader(path, *io, "MetaImage");
  ImageFile file;
  file.format = "MetaImage";
  describe(path, *io, volume, file);
  const MetaHeader header = metaHeader(path);
  const std::string name = header.value.at("ElementDataFile");
  if (file.volumes > 1 || !isOneFile(name) || header.value.count("HeaderSize") || !header.is("BinaryData"))
    return std::nullopt;
  const std::string data = dataFileOf(path, name);
  return slicesOf(path, std::move(file), rawTypeOf(path, io->GetComponentType()),
                  {data, data == path ? header.bytes : 0, header.is("CompressedData"), header.bigEndian()});
}

ImageFile readMetaImage(const std::string& path, int volume, const SizeCheck& check) {
  const auto io = itk::MetaImageIO::New();
  readHeader(path, *io, "MetaImage");
  ImageFile file;
  file.format = "MetaImage";
  describe(path, *io, volume, file);
  const RawType type = rawTypeOf(path, io->GetComponentType());
  const MetaHeader header = metaHeader(path);
  const size_t all = file.image.lattice.count() * size_t(file.volumes);
  file.image.values = chosenValues(type, *io, file, volume, check,
                                   [&](void* to) { readMetaData(path, header, type, all, *io, file, to); });
  return file;
}

}  // namespace slicemorph
