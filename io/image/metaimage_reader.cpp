#include "io/image/metaimage_reader.h"

#include "io/image/chosen_volume.h"
#include "io/image/data_files.h"
#include "io/image/itk_values.h"
#include "io/image/length_unit.h"
#include "io/image/metaimage_header.h"
#include "io/image/packed_bytes.h"
#include "io/paths.h"

#include <itkMetaImageIO.h>

#include <algorithm>
#include <cmath>
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

/// Sets size, axes and number of volumes of an image of 1 to 10 dimensions.
void describeMeta(const std::string& path, bool force, OpenMeta& open) {
  const MetaIo& io = *open.io;
  const unsigned dimensions = io.GetNumberOfDimensions();
  const std::int64_t most = std::int64_t(1) << 40;
  const auto components = std::int64_t(io.GetNumberOfComponents());
  std::int64_t all = components, volumes = components;
  // ITK takes some headers that are not of the form that was checked.
  if (components < 1) throw IoError(path, "its ElementNumberOfChannels is 0; a voxel has 1 or more");
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
  open.file.volumes = int(std::min<std::int64_t>(volumes, 1 << 30));
  for (unsigned d = 0; d < std::min(dimensions, 3u); ++d) {
    lattice.origin[int(d)] = io.GetOrigin(d);
    const std::vector<double> direction = io.GetDirection(d);
    for (unsigned r = 0; r < 3; ++r)
      lattice.step[d][int(r)] = (r < direction.size() ? direction[r] : r == d) * io.GetSpacing(d);
  }
  addFlatAxes(lattice, dimensions);
  checkPlace(path, force, open.file);
  // No unit of time is told. Where volumes are components, too, no one step leads from each to the next.
  const bool alone = dimensions > 3 && volumes == std::int64_t(io.GetDimensions(3));
  if (alone && io.GetSpacing(3) > 0 && std::isfinite(io.GetSpacing(3)))
    open.file.header.timeStep = io.GetSpacing(3), open.file.header.inSeconds = false;
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

OpenMeta openedMeta(const std::string& path, int volume, const ImageOptions& options) {
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
  describeMeta(path, options.force, open);
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

/// Where the data are, but for compressed ones.
DataFiles dataOfMeta(const std::string& path, const MetaHeader& header) {
  DataFiles data;
  const std::string name = header.text("ElementDataFile");
  data.files = header.isLocal() ? std::vector<std::string>{path} : namedDataFiles(path, name, header.list);
  if (header.isLocal()) data.from = header.bytes;
  data.encoding = header.is("BinaryData") ? DataFiles::kRaw : DataFiles::kText;
  data.bigEndian = header.bigEndian();
  data.byteSkip = header.skipped(path);
  return data;
}

/// The stream of compressed data, which are in one file.
std::shared_ptr<PackedBytes> packedMeta(const std::string& path, const DataFiles& data) {
  if (data.files.size() > 1) throw IoError(path, "compressed data in several files cannot be read");
  requireNamedFile(path, data.files[0]);
  sizeOfInput(data.files[0]);
  return std::make_shared<PackedBytes>(data.files[0], data.from + std::uint64_t(data.byteSkip),
                                       PackedAs::kDeflate);
}

/// `packed`: the stream of compressed data; null for others.
VolumeReader volumeOfMeta(const std::string& path, const OpenMeta& open, int volume, const DataFiles& data,
                          const std::shared_ptr<PackedBytes>& packed) {
  const size_t bytes = size_t(open.type.bytes);
  std::uint64_t all = bytes;
  for (const StoredAxis& axis : open.axes) all *= axis.size;
  if (!packed)
    return {open.axes, size_t(std::max(volume, 0)), bytes, openDataFiles(path, data, open.type, all)};
  return {open.axes, size_t(std::max(volume, 0)), bytes,
          [packed, bytes, swap = data.bigEndian](void* to, size_t wanted) {
            const size_t got = packed->read(to, wanted);
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

}  // namespace

ImageFile readMetaImage(const std::string& path, int volume, const ImageOptions& options,
                        const SizeCheck& check) {
  OpenMeta open = openedMeta(path, volume, options);
  const size_t count = open.file.image.lattice.count();
  ImageValues& values = open.file.image.values;
  const auto [slope, offset] = open.header.scale(path);
  const bool scaled = slope != 1 || offset != 0;
  const TypeBy by = typeByOf(open.file);
  check(open.file.image.lattice.size, double(count) * double(bytesWhileRead(open.type, scaled)));
  const DataFiles data = dataOfMeta(path, open.header);
  const auto packed = open.header.is("CompressedData") ? packedMeta(path, data) : nullptr;
  VolumeReader reader = volumeOfMeta(path, open, volume, data, packed);
  values = readValues(
      open.type, count, [&](void* to) { readOrRefuse(path, reader, to, count, open.type); }, by);
  if (packed) checkEndOfMeta(path, open, *packed);
  noteRounded(open.type, open.file);
  if (scaled) {
    values = rescaled(std::move(values), slope, offset, by);
    open.file.notes.push_back(open.header.scaleNote());
  }
  return std::move(open.file);
}

std::optional<ImageSlices> openMetaImage(const std::string& path, int volume, const ImageOptions& options) {
  OpenMeta open = openedMeta(path, volume, options);
  const DataFiles data = dataOfMeta(path, open.header);
  if (data.encoding == DataFiles::kText || open.header.scale(path) != std::pair<double, double>(1, 0))
    return std::nullopt;
  const auto packed = open.header.is("CompressedData") ? packedMeta(path, data) : nullptr;
  VolumeReader reader = volumeOfMeta(path, open, volume, data, packed);
  return slicesOf(path, std::move(open.file), open.type, std::move(reader));
}

}  // namespace slicemorph
