#include "io/image/nifti_reader.h"

#include "io/image/chosen_volume.h"
#include "io/image/nifti_place.h"
#include "io/image/packed_bytes.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

namespace slicemorph {
namespace {

struct FreeImage {
  void operator()(nifti_image* image) const { nifti_image_free(image); }
};
using NiftiPointer = std::unique_ptr<nifti_image, FreeImage>;

/// The numbers of a voxel: their type, and how many there are, of colours or complex numbers.
struct VoxelType {
  RawType type;
  int components = 1;
};

VoxelType voxelTypeOf(const std::string& path, int datatype) {
  switch (datatype) {
    case DT_UINT8:
      return {{1, RawType::kUnsigned}};
    case DT_INT8:
      return {{1, RawType::kSigned}};
    case DT_UINT16:
      return {{2, RawType::kUnsigned}};
    case DT_INT16:
      return {{2, RawType::kSigned}};
    case DT_UINT32:
      return {{4, RawType::kUnsigned}};
    case DT_INT32:
      return {{4, RawType::kSigned}};
    case DT_UINT64:
      return {{8, RawType::kUnsigned}};
    case DT_INT64:
      return {{8, RawType::kSigned}};
    case DT_FLOAT32:
      return {{4, RawType::kFloat}};
    case DT_FLOAT64:
      return {{8, RawType::kFloat}};
    case DT_RGB24:
      return {{1, RawType::kUnsigned}, 3};
    case DT_RGBA32:
      return {{1, RawType::kUnsigned}, 4};
    case DT_COMPLEX64:
      return {{4, RawType::kFloat}, 2};
    case DT_COMPLEX128:
      return {{8, RawType::kFloat}, 2};
  }
  throw IoError(path, std::string("its voxels are ") + nifti_datatype_string(datatype) + " (code " +
                          std::to_string(datatype) +
                          "); numbers of up to 64 bits, RGB24, RGBA32 and complex ones can be read");
}

/// A file whose header was read.
struct OpenNifti {
  NiftiPointer header;
  ImageFile file;
  VoxelType voxel;
  std::vector<StoredAxis> axes;
  double slope = 1, intercept = 0;

