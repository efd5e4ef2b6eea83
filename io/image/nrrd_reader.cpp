#include "io/image/nrrd_reader.h"

#include "io/image/chosen_volume.h"
#include "io/image/data_files.h"
#include "io/image/image_formats.h"
#include "io/image/nrrd_header.h"
#include "io/image/nrrd_labels.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace slicemorph {
namespace {

VolumeReader volumeOfNrrd(const std::string& path, const NrrdHeader& header, size_t volume) {
  std::uint64_t bytes = std::uint64_t(header.type.bytes);
  for (const StoredAxis& axis : header.axes) bytes *= axis.size;
  return {header.axes, volume, size_t(header.type.bytes),
          openDataFiles(path, header.data, header.type, bytes)};
}

ImageValues valuesOfNrrd(const std::string& path, const NrrdHeader& header, size_t volume) {
  VolumeReader reader = volumeOfNrrd(path, header, volume);
  const size_t count = header.file.image.lattice.count();
  return readValues(
      header.type, count, [&](void* to) { readOrRefuse(path, reader, to, count, header.type); },
      typeByOf(header.file));
}

/// Volumes between those of two colours of the same voxel.
size_t colourStride(const NrrdHeader& header) {
  size_t stride = 1;
  for (int a = 0; a < header.colours; ++a)
    if (!header.axes[size_t(a)].domain) stride *= header.axes[size_t(a)].size;
  return stride;
}

NrrdHeader headerFor(const std::string& path, int volume, const ImageOptions& options) {
  NrrdHeader header = readNrrdHeader(path, options.force);
  checkVolume(path, volume, header.file.volumes);
  std::string kinds;
  for (const std::string& kind : header.volumeKinds) kinds += (kinds.empty() ? "" : ", ") + kind;
  if (volume == kNoVolume && header.colours < 0) noteFirstVolume(path, kinds, header.file);
  header.file.header.labels = labelsOfNrrd(header.keys, std::max(volume, 0));
  if (!header.file.header.labels.empty())
    header.file.notes.emplace_back(kLabelsStated, Severity::kDetail, "",
                                   "it is a segmentation of 3D Slicer: its values are labels");
  return header;
}

}  // namespace

ImageFile readNrrd(const std::string& path, int volume, const ImageOptions& options, const SizeCheck& check) {
  NrrdHeader header = headerFor(path, volume, options);
  const bool colours = volume == kNoVolume && header.colours >= 0;
  const ImageLattice& lattice = header.file.image.lattice;
  check(lattice.size,
        double(lattice.count()) * double(bytesWhileRead(header.type) + (colours ? sizeof(double) : 0)));
  if (colours) {
    const size_t stride = colourStride(header);
    header.file.image.values =
        luminanceOf([&](int colour) { return valuesOfNrrd(path, header, size_t(colour) * stride); });
    noteLuminance(path, header.file);
  } else {
    header.file.image.values = valuesOfNrrd(path, header, size_t(std::max(volume, 0)));
    noteRounded(header.type, header.file);
  }
  return std::move(header.file);
}

std::optional<ImageSlices> openNrrd(const std::string& path, int volume, const ImageOptions& options) {
  NrrdHeader header = headerFor(path, volume, options);
  const bool text = header.data.encoding == DataFiles::kText || header.data.encoding == DataFiles::kHex;
  if (text || (volume == kNoVolume && header.colours >= 0)) return std::nullopt;
  return slicesOf(path, std::move(header.file), header.type,
                  volumeOfNrrd(path, header, size_t(std::max(volume, 0))));
}

}  // namespace slicemorph
