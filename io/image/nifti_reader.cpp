#include "io/image/nifti_reader.h"

#include "io/image/raw_values.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <nifti/nifti1_io.h>

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

namespace slicemorph {
namespace {

struct FreeImage {
  void operator()(nifti_image* image) const { nifti_image_free(image); }
};
using NiftiHeader = std::unique_ptr<nifti_image, FreeImage>;

/// From voxel indices to LPS.
struct Affine {
  Vec3d origin, step[3];

  bool valid() const {
    const double volume = step[0].dot(step[1].cross(step[2]));
    const double size = step[0].length() * step[1].length() * step[2].length();
    return std::isfinite(volume + origin.length()) && size > 0 && std::abs(volume) > 1e-6 * size;
  }
};

/// From a matrix of NIfTI, whose axes are RAS.
Affine affineOf(const mat44& m) {
  const auto column = [&](int c) { return Vec3d(-double(m.m[0][c]), -double(m.m[1][c]), double(m.m[2][c])); };
  return {column(3), {column(0), column(1), column(2)}};
}

/// Millimetres of a unit of length; unknown ones are taken as millimetres.
double millimetres(int unit) {
  return unit == NIFTI_UNITS_METER ? 1000 : unit == NIFTI_UNITS_MICRON ? 0.001 : 1;
}

/// Sets the lattice's origin and steps. Throws IoError where the header has no valid affine.
void place(const std::string& path, const nifti_image& header, ImageFile& file) {
  Affine affine{};
  bool found = false;
  if (header.sform_code > 0) {
    affine = affineOf(header.sto_xyz);
    found = affine.valid();
    if (!found)
      file.notes.emplace_back("image.sform-damaged", Severity::kWarning, "",
                              "its sform is no valid affine (it flattens space)");
  }
  if (!found && header.qform_code > 0) {
    affine = affineOf(header.qto_xyz);
    found = affine.valid();
    if (found && header.sform_code > 0) file.notes.back().text += ": the qform was taken";
  }
  if (!found) {
    const Vec3d spacing(std::abs(header.dx), std::abs(header.dy), std::abs(header.dz));
    if (header.sform_code > 0 || header.qform_code > 0 ||
        !(spacing[0] > 0 && spacing[1] > 0 && spacing[2] > 0) || !std::isfinite(spacing.length()))
      throw IoError(path, "no valid affine: neither its sform (code " + std::to_string(header.sform_code) +
                              ") nor its qform (code " + std::to_string(header.qform_code) +
                              ") nor its voxel spacing places the voxels in space");
    affine = {Vec3d(0.0), {{-spacing[0], 0, 0}, {0, -spacing[1], 0}, {0, 0, spacing[2]}}};
    file.notes.emplace_back(
        "image.place-unknown", Severity::kWarning, "",
        "it does not say where it lies (sform and qform codes are 0): taken from its voxel spacing, axes as "
        "right, front, up");
  }
  const double unit = millimetres(header.xyz_units);
  if (unit != 1)
    file.notes.emplace_back("image.unit-converted", Severity::kNote, "",
                            "lengths are not in millimetres: multiplied by " + std::to_string(unit));
  file.image.lattice.origin = affine.origin * unit;
  for (int d = 0; d < 3; ++d) file.image.lattice.step[d] = affine.step[d] * unit;
}

RawType rawTypeOfNifti(const std::string& path, int datatype) {
  switch (datatype) {
    case DT_UINT8:
      return {1, RawType::kUnsigned};
    case DT_INT8:
      return {1, RawType::kSigned};
    case DT_UINT16:
      return {2, RawType::kUnsigned};
    case DT_INT16:
      return {2, RawType::kSigned};
    case DT_UINT32:
      return {4, RawType::kUnsigned};
    case DT_INT32:
      return {4, RawType::kSigned};
    case DT_UINT64:
      return {8, RawType::kUnsigned};
    case DT_INT64:
      return {8, RawType::kSigned};
    case DT_FLOAT32:
      return {4, RawType::kFloat};
    case DT_FLOAT64:
      return {8, RawType::kFloat};
  }
  throw IoError(path, std::string("its voxels are ") + nifti_datatype_string(datatype) +
                          "; only plain numbers can be read");
}

/// The data of a file, from a volume's first byte on.
class NiftiData {
 public:
  NiftiData(const std::string& path, nifti_image& header, size_t volume, size_t bytes)
      : path_(path), header_(header), volume_(volume), file_(znzopen(header.iname, "rb", isPacked(header))) {
    if (znz_isnull(file_))
      throw IoError(path, "its data file " + std::string(header.iname) + " cannot be opened");
    if (znzseek(file_, long(header.iname_offset + volume * bytes), SEEK_SET) < 0) refuse();
  }
  ~NiftiData() { Xznzclose(&file_); }
  NiftiData(const NiftiData&) = delete;
  NiftiData& operator=(const NiftiData&) = delete;

