#include "io/image/nifti_place.h"

#include "io/image/image_formats.h"
#include "io/image/length_unit.h"
#include "io/image/packed_bytes.h"
#include "io/image/raw_values.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

namespace slicemorph {
namespace {

/// From voxel indices to LPS.
struct Affine {
  Vec3d origin, step[3];

  bool valid() const {
    const double volume = step[0].dot(step[1].cross(step[2]));
    const double size = step[0].length() * step[1].length() * step[2].length();
    return std::isfinite(volume + origin.length()) && size > 0 && std::abs(volume) > 1e-6 * size;
  }
  Vec3d operator()(const Vec3d& v) const { return origin + v[0] * step[0] + v[1] * step[1] + v[2] * step[2]; }
};

/// From a matrix of NIfTI, whose axes are RAS.
Affine affineOf(const nifti_dmat44& m) {
  const auto column = [&](int c) { return Vec3d(-m.m[0][c], -m.m[1][c], m.m[2][c]); };
  return {column(3), {column(0), column(1), column(2)}};
}

/// How far two affines place a corner of the image apart, at most.
double apart(const Affine& a, const Affine& b, const openvdb::Coord& size) {
  double most = 0;
  for (int c = 0; c < 8; ++c) {
    const Vec3d corner(c & 1 ? size[0] - 1 : 0, c & 2 ? size[1] - 1 : 0, c & 4 ? size[2] - 1 : 0);
    most = std::max(most, (a(corner) - b(corner)).length());
  }
  return most;
}

void tellPlace(ImageFile& file, const char* code, const std::string& text,
               Severity severity = Severity::kWarning) {
  file.notes.emplace_back(code, severity, "", text);
}

bool areSizes(const Vec3d& spacing) {
  return spacing[0] > 0 && spacing[1] > 0 && spacing[2] > 0 && std::isfinite(spacing.length());
}

void tellForced(ImageFile& file, const std::string& why, const Vec3d& spacing) {
  std::ostringstream text;
  text << "--force: " << why << "axes are taken as right, front, up, voxels of " << spacing[0] << " x "
       << spacing[1] << " x " << spacing[2] << " mm";
  tellPlace(file, kGeometryForced, text.str());
}

/// Tells where sform and qform place the image more than a tenth of a voxel apart, which rounding does not explain.
void compareForms(const Affine& sform, const nifti_image& header, ImageFile& file) {
  const Affine qform = affineOf(header.qto_xyz);
  if (!qform.valid()) return;
  const double distance = apart(sform, qform, file.image.lattice.size);
  const double least = std::min({sform.step[0].length(), sform.step[1].length(), sform.step[2].length()});
  if (distance <= 0.1 * least) return;
  std::ostringstream text;
  text << "its sform (code " << header.sform_code << ") and its qform (code " << header.qform_code
       << ") place it up to " << distance << " apart: the sform was taken";
  tellPlace(file, "image.forms-disagree", text.str());
}

std::string spaceOfCode(int code) {
  switch (code) {
    case NIFTI_XFORM_ALIGNED_ANAT:
      return "aligned to another image";
    case NIFTI_XFORM_TALAIRACH:
      return "in Talairach space";
    case NIFTI_XFORM_MNI_152:
      return "in MNI 152 space";
    case NIFTI_XFORM_TEMPLATE_OTHER:
      return "in a template's space";
    default:
      return "";
  }
}

/// Keeps both transforms as they are, for what is written on the same voxels.
void keepForms(const nifti_image& header, ImageFile& file) {
  NiftiForms forms;
  // A transform that places nothing is not handed on.
  if (header.sform_code > 0 && affineOf(header.sto_xyz).valid()) forms.sformCode = header.sform_code;
  if (header.qform_code > 0 && affineOf(header.qto_xyz).valid()) forms.qformCode = header.qform_code;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) forms.sform[r][c] = header.sto_xyz.m[r][c];
  const double quaternion[] = {header.quatern_b, header.quatern_c, header.quatern_d},
               offset[] = {header.qoffset_x, header.qoffset_y, header.qoffset_z},
               spacing[] = {header.dx, header.dy, header.dz};
  for (int d = 0; d < 3; ++d)
    forms.quaternion[d] = quaternion[d], forms.offset[d] = offset[d], forms.spacing[d] = std::abs(spacing[d]);
  forms.handedness = header.qfac < 0 ? -1 : 1;
  file.header.forms = forms;
}

void placeByForms(const std::string& path, const nifti_image& header, const ImageOptions& options,
                  ImageFile& file, Affine& affine) {
  int code = 0;
  if (header.sform_code > 0) {
    affine = affineOf(header.sto_xyz);
    if (affine.valid()) {
      code = header.sform_code;
      if (header.qform_code > 0) compareForms(affine, header, file);
    } else {
      tellPlace(file, "image.sform-damaged", "its sform is no valid affine (it flattens space)");
    }
  }
  if (!code && header.qform_code > 0) {
    affine = affineOf(header.qto_xyz);
    if (affine.valid()) code = header.qform_code;
    if (code && header.sform_code > 0) file.notes.back().text += ": the qform was taken";
  }
  if (code) {
    const std::string space = spaceOfCode(code);
    if (!space.empty()) file.about += (file.about.empty() ? "" : ", ") + space;
    keepForms(header, file);
    return;
  }
  Vec3d spacing(std::abs(header.dx), std::abs(header.dy), std::abs(header.dz));
  const std::string codes = "sform (code " + std::to_string(header.sform_code) + "), its qform (code " +
                            std::to_string(header.qform_code) + ")";
  const bool damaged = header.sform_code > 0 || header.qform_code > 0 || !areSizes(spacing);
  if (damaged && !options.force)
    throw IoError(path, "no valid affine: none of its " + codes +
                            " and its voxel spacing places the voxels in space; --force takes " +
                            "axes as right, front, up, and its spacing or that of --spacing, else 1 mm");
  if (damaged) {
    if (!areSizes(spacing)) spacing = options.spacing[0] > 0 ? options.spacing : Vec3d(1.0);
    tellForced(file, "none of its " + codes + " and its voxel spacing places the voxels in space: ", spacing);
  } else {
    tellPlace(
        file, "image.place-unknown",
        "it does not say where it lies (sform and qform codes are 0): taken from its voxel spacing, axes as "
        "right, front, up");
  }
  affine = {Vec3d(0.0), {{-spacing[0], 0, 0}, {0, -spacing[1], 0}, {0, 0, spacing[2]}}};
}

/// Directions of the axes by Analyze's `orient`, in LPS, and in words.
struct AnalyzeAxes {
  int axis[3], sign[3];
  const char* words;
};
constexpr AnalyzeAxes kAnalyzeAxes[] = {
    {{0, 1, 2}, {1, -1, 1}, "left, front, up"},    {{0, 2, 1}, {1, 1, -1}, "left, up, front"},
    {{1, 2, 0}, {-1, 1, 1}, "front, up, left"},    {{0, 1, 2}, {1, 1, 1}, "left, back, up"},
    {{0, 2, 1}, {1, -1, -1}, "left, down, front"}, {{1, 2, 0}, {-1, -1, 1}, "front, down, left"},
};

void placeAnalyze(const std::string& path, const nifti_image& header, const ImageOptions& options,
                  ImageFile& file, Affine& affine) {
  const nifti_analyze75 raw = analyzeHeaderOf(header.fname);
  int orient = raw.orient;
  if (orient < 0 || orient > 5) {
    const std::string what = "is Analyze 7.5 of orientation " + std::to_string(orient) + "; there are 0 to 5";
    if (!options.force)
      throw IoError(path, what + ", so where its axes point is not known (--force takes 0)");
    tellPlace(file, kGeometryForced, "--force: " + what + ": taken as 0");
    orient = 0;
  }
  Vec3d spacing(std::abs(header.dx), std::abs(header.dy), std::abs(header.dz));
  if (!areSizes(spacing)) {
    if (!options.force && options.spacing[0] == 0)
      throw IoError(path,
                    "is Analyze 7.5 without voxel sizes; --spacing X,Y,Z (millimetres) sets them, --force "
                    "takes 1 mm");
    const bool given = options.spacing[0] > 0;
    spacing = given ? options.spacing : Vec3d(1.0);
    if (given)
      tellPlace(file, "image.spacing-given",
                "is Analyze 7.5 without voxel sizes: they are those of --spacing", Severity::kNote);
    else
      tellPlace(file, kGeometryForced,
                "--force: is Analyze 7.5 without voxel sizes: taken as 1 mm, so that no length is right");
  }
  // SPM keeps the voxel of the origin, counted from 1, where Analyze has the name of who made the file.
  std::int16_t origin[3];
  std::memcpy(origin, raw.originator, sizeof origin);
  const openvdb::Coord& size = file.image.lattice.size;
  bool given = origin[0] || origin[1] || origin[2];
  for (int d = 0; d < 3; ++d) given &= origin[d] > -size[d] && origin[d] < 2 * size[d];
  const AnalyzeAxes& axes = kAnalyzeAxes[orient];
  affine.origin = Vec3d(0.0);
  for (int d = 0; d < 3; ++d) {
    affine.step[d] = Vec3d(0.0);
    affine.step[d][axes.axis[d]] = axes.sign[d] * spacing[d];
    affine.origin -= affine.step[d] * (given ? origin[d] - 1.0 : 0.5 * (size[d] - 1));
  }
  std::string text = "is Analyze 7.5, which does not tell left from right for sure: axes are taken as " +
                     std::string(axes.words) + " (its orientation " + std::to_string(orient) +
                     "), the origin as " + (given ? "SPM's" : "its middle");
  const auto mat = std::filesystem::path(header.fname).replace_extension(".mat");
  if (std::filesystem::exists(mat))
    text += "; " + mat.string() + ", which may place it elsewhere, is not read";
  tellPlace(file, "image.place-unknown", text);
}

/// The time from volume to volume, where the fourth axis is one of time, and the only one beside space.
void readTimeStep(const nifti_image& header, ImageHeader& to) {
  const double step = std::abs(header.dt);
  const int unit = header.time_units;
  const double seconds = unit == NIFTI_UNITS_MSEC ? 1e-3 : unit == NIFTI_UNITS_USEC ? 1e-6 : 1;
  const bool isTime = seconds != 1 || unit == NIFTI_UNITS_SEC || unit == NIFTI_UNITS_UNKNOWN;
  const bool alone = header.nu <= 1 && header.nv <= 1 && header.nw <= 1;
  if (header.nt < 2 || !alone || !isTime || !(step > 0) || !std::isfinite(step)) return;
  to.timeStep = step * seconds, to.inSeconds = unit != NIFTI_UNITS_UNKNOWN;
}

}  // namespace

