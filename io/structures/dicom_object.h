#pragma once

#include "io/structures/dicom_set.h"
#include "io/structures/structure_data.h"

namespace slicemorph {

/// What all objects of structures have: patient, study, series, equipment, frame of reference. `content`: what the UIDs
/// are made of; `modality`: SEG, RTSTRUCT.
struct DicomObject {
  DicomSet set;
  ContentUids uids;
  std::string study, frameOfReference;
};
DicomObject dicomObject(const ObjectHead& head, const char* sopClass, const char* modality,
                        const std::string& content);

/// A reference to the image on a plane, in an item of its own.
DicomSet imageReference(const ImagePlane& plane);

/// Everything of a head that tells two objects apart, as text.
std::string fingerprintOf(const ObjectHead& head);

}  // namespace slicemorph
