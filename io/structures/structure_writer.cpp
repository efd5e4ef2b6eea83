#include "engine/numerics/readable.h"
#include "io/atomic_file.h"
#include "io/format.h"
#include "io/image/itk_library.h"
#include "io/paths.h"
#include "io/structures/plane_outlines.h"
#include "io/structures/seg_nrrd.h"
#include "io/structures/structure_data.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <set>

namespace slicemorph {
namespace {

constexpr size_t kLongString = 64;  // letters of a DICOM "LO" (PS3.5 6.2)

/// A name without what DICOM's texts cannot hold: at most 64 letters, no control characters, no backslash.
std::string nameForDicom(const std::string& name) {
  std::string kept;
  size_t letters = 0;
  for (const char c : name) {
    const unsigned char byte = static_cast<unsigned char>(c);
    if ((byte & 0xc0) != 0x80 && ++letters > kLongString) break;
    kept += byte < 0x20 || c == '\\' ? '_' : c;
  }
  while (!kept.empty() && kept.back() == ' ') kept.pop_back();
  return kept.empty() ? "unnamed" : kept;
}

ObjectHead headOf(const StructureSet& set, Notes& notes) {
  ObjectHead head{set, {}, {}, {}};
  for (const StructureShape& shape : set.structures) {
    head.names.push_back(nameForDicom(shape.name));
    if (head.names.back() != shape.name)
      notes.emplace_back("structures.name-changed", Severity::kNote, shape.name,
                         "is named '" + head.names.back() + "', as DICOM allows");
  }
  // https://reproducible-builds.org/specs/source-date-epoch
  const char* epoch = std::getenv("SOURCE_DATE_EPOCH");
  const std::time_t now = epoch ? std::time_t(std::atoll(epoch)) : std::time(nullptr);
  std::tm parts = {};
  epoch ? gmtime_r(&now, &parts) : localtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%d", &parts), head.date = text;
  std::strftime(text, sizeof text, "%H%M%S", &parts), head.time = text;
  return head;
}

/// Throws for planes whose directions are not at right angles, which DICOM cannot say.
void checkRightAngles(const std::string& path, const std::vector<ImagePlane>& planes) {
  if (planes.empty()) throw InputError(path, "there are no planes to put the structures on");
  const double lean = planes[0].step[0].unit().dot(planes[0].step[1].unit());
  if (std::abs(lean) > 1e-4)
    throw InputError(path, "the rows and columns of the voxels are not at right angles (cosine " +
                               std::to_string(lean) +
                               "), which DICOM cannot hold; use .seg.nrrd, or --like an image");
}

/// Leaves out structures by a mark for each, with a note.
StructureSet withoutEmpty(const StructureSet& set, const std::vector<bool>& empty, Notes& notes) {
  StructureSet kept{set.input, set.planes, {}, set.source};
  for (size_t s = 0; s < set.structures.size(); ++s) {
    if (!empty[s])
      kept.structures.push_back(set.structures[s]);
    else
      notes.emplace_back("structures.empty", Severity::kWarning, set.structures[s].name,
                         "left out: nothing of it lies on the planes");
  }
  return kept;
}

[[noreturn]] void refuseNothing(const std::string& path) {
  throw InputError(
      path,
      "none of the structures lies on the planes that it is to be drawn on; are these of the same "
      "patient and frame of reference?");
}

/// Sets the bits of the pixels inside, from bit `at` on.
void packInside(const std::vector<float>& values, size_t at, std::string& bits) {
  for (size_t i = 0; i < values.size(); ++i, ++at)
    if (values[i] < 0) bits[at / 8] = char(static_cast<unsigned char>(bits[at / 8]) | 1u << at % 8);
}

/// One frame for each plane that a segment lies on. The first segment also has the first and the last plane, so that
/// readers find the whole volume's extent.
SegmentFrames segmentFrames(const StructureSet& set, std::vector<bool>& empty) {
  const size_t pixels = set.planes[0].count(), last = set.planes.size() - 1;
  SegmentFrames content;
  size_t segment = 0;
  empty.assign(set.structures.size(), true);
  for (size_t s = 0; s < set.structures.size(); ++s) {
    const size_t framesBefore = content.frames.size(), bytesBefore = content.bits.size();
    for (size_t p = 0; p <= last; ++p) {
      const std::vector<float> values = set.structures[s].onPlane(set.planes[p]);
      const bool any = std::any_of(values.begin(), values.end(), [](float v) { return v < 0; });
      if (!any && !(segment == 0 && (p == 0 || p == last))) continue;
      const size_t at = content.frames.size() * pixels;
      content.bits.resize((at + pixels + 7) / 8);
      packInside(any ? values : std::vector<float>(), at, content.bits);
      content.frames.emplace_back(segment, p);
      if (any) empty[s] = false;
    }
    if (!empty[s]) {
      ++segment;
      continue;
    }
    content.frames.resize(framesBefore), content.bits.resize(bytesBefore);
  }
  return content;
}

Notes writeSegmentation(const std::string& path, const StructureSet& set) {
  checkRightAngles(path, set.planes);
  const ImagePlane& first = set.planes[0];
  if (std::max(first.size[0], first.size[1]) > std::numeric_limits<std::uint16_t>::max())
    throw InputError(path, "DICOM holds at most 65535 rows and columns");
  Notes notes;
  std::vector<bool> empty;
  SegmentFrames content = segmentFrames(set, empty);
  if (content.frames.empty()) refuseNothing(path);
  if (content.bits.size() > std::numeric_limits<std::uint32_t>::max() - 1)
    throw InputError(path, "its frames would take " + readableBytes(double(content.bits.size())) +
                               ", and DICOM holds less than 4 GiB; write fewer structures a file");
  const StructureSet kept = withoutEmpty(set, empty, notes);
  const ObjectHead head = headOf(kept, notes);
  AtomicFile file(path);
  file.write(itkReaders().segmentation(head, content));
  file.commit();
  return notes;
}

/// The plane with pixels as fine as a structure's detail; the plane's own are among them.
ImagePlane tracedOn(const ImagePlane& plane, double detail) {
  constexpr int kFinest = 4;
  ImagePlane fine = plane;
  if (!(detail > 0)) return fine;
  for (int d = 0; d < 2; ++d) {
    const int parts = std::clamp(int(std::ceil(plane.step[d].length() / detail - 0.01)), 1, kFinest);
    fine.step[d] = plane.step[d] / parts;
    fine.size[d] = (plane.size[d] - 1) * parts + 1;
  }
  return fine;
}

/// Numbers of regions are theirs alone, from 1 on.
void numberRegions(StructureSet& set) {
  std::set<int> taken;
  for (const StructureShape& shape : set.structures)
    if (shape.number < 1 || !taken.insert(shape.number).second) {
      for (size_t s = 0; s < set.structures.size(); ++s) set.structures[s].number = int(s) + 1;
      return;
    }
}

Notes writeStructureSet(const std::string& path, const StructureSet& set) {
  checkRightAngles(path, set.planes);
  Notes notes;
  StructureOutlines content;
  std::vector<bool> empty;
  for (const StructureShape& shape : set.structures) {
    std::vector<StructureOutline> outlines;
    for (size_t p = 0; p < set.planes.size(); ++p) {
      const ImagePlane fine = tracedOn(set.planes[p], shape.detail);
      const std::vector<float> values = shape.onPlane(fine);
      if (values.empty()) continue;
      for (std::vector<Vec3d>& points : outlinesOn(fine, values)) outlines.push_back({p, std::move(points)});
    }
    empty.push_back(outlines.empty());
    if (!outlines.empty()) content.push_back(std::move(outlines));
  }
  if (content.empty()) refuseNothing(path);
  StructureSet kept = withoutEmpty(set, empty, notes);
  numberRegions(kept);
  const ObjectHead head = headOf(kept, notes);
  AtomicFile file(path);
  file.write(itkReaders().structureSet(head, content));
  file.commit();
  return notes;
}

}  // namespace

bool isStructureOutput(const std::string& path) {
  const Format* format = formatToWrite(path);
  return format && format->writeStructures;
}

Notes writeDicomStructures(const std::string& path, const StructureSet& set) {
  return endsWith(path, ".rt.dcm") ? writeStructureSet(path, set) : writeSegmentation(path, set);
}

Notes writeStructures(const std::string& path, const StructureSet& set) {
  const Format* format = formatToWrite(path);
  if (!format || !format->writeStructures)
    throw InputError(path, "cannot hold structures; use .seg.dcm, .rt.dcm or .seg.nrrd");
  return format->writeStructures(path, set);
}

}  // namespace slicemorph