  bool colours() const { return voxel.components > 2; }
  bool scaled() const { return slope != 1 || intercept != 0; }
  bool packed() const { return nifti_is_gzfile(header->iname); }
};

/// Slope and intercept, which stand elsewhere where a file is none of NIfTI.
void setScale(const std::string& path, OpenNifti& open) {
  const nifti_image& header = *open.header;
  double slope = header.scl_slope, intercept = header.scl_inter;
  if (header.nifti_type == NIFTI_FTYPE_ANALYZE) slope = analyzeHeaderOf(header.fname).funused1, intercept = 0;
  if (open.colours() || slope == 0 || std::isnan(slope)) return;
  if (!std::isfinite(slope) || !std::isfinite(intercept)) {
    std::ostringstream text;
    text << "its scl_slope " << slope << " and scl_inter " << intercept << " scale no values";
    throw IoError(path, text.str());
  }
  open.slope = slope, open.intercept = intercept;
}

/// Size, axes and the number of volumes. Throws IoError where these make no sense.
void describeNifti(const std::string& path, OpenNifti& open) {
  const nifti_image& header = *open.header;
  const std::int64_t sizes[] = {header.nx,
                                header.ny,
                                std::max<std::int64_t>(1, header.nz),
                                std::max<std::int64_t>(1, header.nt),
                                std::max<std::int64_t>(1, header.nu),
                                std::max<std::int64_t>(1, header.nv),
                                std::max<std::int64_t>(1, header.nw)};
  const std::int64_t most = std::int64_t(1) << 40;
  std::int64_t all = open.voxel.components, volumes = open.voxel.components;
  open.axes = {{size_t(open.voxel.components), false}};
  for (int d = 0; d < 7; ++d) {
    if (sizes[d] < 1 || sizes[d] > most / all || (d < 3 && sizes[d] > std::int64_t(1) << 30))
      throw IoError(path, "its size " + std::to_string(sizes[0]) + " x " + std::to_string(sizes[1]) + " x " +
                              std::to_string(sizes[2]) + " makes no sense");
    all *= sizes[d];
    open.axes.push_back({size_t(sizes[d]), d < 3});
    if (d < 3)
      open.file.image.lattice.size[d] = int(sizes[d]);
    else
      volumes *= sizes[d];
  }
  open.file.volumes = int(std::min<std::int64_t>(volumes, 1 << 30));
}

/// What tells the volumes of a file apart.
std::string kindsOf(const OpenNifti& open) {
  const nifti_image& header = *open.header;
  std::string kinds = open.voxel.components == 2 ? "real and imaginary part" : open.colours() ? "colour" : "";
  const auto add = [&](bool there, const char* kind) {
    if (there) kinds += (kinds.empty() ? "" : ", ") + std::string(kind);
  };
  const int intent = header.intent_code;
  add(header.nt > 1, "time");
  add(header.nu > 1, intent == NIFTI_INTENT_VECTOR || intent == NIFTI_INTENT_DISPVECT ? "vector component"
                     : intent == NIFTI_INTENT_SYMMATRIX                               ? "matrix component"
                                                        : "the fifth dimension");
  add(header.nv > 1 || header.nw > 1, "further dimensions");
  return kinds;
}

/// A whole number of a header.
std::int64_t numberAt(const unsigned char* header, size_t at, size_t bytes, bool highFirst) {
  std::uint64_t value = 0;
  for (size_t i = 0; i < bytes; ++i)
    value |= std::uint64_t(header[at + i]) << 8 * (highFirst ? bytes - 1 - i : i);
  const unsigned spare = unsigned(64 - 8 * bytes);
  return std::int64_t(value << spare) >> spare;
}

/// Throws IoError for the headers of which the library prints what is wrong instead of returning it.
void checkNiftiHeader(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> name(nifti_findhdrname(path.c_str()), &std::free);
  if (!name) return;
  unsigned char header[sizeof(nifti_2_header)] = {};
  PackedBytes file(name.get(), 0, nifti_is_gzfile(name.get()) ? PackedAs::kDeflate : PackedAs::kPlain);
  if (file.read(header, sizeof header) < sizeof(nifti_1_header)) return;
  for (const bool swap : {false, true}) {
    const std::int64_t size = numberAt(header, 0, 4, swap);
    if (size != sizeof(nifti_1_header) && size != sizeof(nifti_2_header)) continue;
    const bool second = size == sizeof(nifti_2_header);
    const auto dim = [&](size_t n) {
      return second ? numberAt(header, 16 + 8 * n, 8, swap) : numberAt(header, 40 + 2 * n, 2, swap);
    };
    const std::int64_t dimensions = dim(0);
    if (dimensions < 1 || dimensions > 7)
      throw IoError(path, "is damaged: its header states " + std::to_string(dimensions) +
                              " dimensions; there are 1 to 7");
    if (dim(1) < 1) throw IoError(path, "is damaged: its header states a size of " + std::to_string(dim(1)));
    const std::int64_t type = numberAt(header, second ? 12 : 70, 2, swap);
    if (nifti_is_valid_datatype(int(type)) == 0) voxelTypeOf(path, int(type));
    return;
  }
}

OpenNifti openedNifti(const std::string& path, int volume, const ImageOptions& options) {
  sizeOfInput(path);
  nifti_set_debug_level(0);
  checkNiftiHeader(path);
  OpenNifti open;
  open.header.reset(nifti_image_read(path.c_str(), 0));
  if (!open.header) throw IoError(path, "is no NIfTI or Analyze 7.5 file, or its header is damaged");
  const nifti_image& header = *open.header;
  open.file.format = header.nifti_type == NIFTI_FTYPE_ANALYZE ? "Analyze 7.5"
                     : header.nifti_type == NIFTI_FTYPE_NIFTI2_1 || header.nifti_type == NIFTI_FTYPE_NIFTI2_2
                         ? "NIfTI-2"
                         : "NIfTI";
  open.file.about = header.descrip;
  // Numbers of CIFTI's intents, https://www.nitrc.org/projects/cifti/
  if (header.intent_code >= 3000 && header.intent_code < 3100)
    throw IoError(path, "is CIFTI (intent " + std::to_string(header.intent_code) +
                            "): matrices over points of surfaces, which are no image");
  open.voxel = voxelTypeOf(path, header.datatype);
  describeNifti(path, open);
  placeNifti(path, header, options, open.file);
  checkPlace(path, options.force, open.file);
  checkVolume(path, volume, open.file.volumes);
  setScale(path, open);
  if (header.nifti_type == NIFTI_FTYPE_ANALYZE && open.slope != 1)
    open.file.notes.emplace_back(
        "image.rescaled", Severity::kNote, "",
        "its values are multiplied by SPM's scale factor " + std::to_string(open.slope));
  if (volume == kNoVolume && !open.colours()) noteFirstVolume(path, kindsOf(open), open.file);
  return open;
}

/// The stream of a volume's numbers.
struct NiftiStream {
  std::shared_ptr<PackedBytes> bytes;
  VolumeReader reader;
};

NiftiStream streamOf(const std::string& path, const OpenNifti& open, size_t volume) {
  const nifti_image& header = *open.header;
  const std::string data = header.iname ? header.iname : "";
  requireNamedFile(path, data);
  std::vector<StoredAxis> axes = open.axes;
  std::uint64_t each = std::uint64_t(open.voxel.type.bytes),
                from = std::uint64_t(std::max<std::int64_t>(0, header.iname_offset));
  std::uint64_t all = each;
  for (const StoredAxis& axis : axes) all *= axis.size, each *= axis.domain ? axis.size : 1;
  if (open.voxel.components == 1) {
    // Volumes follow each other: those before are passed over.
    from += volume * each, all = each;
    for (StoredAxis& axis : axes)
      if (!axis.domain) axis.size = 1;
  }
  if (!open.packed()) {
    const std::uint64_t there = sizeOfInput(data);
    if (there < from + all)
      throw IoError(path, "is truncated: " + (data == path ? "it" : data) + " has " +
                              std::to_string(there - std::min(from, there)) + " bytes of voxels" +
                              (open.file.volumes > 1 ? " for volume " + std::to_string(volume) : "") + ", " +
                              std::to_string(all) + " are needed");
  }
  auto bytes = std::make_shared<PackedBytes>(data, open.packed() ? 0 : from,
                                             open.packed() ? PackedAs::kDeflate : PackedAs::kPlain);
  if (open.packed() && !bytes->skip(from))
    throw IoError(path, "is truncated or damaged: volume " + std::to_string(volume) + " is not there");
  const bool swap = header.byteorder != nifti_short_order();
  const int size = open.voxel.type.bytes;
  return {bytes, VolumeReader(axes, volume, size_t(size), [=](void* to, size_t wanted) {
            const size_t got = bytes->read(to, wanted);
            if (swap) swapBytes(to, got / size_t(size), size);
            return got;
          })};
}

ImageValues valuesOfNifti(const std::string& path, const OpenNifti& open, size_t volume) {
  NiftiStream stream = streamOf(path, open, volume);
  const size_t count = open.file.image.lattice.count();
  const TypeBy by = typeByOf(open.file);
  ImageValues values = readValues(
      open.voxel.type, count,
      [&](void* to) { readOrRefuse(path, stream.reader, to, count, open.voxel.type); }, by);
  // The checksum stands at the end.
  if (open.packed() && volume + 1 == size_t(open.file.volumes) && !stream.bytes->endsWell())
    throw IoError(path, "is truncated or damaged: its compressed data do not end as they should");
  return rescaled(std::move(values), open.slope, open.intercept, by);
}

}  // namespace

ImageFile readNifti(const std::string& path, int volume, const ImageOptions& options,
                    const SizeCheck& check) {
  OpenNifti open = openedNifti(path, volume, options);
  const ImageLattice& lattice = open.file.image.lattice;
  const bool luminance = volume == kNoVolume && open.colours();
  check(lattice.size, double(lattice.count()) * double(bytesWhileRead(open.voxel.type, open.scaled()) +
                                                       (luminance ? sizeof(double) : 0)));
  if (luminance) {
    open.file.image.values =
        luminanceOf([&](int colour) { return valuesOfNifti(path, open, size_t(colour)); });
    noteLuminance(path, open.file);
  } else {
    open.file.image.values = valuesOfNifti(path, open, size_t(std::max(volume, 0)));
    if (!open.scaled()) noteRounded(open.voxel.type, open.file);
  }
  return std::move(open.file);
}

std::optional<ImageSlices> openNifti(const std::string& path, int volume, const ImageOptions& options) {
  OpenNifti open = openedNifti(path, volume, options);
  if (open.scaled() || (volume == kNoVolume && open.colours())) return std::nullopt;
  NiftiStream stream = streamOf(path, open, size_t(std::max(volume, 0)));
  return slicesOf(path, std::move(open.file), open.voxel.type, std::move(stream.reader));
}

}  // namespace slicemorph