nifti_analyze75 analyzeHeaderOf(const std::string& path) {
  nifti_analyze75 raw;
  static_assert(sizeof raw == 348);
  PackedBytes file(path, 0, nifti_is_gzfile(path.c_str()) ? PackedAs::kDeflate : PackedAs::kPlain);
  if (file.read(&raw, sizeof raw) < sizeof raw) throw IoError(path, "is truncated: it has no whole header");
  if (raw.dim[0] < 1 || raw.dim[0] > 7) {
    nifti_swap_as_analyze(&raw);
    swapBytes(raw.originator, sizeof raw.originator / 2, 2);  // SPM's numbers of 16 bits
  }
  return raw;
}

void placeNifti(const std::string& path, const nifti_image& header, const ImageOptions& options,
                ImageFile& file) {
  Affine affine{};
  double unit = 1;
  if (header.nifti_type == NIFTI_FTYPE_ANALYZE) {
    placeAnalyze(path, header, options, file, affine);
  } else {
    placeByForms(path, header, options, file, affine);
    const int code = header.xyz_units;
    const std::string name = code == NIFTI_UNITS_METER ? "m" : code == NIFTI_UNITS_MICRON ? "um" : "";
    unit = millimetresOf(name).value_or(1);
    noteUnits({name}, file.notes);
    if (code != NIFTI_UNITS_UNKNOWN && code != NIFTI_UNITS_MM && name.empty())
      noteUnits({"code " + std::to_string(code)}, file.notes);
  }
  file.image.lattice.origin = affine.origin * unit;
  for (int d = 0; d < 3; ++d) file.image.lattice.step[d] = affine.step[d] * unit;
  if (header.nifti_type != NIFTI_FTYPE_ANALYZE) readTimeStep(header, file.header);
  if (!file.header.forms) return;
  NiftiForms& forms = *file.header.forms;
  forms.lattice = file.image.lattice;
  for (int d = 0; d < 3; ++d) {
    for (double& number : forms.sform[d]) number *= unit;
    forms.offset[d] *= unit, forms.spacing[d] *= unit;
  }
}

}  // namespace slicemorph
