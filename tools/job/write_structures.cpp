#include "tools/job/write_structures.h"

#include "engine/volume/image_grid.h"
#include "engine/volume/image_shape.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/image_lattice.h"
#include "tools/job/option_values.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

namespace slicemorph {
namespace {

// A slice of the source lies on a plane within this distance, millimetres, and 0.08 degrees.
constexpr double kOnSourcePlane = 0.05, kAlongSource = 1 - 1e-6;

std::map<std::int64_t, std::string> namesOfLabels(const std::string& text) {
  std::map<std::int64_t, std::string> names;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find(',', at), text.size());
    const std::string one = text.substr(at, end - at);
    const size_t equals = one.find('=');
    char* rest = nullptr;
    const long long label = std::strtoll(one.c_str(), &rest, 10);
    if (equals == std::string::npos || rest != one.c_str() + equals || equals == 0 ||
        equals + 1 == one.size())
      throw InputError("--names " + text + ": '" + one + "' is no NUMBER=NAME, as in 1=Heart,2=Left lung");
    names[label] = one.substr(equals + 1);
    at = end + 1;
  }
  return names;
}

/// The boxes of all labels, in voxels.
std::map<std::int64_t, openvdb::CoordBBox> boxesOfLabels(const Image& image) {
  std::map<std::int64_t, openvdb::CoordBBox> boxes;
  const openvdb::Coord n = image.lattice.size;
  std::visit(
      [&](const auto& values) {
        for (int k = 0; k < n[2]; ++k)
          for (int j = 0; j < n[1]; ++j) {
            const auto* row = &values[image.lattice.index(0, j, k)];
            for (int i = 0; i < n[0];) {
              const int from = i++;
              while (i < n[0] && row[i] == row[from]) ++i;
              const std::int64_t label = std::llround(double(row[from]));
              if (label == 0) continue;
              openvdb::CoordBBox& box = boxes[label];
              box.expand(openvdb::Coord(from, j, k)), box.expand(openvdb::Coord(i - 1, j, k));
            }
          }
      },
      image.values);
  return boxes;
}

/// One label of a map on any plane: half minus its share, linear between voxels. On the map's own slices it is -0.5 at the
/// label's pixels and 0.5 at the others.
class LabelOnPlane {
 public:
  LabelOnPlane(std::shared_ptr<const Image> image, std::int64_t label, const openvdb::CoordBBox& box)
      : image_(std::move(image)), label_(label), box_(box), voxel_(image_->lattice) {}

  std::vector<float> operator()(const ImagePlane& plane) const {
    const Vec3d first = voxel_(plane.origin);
    const Vec3d step[2] = {voxel_.inverse * plane.step[0], voxel_.inverse * plane.step[1]};
    if (!isNear(first, step, plane)) return {};
    if (isOwn(first, step))
      return std::visit([&](const auto& values) { return copied(values, plane, first); }, image_->values);
    return std::visit([&](const auto& values) { return sampled(values, plane, first, step); },
                      image_->values);
  }

 private:
  static constexpr double kRounding = 1e-4;  ///< of voxels

  /// Whether the plane comes nearer than a voxel to the label's box along the map's axes.
  bool isNear(const Vec3d& first, const Vec3d (&step)[2], const ImagePlane& plane) const {
    for (int d = 0; d < 3; ++d) {
      double low = first[d], high = first[d];
      for (int s = 0; s < 2; ++s) {
        const double reach = step[s][d] * (plane.size[s] - 1);
        low += std::min(reach, 0.0), high += std::max(reach, 0.0);
      }
      if (high < box_.min()[d] - 1 || low > box_.max()[d] + 1) return false;
    }
    return true;
  }

  /// Whether the plane's pixels are voxels of one of the map's slices.
  bool isOwn(const Vec3d& first, const Vec3d (&step)[2]) const {
    constexpr double kPixel = 1e-7;  // of a voxel, from a pixel to the next: 1e-4 over a thousand
    for (int d = 0; d < 3; ++d)
      if (std::abs(first[d] - std::round(first[d])) > kRounding || std::abs(step[0][d] - (d == 0)) > kPixel ||
          std::abs(step[1][d] - (d == 1)) > kPixel)
        return false;
    return true;
  }

