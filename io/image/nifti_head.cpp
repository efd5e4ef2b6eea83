#include "engine/volume/same_image.h"
#include "io/image/image_formats.h"
#include "io/paths.h"

#include <nifti/nifti1.h>
#include <nifti/nifti2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <variant>

namespace slicemorph {
namespace {

/// By the index in ImageValues.
constexpr short kTypes[] = {DT_UINT8, DT_INT16, DT_UINT16, DT_INT32, DT_FLOAT32, DT_FLOAT64};
static_assert(std::size(kTypes) == std::variant_size_v<ImageValues>);

/// Quaternion of a rotation as NIfTI-1 stores it: (b, c, d), with a >= 0. Divides by the largest of the four
/// components, which is numerically stable.
void quaternionOf(const Mat3d& r, float q[3]) {
  const double trace[4] = {r(0, 0) + r(1, 1) + r(2, 2), r(0, 0), r(1, 1), r(2, 2)};
  double w[4];
  int most = 0;
  for (int i = 0; i < 4; ++i) {
    w[i] = i == 0 ? 1 + trace[0] : 1 + 2 * trace[i] - trace[0];
    if (w[i] > w[most]) most = i;
  }
  const double s = 0.5 / std::sqrt(w[most]);
  double a, b, c, d;
  if (most == 0)
    a = w[0] * s, b = (r(2, 1) - r(1, 2)) * s, c = (r(0, 2) - r(2, 0)) * s, d = (r(1, 0) - r(0, 1)) * s;
  else if (most == 1)
    a = (r(2, 1) - r(1, 2)) * s, b = w[1] * s, c = (r(0, 1) + r(1, 0)) * s, d = (r(0, 2) + r(2, 0)) * s;
  else if (most == 2)
    a = (r(0, 2) - r(2, 0)) * s, b = (r(0, 1) + r(1, 0)) * s, c = w[2] * s, d = (r(1, 2) + r(2, 1)) * s;
  else
    a = (r(1, 0) - r(0, 1)) * s, b = (r(0, 2) + r(2, 0)) * s, c = (r(1, 2) + r(2, 1)) * s, d = w[3] * s;
  const double sign = a < 0 ? -1 : 1;
  q[0] = float(sign * b), q[1] = float(sign * c), q[2] = float(sign * d);
}

/// Whether sizes need NIfTI-2: NIfTI-1 has 16 bits for them.
bool needsNifti2(const Voxels& voxels) {
  const openvdb::Coord& size = voxels.lattice.size;
  return std::max({size[0], size[1], size[2], voxels.volumes}) > std::numeric_limits<short>::max();
}

void setMagic(nifti_1_header& h) {
  h.sizeof_hdr = sizeof h;
  h.vox_offset = float(sizeof h + 4);
  h.xyzt_units = NIFTI_UNITS_MM;
  std::memcpy(h.magic, "n+1", 4);
}

void setMagic(nifti_2_header& h) {
  h.sizeof_hdr = sizeof h;
  h.vox_offset = sizeof h + 4;
  h.xyzt_units = NIFTI_UNITS_MM;
  std::memcpy(h.magic, "n+2\0\r\n\032\n", 8);
}

/// `Header`: of NIfTI-1 or -2, which name their fields the same. Both transforms that a file had for these voxels; the
/// sform stays empty where it had none.
template <typename Header>
void copyForms(const NiftiForms& forms, const ImageLattice& lattice, Header& h) {
  using Number = std::decay_t<decltype(Header().pixdim[0])>;
  h.sform_code = forms.sformCode, h.qform_code = forms.qformCode;
  Number* rows[3] = {h.srow_x, h.srow_y, h.srow_z};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4 && forms.sformCode > 0; ++c) rows[r][c] = Number(forms.sform[r][c]);
  const Vec3d spacing = lattice.spacing();
  const bool quaternion = forms.qformCode > 0;
  h.pixdim[0] = Number(quaternion ? forms.handedness : 1);
  for (int d = 0; d < 3; ++d) h.pixdim[d + 1] = Number(quaternion ? forms.spacing[d] : spacing[d]);
  if (!quaternion) return;
  h.quatern_b = Number(forms.quaternion[0]), h.quatern_c = Number(forms.quaternion[1]);
  h.quatern_d = Number(forms.quaternion[2]);
  h.qoffset_x = Number(forms.offset[0]), h.qoffset_y = Number(forms.offset[1]);
  h.qoffset_z = Number(forms.offset[2]);
}

/// An sform, and a qform where the axes are at right angles, both with this code.
template <typename Header>
void setForms(const ImageLattice& lattice, int code, Header& h) {
  using Number = std::decay_t<decltype(Header().pixdim[0])>;
  // LPS to RAS.
  Vec3d step[3], origin = lattice.origin;
  for (int d = 0; d < 3; ++d) step[d] = {-lattice.step[d][0], -lattice.step[d][1], lattice.step[d][2]};
  origin[0] = -origin[0], origin[1] = -origin[1];
  Number* rows[3] = {h.srow_x, h.srow_y, h.srow_z};
  for (int r = 0; r < 3; ++r) {
    for (int d = 0; d < 3; ++d) rows[r][d] = Number(step[d][r]) + Number(0);
    rows[r][3] = Number(origin[r]) + Number(0);
  }
  h.sform_code = decltype(h.sform_code)(code);
  const Vec3d spacing = lattice.spacing();
  for (int d = 0; d < 3; ++d) h.pixdim[d + 1] = Number(spacing[d]);
  Mat3d r;
  for (int d = 0; d < 3; ++d) r.setCol(d, step[d] / spacing[d]);
  const double mirrored = r.det() < 0 ? -1 : 1;
  h.pixdim[0] = Number(mirrored);
  r.setCol(2, r.col(2) * mirrored);
  // A quaternion holds right-angled axes only: the largest cosine between two of them, as exact
  // as floats are.
  const double lean = std::max(
      {std::abs(r.col(0).dot(r.col(1))), std::abs(r.col(0).dot(r.col(2))), std::abs(r.col(1).dot(r.col(2)))});
  if (lean >= 1e-5) return;
  h.qform_code = decltype(h.qform_code)(code);
  float q[3];
  quaternionOf(r, q);
  h.quatern_b = q[0], h.quatern_c = q[1], h.quatern_d = q[2];
  h.qoffset_x = rows[0][3], h.qoffset_y = rows[1][3], h.qoffset_z = rows[2][3];
}

template <typename Header>
Header niftiHeader(const Voxels& voxels) {
  using Number = std::decay_t<decltype(Header().pixdim[0])>;
  using Size = std::decay_t<decltype(Header().dim[0])>;
  const ImageLattice& lattice = voxels.lattice;
  Header h = {};
  setMagic(h);
  h.dim[0] = voxels.vectors ? 5 : voxels.volumes > 1 ? 4 : 3;
  h.dim[4] = Size(voxels.volumes), h.dim[5] = h.dim[6] = h.dim[7] = 1;
  if (voxels.vectors) h.dim[5] = 3, h.intent_code = NIFTI_INTENT_VECTOR;
  for (int d = 0; d < 3; ++d) h.dim[d + 1] = Size(lattice.size[d]);
  const double timeStep = voxels.header.timeStep;
  if (voxels.volumes > 1) h.pixdim[4] = Number(timeStep > 0 ? timeStep : 1);
  if (voxels.volumes > 1 && timeStep > 0 && voxels.header.inSeconds)
    h.xyzt_units = decltype(h.xyzt_units)(NIFTI_UNITS_MM | NIFTI_UNITS_SEC);
  h.datatype = kTypes[voxels.type];
  h.bitpix = short(8 * voxels.bytes);
  h.scl_slope = 1;
  const std::string description = voxels.meaning.empty() ? "slicemorph" : "slicemorph: " + voxels.meaning;
  std::strncpy(h.descrip, description.c_str(), sizeof h.descrip - 1);
  const std::optional<NiftiForms>& forms = voxels.header.forms;
  if (forms && sameLattice(forms->lattice, lattice))
    copyForms(*forms, lattice, h);
  else
    setForms(lattice,
             forms ? (forms->sformCode > 0 ? forms->sformCode : forms->qformCode) : NIFTI_XFORM_SCANNER_ANAT,
             h);
  return h;
}

}  // namespace

VoxelHead niftiHead(const std::string& path, const Voxels& voxels) {
  const auto bytesOfHeader = [](const auto& header) {
    return std::string(reinterpret_cast<const char*>(&header), sizeof header) + std::string(4, '\0');
  };
  const std::string bytes = needsNifti2(voxels) ? bytesOfHeader(niftiHeader<nifti_2_header>(voxels))
                                                : bytesOfHeader(niftiHeader<nifti_1_header>(voxels));
  return {bytes, fullExtensionOf(path) == ".nii" ? Packing::kNone : Packing::kGzip, true, false};
}

}  // namespace slicemorph
