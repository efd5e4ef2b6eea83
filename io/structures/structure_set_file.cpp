#include "io/structures/dicom_object.h"

#include <cstdio>

namespace slicemorph {
namespace {

constexpr const char* kStudyComponent = "1.2.840.10008.3.1.2.3.1";  // detached study management

/// Coordinates to a tenth of a micrometre, which a decimal string of 16 characters holds up to 100 km.
std::string coordinatesOf(const std::vector<Vec3d>& points) {
  std::string text;
  char number[40];
  for (const Vec3d& p : points)
    for (int d = 0; d < 3; ++d) {
      std::snprintf(number, sizeof number, "%.4f", p[d]);
      if (!text.empty()) text += '\\';
      text += number;
    }
  return text;
}

DicomSet contourOf(const StructureOutline& outline, const ImagePlane& plane, size_t number) {
  DicomSet contour;
  if (!plane.sopInstance.empty()) contour.item(0x30060016, imageReference(plane));
  contour.text(0x30060042, "CLOSED_PLANAR").text(0x30060046, std::to_string(outline.points.size()));
  contour.text(0x30060048, std::to_string(number)).text(0x30060050, coordinatesOf(outline.points));
  return contour;
}

/// The frame of reference with all images of the source.
DicomSet frameOfReference(const ObjectHead& head, const DicomObject& object) {
  DicomSet frame;
  frame.text(0x00200052, object.frameOfReference);
  if (!head.set.source) return frame;
  std::vector<DicomSet> images;
  for (const ImagePlane& plane : head.set.source->planes) images.push_back(imageReference(plane));
  DicomSet series, study;
  series.text(0x0020000e, head.set.source->series).items(0x30060016, images);
  study.text(0x00081150, kStudyComponent).text(0x00081155, object.study).item(0x30060014, series);
  return frame.item(0x30060012, study);
}

}  // namespace

std::string structureSetFile(const ObjectHead& head, const StructureOutlines& content) {
  std::string all;
  for (const std::vector<StructureOutline>& outlines : content)
    for (const StructureOutline& outline : outlines) all += coordinatesOf(outline.points) + "\n";
  DicomObject object = dicomObject(head, "1.2.840.10008.5.1.4.1.1.481.3", "RTSTRUCT", all);
  std::vector<DicomSet> regions, contours, observations;
  for (size_t s = 0; s < content.size(); ++s) {
    const StructureShape& shape = head.set.structures[s];
    const std::string number = std::to_string(shape.number);
    DicomSet region, contour, observation;
    region.text(0x30060022, number).text(0x30060024, object.frameOfReference);
    region.text(0x30060026, head.names[s]).text(0x30060036, "SEMIAUTOMATIC");
    regions.push_back(region);
    std::vector<DicomSet> outlines;
    for (const StructureOutline& outline : content[s])
      outlines.push_back(contourOf(outline, head.set.planes[outline.plane], outlines.size() + 1));
    contour.text(0x3006002a, std::to_string(shape.color[0]) + "\\" + std::to_string(shape.color[1]) + "\\" +
                                 std::to_string(shape.color[2]));
    contour.items(0x30060040, outlines).text(0x30060084, number);
    contours.push_back(contour);
    observation.text(0x30060082, std::to_string(s + 1)).text(0x30060084, number);
    observation.text(0x300600a4, "").text(0x300600a6, "");
    observations.push_back(observation);
  }
  DicomSet& set = object.set;
  set.text(0x00081070, "").text(0x0008103e, "Structures");
  set.text(0x30060002, "slicemorph").text(0x30060008, head.date).text(0x30060009, head.time);
  set.item(0x30060010, frameOfReference(head, object));
  set.items(0x30060020, regions).items(0x30060039, contours).items(0x30060080, observations);
  set.text(0x300e0002, "UNAPPROVED");
  return set.file(true);
}

}  // namespace slicemorph
