#include "io/image/nifti_reader.h"

#include "io/image/raw_values.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <nifti/nifti1_io.h>

#include <cmath>
#include <memory>

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

void readVolume(const std::string& path, nifti_image& header, size_t volume, void* to, size_t bytes) {
  const std::string name = header.iname;
  const znzFile data = znzopen(name.c_str(), "rb", nifti_is_gzfile(name.c_str()));
  if (znz_isnull(data)) throw IoError(path, "its data file " + name + " cannot be opened");
  const bool there = znzseek(data, long(header.iname_offset + volume * bytes), SEEK_SET) >= 0;
  const size_t got = there ? nifti_read_buffer(data, to, bytes, &header) : 0;
  Xznzclose(const_cast<znzFile*>(&data));
  if (got != bytes)
    throw IoError(path, "is truncated or damaged: volume " + std::to_string(volume) + " is not all there");
}

}  // namespace

ImageFile readNifti(const std::string& path, int volume, const SizeCheck& check) {
  sizeOfInput(path);
  nifti_set_debug_level(0);
  const NiftiHeader header(nifti_image_read(path.c_str(), 0));
  if (!header) throw IoError(path, "is no NIfTI file, or its header is damaged");
  ImageFile file;
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
  const RawType type = rawTypeOfNifti(path, header->datatype);
  const size_t count = file.image.lattice.count();
  check(size, double(count) * type.bytes);
  const double slope = header->scl_slope, intercept = header->scl_inter;
  const bool scaled = slope != 0 && std::isfinite(slope) && std::isfinite(intercept);
  file.image.values = readValues(type, count, [&](void* to) {
    readVolume(path, *header, size_t(volume), to, count * size_t(type.bytes));
  });
  if (scaled) file.image.values = rescaled(std::move(file.image.values), slope, intercept);
  return file;
}

}  // namespace slicemorph
