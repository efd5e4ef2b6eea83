#include "io/image/chosen_volume.h"

#include "io/image/image_formats.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <sstream>
#include <utility>

namespace slicemorph {
namespace {

/// Of length 1; 0 where the vector has no direction.
Vec3d unitOrNone(const Vec3d& v) { return v.length() > 0 ? v / v.length() : Vec3d(0.0); }

std::string textOf(const Vec3d& v) {
  std::ostringstream text;
  text << "(" << v[0] << ", " << v[1] << ", " << v[2] << ")";
  return text.str();
}

}  // namespace

int volumeOf(const InputSpec& input) {
  const std::string& chosen = input.selection;
  if (chosen.empty()) return kNoVolume;
  const bool digits =
      std::all_of(chosen.begin(), chosen.end(), [](unsigned char c) { return std::isdigit(c); });
  if (!digits || chosen.size() > 9)
    throw InputError(input.text, "'" + chosen + "' is no volume of the file; give its number, from 0");
  return std::stoi(chosen);
}

void checkVolume(const std::string& path, int volume, int volumes) {
  if (volume != kNoVolume && (volume < 0 || volume >= volumes))
    throw InputError(path, "has no volume " + std::to_string(volume) + "; it has " + std::to_string(volumes) +
                               ", numbered from 0");
}

void noteFirstVolume(const std::string& path, const std::string& kinds, ImageFile& file) {
  if (file.volumes < 2) return;
  file.notes.emplace_back("image.volume-chosen", Severity::kNote, "",
                          "took volume 0 of " + std::to_string(file.volumes) +
                              (kinds.empty() ? "" : ", which differ in " + kinds) + " (" + path +
                              ":N takes another)");
}

void noteLuminance(const std::string& path, ImageFile& file) {
  file.notes.emplace_back("image.colours-as-luminance", Severity::kNote, "",
                          "colours are taken as luminance (" + path + ":0, :1, :2 take red, green, blue)");
}

void noteRounded(RawType stored, ImageFile& file) {
  const auto* values = std::get_if<std::vector<double>>(&file.image.values);
  if (stored.kind == RawType::kFloat || stored.bytes < 8 || !values) return;
  const auto large =
      std::count_if(values->begin(), values->end(), [](double v) { return std::abs(v) >= 0x1p53; });
  if (large > 0)
    file.notes.emplace_back(
        "image.values-rounded", Severity::kWarning, "",
        std::to_string(large) + " of its values are whole numbers of 2^53 or more: rounded to doubles");
}

ImageValues luminanceOf(const std::function<ImageValues(int)>& colour) {
  constexpr double kWeights[] = {0.2126, 0.7152, 0.0722};
  std::vector<double> sum;
  ImageValues values;
  for (int c = 0; c < 3; ++c) {
    values = ImageValues();  // only one colour is in memory at once
    values = colour(c);
    std::visit(
        [&](const auto& from) {
          sum.resize(from.size());
          for (size_t i = 0; i < from.size(); ++i) sum[i] += kWeights[c] * double(from[i]);
        },
        values);
  }
  std::visit(
      [&](auto& to) {
        using T = typename std::decay_t<decltype(to)>::value_type;
        for (size_t i = 0; i < to.size(); ++i)
          to[i] = std::is_integral_v<T> ? T(std::lrint(sum[i])) : T(sum[i]);
      },
      values);
  return values;
}

TypeBy typeByOf(const ImageFile& file) { return file.volumes > 1 ? TypeBy::kRange : TypeBy::kValues; }

void addFlatAxes(ImageLattice& lattice, size_t given) {
  for (size_t d = given; d < 3; ++d) lattice.size[int(d)] = 1;
  if (given == 1) {
    const Vec3d& x = lattice.step[0];
    const int least = std::abs(x[0]) <= std::abs(x[1]) ? (std::abs(x[0]) <= std::abs(x[2]) ? 0 : 2)
                                                       : (std::abs(x[1]) <= std::abs(x[2]) ? 1 : 2);
    Vec3d other(0.0);
    other[least] = 1;
    lattice.step[1] = unitOrNone(other - x * (x[least] / x.lengthSqr()));
  }
  if (given < 3) lattice.step[2] = unitOrNone(lattice.step[0].cross(lattice.step[1]));
}

void checkPlace(const std::string& path, bool force, ImageFile& file) {
  ImageLattice& lattice = file.image.lattice;
  // From the directions alone, for the product of tiny or huge steps is no number.
  const Vec3d spacing = lattice.spacing();
  Vec3d direction[3];
  for (int d = 0; d < 3; ++d) direction[d] = unitOrNone(lattice.step[d]);
  const double flat = direction[0].dot(direction[1].cross(direction[2]));
  if (!std::isfinite(spacing.length()) || !(std::abs(flat) > 1e-6)) {
    const std::string what = "its steps from voxel to voxel, " + textOf(lattice.step[0]) + ", " +
                             textOf(lattice.step[1]) + " and " + textOf(lattice.step[2]) + ", flatten space";
    if (!force)
      throw IoError(path,
                    what +
                        "; they must be finite, independent and not 0 (--force takes axes as left, back, "
                        "up, as long as the steps)");
    for (int d = 0; d < 3; ++d) {
      lattice.step[d] = Vec3d(0.0);
      lattice.step[d][d] = std::isfinite(spacing[d]) && spacing[d] > 0 ? spacing[d] : 1;
    }
    file.notes.emplace_back(kGeometryForced, Severity::kWarning, "",
                            "--force: " + what + ": axes are taken as left, back, up, voxels of " +
                                textOf(lattice.spacing()) + " mm");
  }
  if (std::isfinite(lattice.origin.length())) return;
  const std::string what = "its origin " + textOf(lattice.origin) + " is not finite";
  if (!force) throw IoError(path, what + " (--force places its first voxel at 0, 0, 0)");
  lattice.origin = Vec3d(0.0);
  file.notes.emplace_back(kGeometryForced, Severity::kWarning, "",
                          "--force: " + what + ": its first voxel is placed at 0, 0, 0");
}

void readOrRefuse(const std::string& path, VolumeReader& reader, void* to, size_t count, RawType type) {
  const size_t got = reader.read(to, count);
  if (got == count) return;
  throw IoError(path, "is truncated or damaged: of " + std::to_string(count * size_t(type.bytes)) +
                          " bytes of voxels only " + std::to_string(got * size_t(type.bytes)) + " are there");
}

void refuseWideSlices(const std::string& path) {
  throw IoError(path, "has values beyond 32 bits, for which it must be read as a whole: give more --memory");
}

ImageSlices slicesOf(const std::string& path, ImageFile file, RawType type, VolumeReader reader) {
  const size_t each = size_t(file.image.lattice.size[0]) * size_t(file.image.lattice.size[1]);
  auto shared = std::make_shared<VolumeReader>(std::move(reader));
  const TypeBy by = typeByOf(file);
  file.image.values = noValues(type, by);
  const size_t kind = file.image.values.index();
  return {std::move(file), bytesWhileRead(type), [=] {
            ImageValues values = readValues(
                type, each, [&](void* to) { readOrRefuse(path, *shared, to, each, type); }, by);
            if (values.index() != kind) refuseWideSlices(path);
            return values;
          }};
}

}  // namespace slicemorph
