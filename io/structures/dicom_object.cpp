#include "io/structures/dicom_object.h"

namespace slicemorph {

DicomObject dicomObject(const ObjectHead& head, const char* sopClass, const char* modality,
                        const std::string& content) {
  const std::optional<DicomSource>& source = head.set.source;
  DicomObject object{{}, ContentUids(fingerprintOf(head) + modality + content), {}, {}};
  object.study = source ? source->study : object.uids.of("study");
  object.frameOfReference = source ? source->frameOfReference : object.uids.of("frame of reference");
  DicomSet& set = object.set;
  // Type 2: there, if only without a value.
  for (const DicomTag tag : {0x00100010, 0x00100020, 0x00100030, 0x00100040, 0x00080020, 0x00080030,
                             0x00080050, 0x00080090, 0x00200010, 0x00201040})
    set.text(tag, "");
  if (source)
    for (const auto& [tag, text] : source->texts) set.text(tag, text);
  set.text(0x00080005, "ISO_IR 192").text(0x00080016, sopClass).text(0x00080018, object.uids.of("instance"));
  set.text(0x00080012, head.date).text(0x00080013, head.time);
  set.text(0x00080060, modality).text(0x0020000d, object.study).text(0x0020000e, object.uids.of("series"));
  set.text(0x00200011, "1").text(0x00200052, object.frameOfReference);
  set.text(0x00080070, "slicemorph").text(0x00081090, "slicemorph").text(0x00181000, "1");
  set.text(0x00181020, SLICEMORPH_VERSION);
  return object;
}

DicomSet imageReference(const ImagePlane& plane) {
  DicomSet reference;
  reference.text(0x00081150, plane.sopClass).text(0x00081155, plane.sopInstance);
  if (plane.frame > 0) reference.text(0x00081160, std::to_string(plane.frame));
  return reference;
}

std::string fingerprintOf(const ObjectHead& head) {
  std::string text = head.date + head.time + head.set.input + "\n";
  if (head.set.source) text += head.set.source->series + "\n";
  for (size_t s = 0; s < head.names.size(); ++s)
    text += std::to_string(head.set.structures[s].number) + " " + head.names[s] + "\n";
  const auto add = [&](const Vec3d& v) {
    for (int d = 0; d < 3; ++d) text += decimalString(v[d]) + " ";
  };
  for (const ImagePlane& plane : head.set.planes)
    add(plane.origin), add(plane.step[0]), add(plane.step[1]), text += plane.sopInstance + "\n";
  return text;
}

}  // namespace slicemorph
