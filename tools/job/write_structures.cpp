#include "tools/job/write_structures.h"

#include "engine/volume/image_shape.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"
#include "tools/job/image_lattice.h"
#include "tools/job/option_values.h"
#include "tools/job/structure_planes.h"

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
  if (!job.source.empty()) set.source = readDicomSource(job.source, job.image.force);
  const bool onSource = set.source && job.like.empty() && endsWith(job.output, ".rt.dcm");
  set.planes = onSource ? set.source->planes : planesOf(labels->lattice);
  for (const auto& [label, box] : boxesOfLabels(*labels)) {
    StructureShape shape;
    shape.number = int(label), shape.name = "label_" + std::to_string(label);
    shape.color = colorOfStructure(shape.number);
    for (const LabelName& own : job.labels)
      if (own.label == shape.number) {
        if (!own.name.empty()) shape.name = own.name;
        shape.color = own.color.value_or(shape.color);
      }
    shape.onPlane = labelOnPlane(labels, label, box);
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
  if (!job.source.empty()) set.source = readDicomSource(job.source, job.image.force);
  set.planes = !job.like.empty() ? planesOf(voxelsLike(job.like, job.image).lattice)
               : set.source      ? set.source->planes
                                 : planesOf(otherwise);
  Notes notes;
  const openvdb::BBoxd all = boxOf(set.planes);
  for (const NamedSurface& surface : surfaces) {
    StructureShape shape;
    shape.number = surface.number, shape.name = surface.name, shape.color = colorOfStructure(surface.number);
    // The grid's box has the narrow band around the surface.
    openvdb::BBoxd inner = boxOfGrid(*surface.grid);
    inner.expand(-double(kHalfWidth) * surface.grid->voxelSize()[0]);
    if (!all.isInside(inner))
      notes.emplace_back("structures.beyond-planes", Severity::kWarning, surface.name,
                         "reaches beyond the slices that it is put on: what lies outside them is cut off");
    shape.onPlane = surfaceOnPlane(surface.grid), shape.detail = surface.grid->voxelSize()[0];
    set.structures.push_back(std::move(shape));
  }
  const Notes own = writeSet(job, std::move(set));
  notes.insert(notes.end(), own.begin(), own.end());
  return notes;
}

}  // namespace slicemorph