  template <typename T>
  std::vector<float> copied(const std::vector<T>& values, const ImagePlane& plane, const Vec3d& first) const {
    const openvdb::Coord at = openvdb::Coord::round(first);
    std::vector<float> result;
    if (at[2] < box_.min()[2] || at[2] > box_.max()[2]) return result;
    result.assign(plane.count(), 0.5f);
    for (int j = std::max(box_.min()[1] - at[1], 0); j <= std::min(box_.max()[1] - at[1], plane.size[1] - 1);
         ++j)
      for (int i = std::max(box_.min()[0] - at[0], 0);
           i <= std::min(box_.max()[0] - at[0], plane.size[0] - 1); ++i)
        if (std::llround(double(values[image_->lattice.index(at[0] + i, at[1] + j, at[2])])) == label_)
          result[size_t(j) * size_t(plane.size[0]) + size_t(i)] = -0.5f;
    return result;
  }

  template <typename T>
  std::vector<float> sampled(const std::vector<T>& values, const ImagePlane& plane, const Vec3d& first,
                             const Vec3d (&step)[2]) const {
    std::vector<float> result(plane.count());
    tbb::parallel_for(0, plane.size[1], [&](int j) {
      for (int i = 0; i < plane.size[0]; ++i)
        result[size_t(j) * size_t(plane.size[0]) + size_t(i)] =
            float(0.5 - shareAt(values, first + double(i) * step[0] + double(j) * step[1]));
    });
    return result;
  }

  /// Share of the label at a position in voxels; nothing lies outside the map. Positions are whole numbers within what
  /// rounding leaves, so that voxels that coincide are exact.
  template <typename T>
  double shareAt(const std::vector<T>& values, const Vec3d& at) const {
    int low[3];
    double part[3];
    for (int d = 0; d < 3; ++d) {
      if (at[d] < box_.min()[d] - 1 || at[d] > box_.max()[d] + 1) return 0;
      low[d] = int(std::floor(at[d] + kRounding)), part[d] = std::max(at[d] - low[d], 0.0);
      if (part[d] < kRounding) part[d] = 0;
    }
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      double weight = 1;
      openvdb::Coord corner;
      for (int d = 0; d < 3; ++d) {
        const int up = c >> d & 1;
        weight *= up ? part[d] : 1 - part[d];
        corner[d] = low[d] + up;
      }
      if (weight > 0 && box_.isInside(corner) &&
          std::llround(double(values[image_->lattice.index(corner[0], corner[1], corner[2])])) == label_)
        sum += weight;
    }
    return sum;
  }

  std::shared_ptr<const Image> image_;
  std::int64_t label_;
  openvdb::CoordBBox box_;
  WorldToVoxel voxel_;
};

/// A level set on any plane: its distances, linear between voxels.
class SurfaceOnPlane {
 public:
  explicit SurfaceOnPlane(FloatGrid::ConstPtr grid)
      : grid_(std::move(grid)), box_(grid_->transform().indexToWorld(grid_->evalActiveVoxelBoundingBox())) {}

  std::vector<float> operator()(const ImagePlane& plane) const {
    openvdb::BBoxd reach;
    for (const double i : {0, plane.size[0] - 1})
      for (const double j : {0, plane.size[1] - 1}) reach.expand(plane.at(i, j));
    if (!reach.hasOverlap(box_)) return {};
    std::vector<float> result(plane.count());
    tbb::parallel_for(0, plane.size[1], [&](int j) {
      FloatGrid::ConstAccessor accessor = grid_->getConstAccessor();
      for (int i = 0; i < plane.size[0]; ++i)
        result[size_t(j) * size_t(plane.size[0]) + size_t(i)] =
            openvdb::tools::BoxSampler::sample(accessor, grid_->worldToIndex(plane.at(i, j)));
    });
    return result;
  }

  const openvdb::BBoxd& box() const { return box_; }

 private:
  FloatGrid::ConstPtr grid_;
  openvdb::BBoxd box_;
};

/// The box of the voxels of parallel planes, world: half a pixel and half a gap around their centres.
openvdb::BBoxd boxOf(const std::vector<ImagePlane>& planes) {
  openvdb::BBoxd box;
  const Vec3d half = 0.5 * gapOf(planes) * planes[0].normal();
  for (const ImagePlane* plane : {&planes.front(), &planes.back()})
    for (const double i : {-0.5, plane->size[0] - 0.5})
      for (const double j : {-0.5, plane->size[1] - 0.5})
        box.expand(plane->at(i, j) + half), box.expand(plane->at(i, j) - half);
  return box;
}