  /// The next bytes.
  void read(void* to, size_t bytes) {
    if (nifti_read_buffer(file_, to, bytes, &header_) != bytes) refuse();
  }

 private:
  static int isPacked(const nifti_image& header) { return nifti_is_gzfile(header.iname); }
  [[noreturn]] void refuse() const {
    throw IoError(path_, "is truncated or damaged: volume " + std::to_string(volume_) + " is not all there");
  }

  std::string path_;
  nifti_image& header_;
  size_t volume_;
  znzFile file_;
};

/// A file whose header was read.
struct OpenNifti {
  NiftiHeader header;
  ImageFile file;
  RawType type;
  bool scaled = false;  ///< values are to be multiplied or shifted
};

OpenNifti openedNifti(const std::string& path, int volume) {
  sizeOfInput(path);
  nifti_set_debug_level(0);
  OpenNifti open{NiftiHeader(nifti_image_read(path.c_str(), 0)), {}, {}};
  const nifti_image* header = open.header.get();
  if (!header) throw IoError(path, "is no NIfTI file, or its header is damaged");
  ImageFile& file = open.file;
  file.format = "NIfTI";
  file.about = header->descrip;
  const openvdb::Coord size(header->nx, header->ny, std::max(1, header->nz));
  const std::int64_t most = std::int64_t(1) << 40;
  if (size[0] < 1 || size[1] < 1 || std::int64_t(size[0]) * size[1] > most / size[2])
    throw IoError(path, "its size " + std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
                            std::to_string(size[2]) + " makes no sense");
  const std::int64_t volumes = std::int64_t(std::max(1, header->nt)) * std::max(1, header->nu) *
                               std::max(1, header->nv) * std::max(1, header->nw);
  file.volumes = int(std::min<std::int64_t>(volumes, 1 << 30));
  if (volume < 0 || volume >= file.volumes)
    throw InputError(path, "has no volume " + std::to_string(volume) + "; it has " +
                               std::to_string(file.volumes) + ", numbered from 0");
  file.image.lattice.size = size;
  place(path, *header, file);
  open.type = rawTypeOfNifti(path, header->datatype);
  const double slope = header->scl_slope, intercept = header->scl_inter;
  open.scaled = slope != 0 && std::isfinite(slope) && std::isfinite(intercept);
  return open;
}

}  // namespace

ImageFile readNifti(const std::string& path, int volume, const SizeCheck& check) {
  OpenNifti open = openedNifti(path, volume);
  ImageFile& file = open.file;
  const size_t count = file.image.lattice.count(), bytes = count * size_t(open.type.bytes);
  check(file.image.lattice.size, double(bytes));
  NiftiData data(path, *open.header, size_t(volume), bytes);
  file.image.values = readValues(open.type, count, [&](void* to) { data.read(to, bytes); });
  if (open.scaled)
    file.image.values =
        rescaled(std::move(file.image.values), open.header->scl_slope, open.header->scl_inter);
  return std::move(file);
}

std::optional<ImageSlices> openNifti(const std::string& path, int volume) {
  auto open = std::make_shared<OpenNifti>(openedNifti(path, volume));
  const bool same = open->header->scl_slope == 1 && open->header->scl_inter == 0;
  if (open->file.volumes > 1 || (open->scaled && !same)) return std::nullopt;
  const ImageLattice& lattice = open->file.image.lattice;
  const size_t each = size_t(lattice.size[0]) * size_t(lattice.size[1]);
  auto data = std::make_shared<NiftiData>(path, *open->header, 0, lattice.count() * size_t(open->type.bytes));
  ImageFile file = open->file;
  file.image.values = noValues(open->type);
  return ImageSlices{std::move(file), bytesWhileRead(open->type), [open, data, each] {
                       return readValues(open->type, each,
                                         [&](void* to) { data->read(to, each * size_t(open->type.bytes)); });
                     }};
}

}  // namespace slicemorph
