#include "io/image/metaimage_reader.h"

#include "io/image/chosen_volume.h"
#include "io/image/itk_values.h"
#include "io/image/length_unit.h"
#include "io/image/metaimage_header.h"
#include "io/image/packed_bytes.h"
#include "io/paths.h"

#include <itkMetaImageIO.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

namespace slicemorph {
namespace {

using MetaIo = itk::MetaImageIO;

/// A MetaImage whose header was read.
struct OpenMeta {
  MetaIo::Pointer io;
  MetaHeader header;
  ImageFile file;
  RawType type;
  std::vector<StoredAxis> axes;
};

/// Keeps what the library prints from the program's own words.
class QuietErrors {
 public:
  QuietErrors() : before_(std::cerr.rdbuf(nullptr)) {}
  ~QuietErrors() { std::cerr.rdbuf(before_), std::cerr.clear(); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  std::streambuf* before_;
};

/// Sets size, axes and number of volumes of an image of 1 to 4 dimensions.
void describeMeta(const std::string& path, OpenMeta& open) {
  const MetaIo& io = *open.io;
  const unsigned dimensions = io.GetNumberOfDimensions();
  const std::int64_t most = std::int64_t(1) << 40;
  const auto components = std::int64_t(io.GetNumberOfComponents());
  std::int64_t all = components, volumes = components;
  ImageLattice& lattice = open.file.image.lattice;
  open.axes.push_back({size_t(components), false});
  for (unsigned d = 0; d < dimensions; ++d) {
    const auto n = std::int64_t(io.GetDimensions(d));
    if (n < 1 || n > most / all)
      throw IoError(
          path, "its size along axis " + std::to_string(d) + ", " + std::to_string(n) + ", makes no sense");
    all *= n;
    open.axes.push_back({size_t(n), d < 3});
    if (d < 3)
      lattice.size[int(d)] = int(n);
    else
      volumes *= n;
  }
  for (unsigned d = dimensions; d < 3; ++d) lattice.size[int(d)] = 1;
  open.file.volumes = int(std::min<std::int64_t>(volumes, 1 << 30));
  for (unsigned d = 0; d < std::min(dimensions, 3u); ++d) {
    lattice.origin[int(d)] = io.GetOrigin(d);
    const std::vector<double> direction = io.GetDirection(d);
    for (unsigned r = 0; r < 3; ++r)
      lattice.step[d][int(r)] = (r < direction.size() ? direction[r] : r == d) * io.GetSpacing(d);
  }
  if (dimensions < 3) lattice.step[2] = lattice.step[0].cross(lattice.step[1]).unit();
  const double flat = lattice.step[0].dot(lattice.step[1].cross(lattice.step[2]));
  const Vec3d spacing = lattice.spacing();
  if (!std::isfinite(flat) || std::abs(flat) <= 1e-6 * spacing[0] * spacing[1] * spacing[2])
    throw IoError(path, "its axes and spacing flatten space; they must be independent and not 0");
}

/// Units of length, and what the header leaves open.
void placeMeta(OpenMeta& open) {
  const std::string unit = open.header.text("DistanceUnits"),
                    code = open.header.text("AnatomicalOrientation");
  const double factor = millimetresOf(unit).value_or(1);
  ImageLattice& lattice = open.file.image.lattice;
  lattice.origin *= factor;
  for (Vec3d& step : lattice.step) step *= factor;
  noteUnits({unit}, open.file.notes);
  const bool known = code.empty() || code.find('?') != std::string::npos || code == "RAI";
  const bool matrix =
      open.header.has("TransformMatrix") || open.header.has("Orientation") || open.header.has("Rotation");
  if (!known && !matrix)
    open.file.notes.emplace_back("image.place-unknown", Severity::kWarning, "",
                                 "its AnatomicalOrientation '" + code +
                                     "' comes without a TransformMatrix, which alone places voxels: axes are "
                                     "taken as left, back, up (RAI)");
}

OpenMeta openedMeta(const std::string& path, int volume) {
  sizeOfInput(path);
  itk::Object::GlobalWarningDisplayOff();
  OpenMeta open{MetaIo::New(), metaHeaderOf(path), {}, {}, {}};
  open.header.check(path);
  open.io->SetFileName(path);
  const QuietErrors quiet;
  try {
    if (!open.io->CanReadFile(path.c_str()))
      throw IoError(path, "is no MetaImage file, or its header is damaged");
    open.io->ReadImageInformation();
  } catch (const itk::ExceptionObject&) {
    throw IoError(path, "its MetaImage header is damaged: ITK cannot read it");
  }
  open.file.format = "MetaImage";
  describeMeta(path, open);
  placeMeta(open);
  checkVolume(path, volume, open.file.volumes);
  if (volume == kNoVolume) {
    const bool components = open.axes[0].size > 1, times = size_t(open.file.volumes) > open.axes[0].size;
    noteFirstVolume(path,
                    std::string(components ? "component" : "") + (components && times ? ", " : "") +
                        (times ? "time" : ""),
                    open.file);
  }
  open.type = rawTypeOf(path, open.io->GetComponentType());
  return open;
}

/// Whether the data are read here: binary ones in one file.
bool isPlain(const MetaHeader& header) { return header.inOneFile() && header.is("BinaryData"); }

/// The stream of a file's data, and where it ends.
std::shared_ptr<PackedBytes> dataOfMeta(const std::string& path, const OpenMeta& open) {
  const MetaHeader& header = open.header;
  const std::string data = header.dataFile(path);
  if (!std::filesystem::exists(data)) throw IoError(path, "its data file " + data + " does not exist");
  const std::uint64_t there = sizeOfInput(data);
  std::uint64_t bytes = std::uint64_t(open.type.bytes), from = data == path ? header.bytes : 0;
  for (const StoredAxis& axis : open.axes) bytes *= axis.size;
  const long skip =
      header.has("HeaderSize") ? std::strtol(header.text("HeaderSize").c_str(), nullptr, 10) : 0;
  if (header.is("CompressedData")) return std::make_shared<PackedBytes>(data, from, PackedAs::kDeflate);
  if (skip > 0) from = std::uint64_t(skip);
  if (skip < 0) from = there - std::min(there, bytes);
  if (there < from + bytes)
    throw IoError(path, "is truncated: " + (data == path ? "it" : data) + " has " +
                            std::to_string(there - std::min(from, there)) + " bytes of voxels, " +
                            std::to_string(bytes) + " are needed");
  return std::make_shared<PackedBytes>(data, from, PackedAs::kPlain);
}

VolumeReader volumeOfMeta(const OpenMeta& open, int volume, const std::shared_ptr<PackedBytes>& stream) {
  const size_t bytes = size_t(open.type.bytes);
  const bool swap = open.header.bigEndian();
  return {open.axes, size_t(std::max(volume, 0)), bytes, [=](void* to, size_t wanted) {
            const size_t got = stream->read(to, wanted);
            if (swap) swapBytes(to, got / bytes, int(bytes));
            return got;
          }};
}

/// Tells sizes that are stated wrongly, and refuses streams that go on after the last voxel is damaged.
void checkEndOfMeta(const std::string& path, OpenMeta& open, PackedBytes& stream) {
  if (!stream.endsWell())
    throw IoError(path, "is damaged: its compressed data do not end after the last voxel");
  const std::string stated = open.header.text("CompressedDataSize");
  if (stated.empty() || stated == std::to_string(stream.packedBytes())) return;
  open.file.notes.emplace_back("image.header-repaired", Severity::kNote, "",
                               "its header states " + stated + " bytes of compressed data, there are " +
                                   std::to_string(stream.packedBytes()) + ": all were read");
}

/// Data as text, or in several files, through ITK.
ImageValues valuesByItk(const std::string& path, const OpenMeta& open, int volume, const SizeCheck& check) {
  if (open.header.is("CompressedData"))
    throw IoError(path, "compressed data in several files cannot be read");
  const size_t count = open.file.image.lattice.count(), bytes = size_t(open.type.bytes);
  check(open.file.image.lattice.size, double(count * bytes) * (open.file.volumes + 1));
  std::vector<char> all(count * bytes * size_t(open.file.volumes));
  itk::ImageIORegion region(open.io->GetNumberOfDimensions());
  for (unsigned d = 0; d < open.io->GetNumberOfDimensions(); ++d)
    region.SetSize(d, open.io->GetDimensions(d));
  open.io->SetIORegion(region);
  const QuietErrors quiet;
  try {
    open.io->Read(all.data());
  } catch (const itk::ExceptionObject&) {
    throw IoError(path, "is truncated or damaged, or files that it names ('" +
                            open.header.text("ElementDataFile") + "') are missing: ITK cannot read its data");
  }
  VolumeReader reader(open.axes, size_t(std::max(volume, 0)), bytes,
                      [&, at = size_t(0)](void* to, size_t wanted) mutable {
                        const size_t part = std::min(wanted, all.size() - at);
                        std::copy_n(&all[at], part, static_cast<char*>(to));
                        at += part;
                        return part;
                      });
  return readValues(open.type, count, [&](void* to) { readOrRefuse(path, reader, to, count, open.type); });
}

}  // namespace

ImageFile readMetaImage(const std::string& path, int volume, const SizeCheck& check) {
  OpenMeta open = openedMeta(path, volume);
  const size_t count = open.file.image.lattice.count();
  ImageValues& values = open.file.image.values;
  if (isPlain(open.header)) {
    check(open.file.image.lattice.size, double(count) * open.type.bytes);
    const std::shared_ptr<PackedBytes> stream = dataOfMeta(path, open);
    VolumeReader reader = volumeOfMeta(open, volume, stream);
    values =
        readValues(open.type, count, [&](void* to) { readOrRefuse(path, reader, to, count, open.type); });
    if (open.header.is("CompressedData")) checkEndOfMeta(path, open, *stream);
  } else {
    values = valuesByItk(path, open, volume, check);
  }
  const auto [slope, offset] = open.header.scale(path);
  if (slope != 1 || offset != 0) {
    values = rescaled(std::move(values), slope, offset);
    open.file.notes.push_back(open.header.scaleNote());
  }
  return std::move(open.file);
}

std::optional<ImageSlices> openMetaImage(const std::string& path, int volume) {
  OpenMeta open = openedMeta(path, volume);
  if (!isPlain(open.header) || open.header.scale(path) != std::pair<double, double>(1, 0))
    return std::nullopt;
  VolumeReader reader = volumeOfMeta(open, volume, dataOfMeta(path, open));
  return slicesOf(path, std::move(open.file), open.type, std::move(reader));
}

}  // namespace slicemorph