/// Names the source's images on the planes that lie on its slices. Throws InputError where source and planes lie apart.
void nameImages(const StructuresJob& job, StructureSet& set) {
  if (!set.source || set.planes.empty()) return;
  if (!boxOf(set.planes).hasOverlap(boxOf(set.source->planes)))
    throw InputError("--source " + job.source + ": its slices lie elsewhere than " + job.input +
                     "; is it another patient's, or another frame of reference?");
  size_t named = 0;
  for (ImagePlane& plane : set.planes)
    for (const ImagePlane& image : set.source->planes) {
      if (std::abs(image.normal().dot(plane.normal())) < kAlongSource ||
          std::abs((image.origin - plane.origin).dot(plane.normal())) > kOnSourcePlane)
        continue;
      plane.sopClass = image.sopClass, plane.sopInstance = image.sopInstance, plane.frame = image.frame;
      ++named;
      break;
    }
  if (named < set.planes.size())
    set.source->notes.emplace_back("structures.planes-between", Severity::kNote, job.source,
                                   std::to_string(set.planes.size() - named) + " of the " +
                                       std::to_string(set.planes.size()) +
                                       " planes lie on none of its slices: they name no image");
}

/// Throws InputError for names of labels that are not there.
void nameStructures(const StructuresJob& job, StructureSet& set) {
  std::map<std::int64_t, std::string> names = namesOfLabels(job.names);
  std::string list;
  for (StructureShape& shape : set.structures) {
    list += (list.empty() ? "" : ", ") + std::to_string(shape.number);
    const auto name = names.find(shape.number);
    if (name == names.end()) continue;
    shape.name = name->second;
    names.erase(name);
  }
  if (!names.empty())
    throw InputError("--names: there is no structure " + std::to_string(names.begin()->first) +
                     "; there are " + list);
}

Notes writeSet(const StructuresJob& job, StructureSet set) {
  nameStructures(job, set);
  nameImages(job, set);
  Notes notes = set.source ? set.source->notes : Notes();
  const Notes own = writeStructures(job.output, set);
  notes.insert(notes.end(), own.begin(), own.end());
  return notes;
}

}  // namespace

void checkStudyOutput(const std::string& path, const std::string& source, const std::string& names) {
  if (!isStructureOutput(path)) {
    const char* option = !source.empty() ? "--source" : !names.empty() ? "--names" : nullptr;
    if (option)
      throw InputError(std::string(option) + " " + (source.empty() ? names : source) +
                       " is for structures (.seg.dcm, .rt.dcm, .seg.nrrd); " + path + " is none");
    return checkOutput(OutputName(path).path(1));
  }
  if (OutputName(path).isSequence())
    throw InputError("-o " + path + ": one file holds all structures; leave out the ####");
  checkOutputPath(path);
}

Notes writeLabelStructures(const StructuresJob& job, std::shared_ptr<const Image> labels) {
  labelsOf(*labels);  // says what is no label
  StructureSet set;
  set.input = job.input;
  if (!job.source.empty()) set.source = readDicomSource(job.source);
  const bool onSource = set.source && job.like.empty() && endsWith(job.output, ".rt.dcm");
  set.planes = onSource ? set.source->planes : planesOf(labels->lattice);
  for (const auto& [label, box] : boxesOfLabels(*labels)) {
    StructureShape shape;
    shape.number = int(label), shape.name = "label_" + std::to_string(label);
    shape.color = colorOfStructure(shape.number);
    shape.onPlane = LabelOnPlane(labels, label, box);
    set.structures.push_back(std::move(shape));
  }
  if (set.structures.empty())
    throw InputError(job.input + ": the map has no label but 0: there is no structure to write");
  return writeSet(job, std::move(set));
}

Notes writeSurfaceStructures(const StructuresJob& job, const std::vector<NamedSurface>& surfaces,
                             const ImageLattice& otherwise) {
  StructureSet set;
  set.input = job.input;
  if (!job.source.empty()) set.source = readDicomSource(job.source);
  set.planes = !job.like.empty() ? planesOf(readImage(job.like, job.image).image.lattice)
               : set.source      ? set.source->planes
                                 : planesOf(otherwise);
  Notes notes;
  const openvdb::BBoxd all = boxOf(set.planes);
  for (const NamedSurface& surface : surfaces) {
    StructureShape shape;
    shape.number = surface.number, shape.name = surface.name, shape.color = colorOfStructure(surface.number);
    const SurfaceOnPlane onPlane(surface.grid);
    // The grid's box has the narrow band around the surface.
    openvdb::BBoxd inner = onPlane.box();
    inner.expand(-double(kHalfWidth) * surface.grid->voxelSize()[0]);
    if (!all.isInside(inner))
      notes.emplace_back("structures.beyond-planes", Severity::kWarning, surface.name,
                         "reaches beyond the slices that it is put on: what lies outside them is cut off");
    shape.onPlane = onPlane, shape.detail = surface.grid->voxelSize()[0];
    set.structures.push_back(std::move(shape));
  }
  const Notes own = writeSet(job, std::move(set));
  notes.insert(notes.end(), own.begin(), own.end());
  return notes;
}

}  // namespace slicemorph
