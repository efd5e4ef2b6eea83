#include "io/structures/dicom_object.h"

#include "io/image/dicom_color.h"

#include <map>

namespace slicemorph {
namespace {

std::vector<DicomSet> segmentsOf(const ObjectHead& head) {
  std::vector<DicomSet> segments;
  for (size_t s = 0; s < head.names.size(); ++s) {
    const StructureShape& shape = head.set.structures[s];
    DicomSet segment;
    segment.shorts(0x00620004, {std::uint16_t(s + 1)}).text(0x00620005, head.names[s]);
    segment.text(0x00620006, "label " + std::to_string(shape.number));
    segment.text(0x00620008, "SEMIAUTOMATIC").text(0x00620009, "slicemorph");
    segment.shorts(0x0062000d, dicomLabOf(shape.color));
    segment.code(0x00620003, "85756007", "SCT", "Tissue").code(0x0062000f, "85756007", "SCT", "Tissue");
    segments.push_back(segment);
  }
  return segments;
}

/// The two dimensions by which frames are told apart: segment and position.
void addDimensions(DicomSet& set, const std::string& organisation) {
  const auto index = [&](DicomTag tag, DicomTag group, const char* label) {
    return DicomSet()
        .text(0x00209164, organisation)
        .pointer(0x00209165, tag)
        .pointer(0x00209167, group)
        .text(0x00209421, label);
  };
  set.item(0x00209221, DicomSet().text(0x00209164, organisation));
  set.items(0x00209222,
            {index(0x0062000b, 0x0062000a, "segment"), index(0x00200032, 0x00209113, "position")});
}

DicomSet frameOf(const ImagePlane& plane, size_t segment, size_t at) {
  DicomSet frame;
  frame.item(0x00209111, DicomSet().longs(0x00209157, {std::uint32_t(segment + 1), std::uint32_t(at + 1)}));
  frame.item(0x00209113, DicomSet().point(0x00200032, plane.origin));
  frame.item(0x0062000a, DicomSet().shorts(0x0062000b, {std::uint16_t(segment + 1)}));
  if (plane.sopInstance.empty()) return frame;
  DicomSet source = imageReference(plane);
  source.code(0x0040a170, "121322", "DCM", "Source image for image processing operation");
  DicomSet derivation;
  derivation.item(0x00082112, source).code(0x00089215, "113076", "DCM", "Segmentation");
  return frame.item(0x00089124, derivation);
}

}  // namespace

std::string segmentationFile(const ObjectHead& head, const SegmentFrames& content) {
  const std::vector<ImagePlane>& planes = head.set.planes;
  std::string which;
  for (const auto& [segment, plane] : content.frames)
    which += std::to_string(segment) + "/" + std::to_string(plane) + " ";
  DicomObject object = dicomObject(head, "1.2.840.10008.5.1.4.1.1.66.4", "SEG", which + content.bits);
  DicomSet& set = object.set;
  set.text(0x00080008, "DERIVED\\PRIMARY").text(0x00080023, head.date).text(0x00080033, head.time);
  set.text(0x0008103e, "Segmentation").text(0x00200013, "1");
  set.text(0x00700080, "SEGMENTATION").text(0x00700081, "Made by slicemorph").text(0x00700084, "");
  set.shorts(0x00280002, {1})
      .text(0x00280004, "MONOCHROME2")
      .text(0x00280008, std::to_string(content.frames.size()));
  set.shorts(0x00280010, {std::uint16_t(planes[0].size[1])})
      .shorts(0x00280011, {std::uint16_t(planes[0].size[0])});
  set.shorts(0x00280100, {1}).shorts(0x00280101, {1}).shorts(0x00280102, {0}).shorts(0x00280103, {0});
  set.text(0x00282110, "00").text(0x00620001, "BINARY").items(0x00620002, segmentsOf(head));
  addDimensions(set, object.uids.of("dimensions"));
  const Vec3d x = planes[0].step[0], y = planes[0].step[1];
  const double gap = gapOf(planes);
  DicomSet measures;
  measures.decimals(0x00180050, {gap})
      .decimals(0x00180088, {gap})
      .decimals(0x00280030, {y.length(), x.length()});
  DicomSet shared;
  shared.item(0x00289110, measures);
  const Vec3d alongX = x.unit(), alongY = y.unit();
  shared.item(0x00209116, DicomSet().decimals(0x00200037, {alongX[0], alongX[1], alongX[2], alongY[0],
                                                           alongY[1], alongY[2]}));
  set.item(0x52009229, shared);
  std::vector<DicomSet> frames, references;
  std::vector<bool> used(planes.size());
  for (const auto& [segment, plane] : content.frames) {
    frames.push_back(frameOf(planes[plane], segment, plane));
    used[plane] = true;
  }
  set.items(0x52009230, frames);
  std::map<std::string, bool> named;  // images of several frames are named once
  for (size_t p = 0; p < planes.size(); ++p)
    if (used[p] && !planes[p].sopInstance.empty() && named.emplace(planes[p].sopInstance, true).second) {
      ImagePlane whole = planes[p];
      whole.frame = 0;
      references.push_back(imageReference(whole));
    }
  if (!references.empty())
    set.item(0x00081115, DicomSet().text(0x0020000e, head.set.source->series).items(0x0008114a, references));
  set.bytes(0x7fe00010, content.bits);
  return set.file(false);
}

}  // namespace slicemorph
